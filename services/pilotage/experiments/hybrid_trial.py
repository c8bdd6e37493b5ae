"""One ride of twenty cycles along the corridor of the paper, localized by the hybrid method."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.experiments.corridor_doors import (
    Corridor,
    corridor_of,
    floor_of,
    topology_of,
    walkable,
)
from pilotage.experiments.corridor_ride import CorridorRide, Look
from pilotage.experiments.hybrid_localization import (
    Correction,
    HybridLocalizer,
    HybridParams,
    Tracked,
)
from pilotage.experiments.outcome import Request
from pilotage.localizer.ekf_sight import walls_of_map
from pilotage.localizer.ekf_walls import Walls
from pilotage.localizer.line_ekf import GaussianPose
from pilotage.topology.topological_map import TopologicalMap

CYCLES = 20
WAY = 0.8
"""m from cycle to cycle."""
START = np.array([0.8, 0.0, 0.0])
START_SIGMAS = np.array([0.05, 0.05, 0.03])
"""m, m, rad: how well the start is known."""

PEOPLE = 8
"""In the 24 m of the corridor."""
PUSH, SPIN = 0.5, float(np.deg2rad(20.0))
"""m and rad of the collision."""

LEFT = 0.3
"""m past the first node at which it is pushed."""

LOOKS, PAUSE = 8, 1.0
"""Looks at most at a node where tracking has failed, and s in between: people walk on."""


@dataclass(frozen=True)
class Place:
    """The corridor of these experiments, its map and its topological map."""

    corridor: Corridor
    floor: OccupancyMap
    topology: TopologicalMap
    busy: OccupancyMap
    walls: Walls

    @classmethod
    def of(cls, corridor: Corridor) -> "Place":
        """Return a corridor with all that is known of it."""
        floor = floor_of(corridor)
        walls = walls_of_map(floor)
        return cls(corridor, floor, topology_of(corridor), walkable(corridor), walls)


def usual_place() -> Place:
    """Return the corridor of figure 4: 24 m, with doors on both sides and a hall at its end."""
    return Place.of(corridor_of(24.0, 0))


@dataclass(frozen=True)
class Conditions:
    """How a ride is made harder: `people` walk about; `collides` on the way to the second node.

    `corrects`: at nodes; `filter` and thresholds in `params`.
    """

    people: int = 0
    collides: bool = False
    corrects: bool = True
    params: HybridParams = field(default_factory=HybridParams)


@dataclass(frozen=True)
class Cycle:
    """One cycle: what the filter did, what the node did, and the poses (3,) afterwards, in map."""

    tracked: Tracked
    correction: Correction
    estimate: NDArray[np.float64]
    truth: NDArray[np.float64]
    people: NDArray[np.float64]

    @property
    def error(self) -> tuple[float, float]:
        """How far off the estimate is, m and rad."""
        x, y, theta = se2.between(self.truth, self.estimate)
        return float(np.hypot(x, y)), abs(float(theta))


@dataclass(frozen=True)
class Ride:
    """A ride; `collision` is the cycle during which the robot was pushed, or None."""

    cycles: tuple[Cycle, ...]
    collision: int | None

    @property
    def pairs(self) -> NDArray[np.int64]:
        """Pairs of lines (cycles,) that the filter matched."""
        return np.array([cycle.tracked.pairs for cycle in self.cycles])

    @property
    def errors(self) -> NDArray[np.float64]:
        """Errors (cycles, 2), m and rad, after each cycle."""
        return np.array([cycle.error for cycle in self.cycles])

    @property
    def next_node(self) -> int | None:
        """The cycle in which the first node after the collision was reached."""
        if self.collision is None:
            return None
        for number in range(self.collision, len(self.cycles)):
            if self.cycles[number].tracked.node >= 0:
                return number
        return None


def ride_along(place: Place, conditions: Conditions, rng: np.random.Generator) -> Ride:
    """Ride along the corridor; the same `rng` gives the same luck under other conditions."""
    crowd = (conditions.people, place.busy) if conditions.people else None
    robot = CorridorRide(place.floor, START, rng, crowd)
    start = GaussianPose(START, np.diag(START_SIGMAS**2))
    localizer = HybridLocalizer(place.walls, place.topology, start, conditions.params)
    cycles: list[Cycle] = []
    before, collision = robot.look(), None
    for number in range(CYCLES):
        robot.drive(WAY / 2.0)
        if conditions.collides and collision is None and _is_between_nodes(place, robot):
            robot.collide(PUSH, SPIN)
            collision = number
        robot.drive(WAY / 2.0)
        now = robot.look()
        tracked = localizer.track(before, now)
        correction = Correction()
        if conditions.corrects and tracked.node >= 0:
            correction, now = _corrected(robot, localizer, tracked.node)
        estimate = localizer.belief.mean.copy()
        cycles.append(Cycle(tracked, correction, estimate, now.truth, now.people))
        before = now
    return Ride(tuple(cycles), collision)


def ride_runs(
    place: Place, conditions: Conditions, request: Request, advance: Callable[[float], None]
) -> list[Ride]:
    """Return as many rides as asked; each run has luck of its own, the same for all conditions."""
    rides = []
    for run in range(request.runs):
        rides.append(ride_along(place, conditions, np.random.default_rng([request.seed, run])))
        advance(1.0 / request.runs)
    return rides


def _is_between_nodes(place: Place, robot: CorridorRide) -> bool:
    """Say whether the robot has left the first node for the second."""
    return float(robot.truth[0]) >= float(place.topology.places[0, 0]) + LEFT


def _corrected(
    robot: CorridorRide, localizer: HybridLocalizer, node: int
) -> tuple[Correction, Look]:
    """Look at a node, again and again if tracking has failed; return what it did and the last look.

    The filter's belief is that of the last look: the robot stands.
    """
    for _ in range(LOOKS):
        look = robot.look()
        correction = localizer.correct(look, node)
        if correction.features or not localizer.has_failed:
            break
        robot.wait(PAUSE)
    return correction, look
