"""Active localization on any map: where to look from next (Liu et al. 2008, eq. 4 to 10); pure.

The paper moves every sample by the displacement to a target (eq. 7), weighs them by what one full
turn there is expected to show (eq. 8), and takes the target of the largest value
U = gain - alpha * travel (eq. 6). So does this, with two differences that a building asks for:
travel is the length of a way that is free under every likely place, not a straight line, and
what is expected is a scan of the map's walls where nobody has put up landmarks.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import OccupancyMap
from pilotage.core.laser_view import View
from pilotage.planner.candidates import Candidates, Kind, Reach, candidates
from pilotage.planner.common_ground import Clearance, GroundParams, common_ground
from pilotage.planner.expected_scans import SightParams
from pilotage.planner.hypotheses import NEAR, likely, merged
from pilotage.planner.information import drawn, entropy, expected_gain
from pilotage.planner.path_search import shortened, travel_field, way_to
from pilotage.planner.sight import FULL_TURN, Potential, ScanSight, Sight, Window
from pilotage.planner.situation import Hypotheses

TRIED = 100.0
"""Taken off the value of what was tried: it is chosen only if there is nothing else."""
POINTINGS = 8
"""Directions that the robot could look in on arrival."""


@dataclass(frozen=True)
class ActiveParams:
    """How the next look is chosen.

    `alpha`: share of the uncertainty that a metre of way must take away (eq. 6) [1/m]; as a number
    of bits it would hold back a robot that has but two places to tell apart. `candidates`: how
    many are weighed; `observations`: how many places say what would be seen; `samples`: of the
    belief, that a pointing has to tell apart. `negligible`: gain that is not worth a move,
    `worth_a_turn`: not worth turning for on arrival, `settled`: uncertainty of a belief that only
    wants confirming [bit].
    """

    alpha: float = 0.05
    candidates: int = 60
    observations: int = 32
    samples: int = 200
    negligible: float = 0.05
    settled: float = 0.5
    worth_a_turn: float = 0.1
    sight: SightParams = field(default_factory=SightParams)
    ground: GroundParams = field(default_factory=GroundParams)


@dataclass(frozen=True)
class Look:
    """A place to look from: `point` (2,) in base_link [m], `gain` [bit], `travel` [m]."""

    point: NDArray[np.float64]
    gain: float
    travel: float
    kind: Kind


@dataclass(frozen=True)
class Decision:
    """Looks by falling value; the first is chosen, and `path` (n, 2) in base_link leads to it.

    `heading` [rad] in base_link to turn to there; None: as it arrives. `places`: what the belief
    was taken to be, heaviest first; `told_apart`: which two of them the look would tell apart
    best; `uncertainty` [bit] before it.
    """

    looks: tuple[Look, ...]
    path: NDArray[np.float64]
    heading: float | None
    places: Hypotheses
    told_apart: tuple[int, int]
    uncertainty: float


class ActiveLocalization:
    """Decides on one map."""

    def __init__(
        self, world: OccupancyMap, params: ActiveParams, sight: Sight | None = None
    ) -> None:
        self.params = params
        self._sight = sight or ScanSight(world, params.sight, params.ground.radius)
        self._clearance = Clearance(world)
        self._maxima = self.potential.maxima()

    @property
    def potential(self) -> Potential:
        """Where on the map it is worth looking from."""
        return self._sight.potential

    def decide(
        self,
        belief: Hypotheses,
        view: View,
        rng: np.random.Generator,
        tried: NDArray[np.float64],
    ) -> Decision:
        """Return where to look from next.

        Args:
            belief: where the robot could be.
            view: what the laser sees.
            rng: draws the random candidates.
            tried: (k, 2) places in base_link from which the robot has looked already.
        """
        places = merged(belief)
        reach = self._reach(likely(places), view)
        targets = candidates(reach, self._maxima, places, self.params.candidates, rng)
        gains = self.gains(places, targets.points)
        values = self._values(gains, targets, places, tried)
        order = np.argsort(-values, kind="stable")
        looks = tuple(
            Look(targets.points[i], float(gains[i]), float(targets.travel[i]), targets.kinds[i])
            for i in order
        )
        path = _path(reach, looks[0].point)
        return Decision(
            looks,
            path,
            self._heading(places, path, view),
            places,
            self._told_apart(places, looks[0].point),
            entropy(places.weights),
        )

    def gains(self, belief: Hypotheses, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the gains (n,) [bit] expected of a full turn at displacements (n, 2)."""
        return np.array([self._gain(belief, point, FULL_TURN) for point in points])

    def gaze(self, belief: Hypotheses, view: View) -> float | None:
        """Return where to point the sensor now, off the heading [rad] (eq. 10); None: it is fixed.

        Unlike a place to go to, a pointing has to tell samples apart that are near each other.
        """
        pointings = self._sight.pointings
        if len(pointings) == 0:
            return None
        chosen = drawn(belief.weights, self.params.samples)
        samples = Hypotheses(belief.poses[chosen], np.full(len(chosen), 1.0 / len(chosen)))
        middle, half = self._sight.window(view)
        windows = [(float(pan) + middle, half) for pan in pointings]
        gains = [self._gain(samples, np.zeros(2), window) for window in windows]
        return float(pointings[int(np.argmax(gains))])

    def _gain(self, belief: Hypotheses, point: NDArray[np.float64], window: Window) -> float:
        """Return H(l_t) - H(l_t+1) [bit] of a look through a window after a displacement (2,)."""
        there = belief.moved([point[0], point[1], 0.0])
        truths = drawn(belief.weights, self.params.observations)
        fits = self._sight.log_likelihoods(there.poses, truths, window)
        return expected_gain(fits, belief.weights)

    def _heading(self, places: Hypotheses, path: NDArray[np.float64], view: View) -> float | None:
        """Return where to look at the end of a path: the pointing of the largest gain (eq. 10)."""
        if len(self._sight.pointings):
            return None
        along = path[-1] - path[-2] if path[-1].any() else np.array([1.0, 0.0])
        arriving = float(np.arctan2(along[1], along[0]))
        pointings = wrap(arriving + np.arange(POINTINGS) * 2.0 * np.pi / POINTINGS)
        middle, half = self._sight.window(view)
        windows = [(float(heading) + middle, half) for heading in pointings]
        gains = [self._gain(places, path[-1], window) for window in windows]
        best = int(np.argmax(gains))
        return None if gains[best] < gains[0] + self.params.worth_a_turn else float(pointings[best])

    def _reach(self, places: Hypotheses, view: View) -> Reach:
        geometry, passable = common_ground(self._clearance, places, view, self.params.ground)
        middle = geometry.rows // 2, geometry.cols // 2
        metres = travel_field(
            passable, np.ones(passable.shape, np.float32), geometry.resolution, middle
        )
        return Reach(geometry, passable, metres)

    def _values(
        self,
        gains: NDArray[np.float64],
        targets: Candidates,
        places: Hypotheses,
        tried: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Return U (eq. 6) of each target; what was tried has told what it can."""
        uncertainty = entropy(places.weights)
        values = gains - self.params.alpha * uncertainty * targets.travel
        if gains.max() < self.params.negligible:
            # Nothing within reach tells the places apart: the farthest shows most that is new. Or
            # there is but one, and it wants confirming where it looks like no other.
            seen = se2.transform_points(places.best, targets.points)
            rare = self.potential.bits_at(seen) - targets.travel
            values = rare if uncertainty < self.params.settled else targets.travel.copy()
        for point in tried:
            values[np.hypot(*(targets.points - point).T) < NEAR] -= TRIED
        return values

    def _told_apart(self, places: Hypotheses, point: NDArray[np.float64]) -> tuple[int, int]:
        """Return the two of the heaviest places that a look tells apart best, for their weight."""
        few = Hypotheses(places.poses[:5], places.weights[:5])
        there = few.moved([point[0], point[1], 0.0])
        everyone = np.arange(len(few.weights))
        differences = -self._sight.log_likelihoods(there.poses, everyone, FULL_TURN)
        worth = differences * np.outer(few.weights, few.weights)
        one, other = np.unravel_index(int(np.argmax(worth)), worth.shape)
        return int(min(one, other)), int(max(one, other))


def _path(reach: Reach, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the way (n, 2), n >= 2, from here to a point that can be reached."""
    cell = reach.geometry.cells_of(point[None])[0]
    cost = np.ones(reach.passable.shape, np.float32)
    way = shortened(way_to(reach.metres, reach.passable, cell), reach.passable, cost)
    points = reach.geometry.centres_of(way)
    points[0] = 0.0
    return points if len(points) > 1 else np.zeros((2, 2))
