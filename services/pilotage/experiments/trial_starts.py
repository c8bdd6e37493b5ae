"""Places to start a trial from: where a look around does not tell the robot where it is; pure.

Few places of a building are like that to a laser that sees far. So its sight is shortened until
enough are found; with the shortest a place will do that a scan alone does not tell.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.experiments.trial_world import Ride, TrialWorld

SIGHTS = (12.0, 5.6, 4.0, 3.0)
"""How far the laser sees [m]: the simulated one, a common small one, and in a dusty hall."""

LOOKS = 3
"""Scans weighed at rest, a second apart, that must not settle where the robot is."""

LOOK_PERIOD = 1.0
"""s."""

TURN_RATE, TURN_STEPS = 1.0, 63
"""A full turn on the spot: rad/s, and how many scans it takes."""

PROBES, RARE = 12, 0.1
"""After so many turns on the spot a sight is given up if fewer than this share settle nothing."""

DRAWS_PER_START = 12
"""Places drawn with one sight, at most, for each start that is wanted."""

Advance = Callable[[float], None]


class NoStartError(ValueError):
    """There is nowhere to start from; the text says why."""


@dataclass(frozen=True)
class Starts:
    """Places (n, 3) to start from, map frame, and how they were found.

    `range_max` [m] of the laser; `by`: `turn`, if a full turn on the spot leaves the robot
    unlocalized, or `look`, if scans at rest do; of `draws` places with this sight `unsettled` were
    not told by scans at rest, of which `probed` were looked around at and `hard` not told by that.
    """

    poses: NDArray[np.float64]
    range_max: float
    by: str
    draws: int
    unsettled: int
    probed: int
    hard: int


def find_starts(
    world: TrialWorld, count: int, seed: int, sights: Iterable[float], advance: Advance
) -> Starts:
    """Return so many ambiguous starts, with the longest sight that has them.

    Args:
        world: the building.
        count: how many.
        seed: of the places and of what is measured there.
        sights: how far the laser may see, longest first.
        advance: is told of each place that is tried.

    Raises:
        NoStartError: the robot fits nowhere, or is localized wherever it is put.
    """
    if len(world.places) == 0:
        raise NoStartError("the map has no free place that the robot fits in")
    searches: list[_Search] = []
    for sight in sights:
        search = _Search(world.seen_by(replace(world.robot.laser, range_max=sight)), count, seed)
        search.run(advance, stops_short=any(other.is_enough for other in searches))
        if len(search.hard) == count:
            return search.starts("turn")
        searches.append(search)
    for search in searches:
        if search.is_enough:
            return search.starts("look")
    tried = " or ".join(f"{search.sight:g}" for search in searches)
    raise NoStartError(
        f"a laser that sees {tried} m tells the robot where it is nearly everywhere on this map: "
        f"fewer than {count} ambiguous starts were found"
    )


class _Search:
    """Draws places with one sight until enough of them are ambiguous."""

    def __init__(self, world: TrialWorld, count: int, seed: int) -> None:
        self._world, self._count, self._seed = world, count, seed
        self.sight = world.robot.laser.range_max
        self.unsettled: list[NDArray[np.float64]] = []
        self.hard: list[NDArray[np.float64]] = []
        self._draws = self._unsettled = self._probed = 0

    @property
    def is_enough(self) -> bool:
        """Whether there are enough places that scans at rest do not tell."""
        return len(self.unsettled) == self._count

    def run(self, advance: Advance, *, stops_short: bool) -> None:
        """Fill `hard`, or at least (unless it `stops_short`) `unsettled`, if the draws suffice."""
        for index, pose in enumerate(self._drawn()):
            if len(self.hard) == self._count:
                return
            is_hopeless = self._probed >= PROBES and len(self.hard) < RARE * self._probed
            if is_hopeless and (stops_short or self.is_enough):
                return
            self._try(index, pose, is_hopeless=is_hopeless)
            advance(1.0)

    def _try(self, index: int, pose: NDArray[np.float64], *, is_hopeless: bool) -> None:
        self._draws += 1
        ride = Ride(self._world, pose, np.random.default_rng([self._seed, 1, index]))
        if is_settled_at_rest(ride):
            return
        self._unsettled += 1
        if len(self.unsettled) < self._count:
            self.unsettled.append(pose)
        if is_hopeless:
            return
        self._probed += 1
        if not is_settled_by_turning(ride):
            self.hard.append(pose)

    def starts(self, by: str) -> Starts:
        """Return what was found."""
        poses = np.array(self.hard if by == "turn" else self.unsettled)
        found = self._draws, self._unsettled, self._probed, len(self.hard)
        return Starts(poses, self.sight, by, *found)

    def _drawn(self) -> Iterator[NDArray[np.float64]]:
        rng, places = np.random.default_rng([self._seed, 0]), self._world.places
        for _ in range(DRAWS_PER_START * self._count):
            x, y = places[rng.integers(len(places))]
            yield np.array([x, y, rng.uniform(-np.pi, np.pi)])


def is_settled_at_rest(ride: Ride) -> bool:
    """Say whether scans from where it stands tell the robot where it is."""
    for _ in range(LOOKS):
        if ride.look().state == "localized":
            return True
        ride.wait(LOOK_PERIOD)
    return False


def is_settled_by_turning(ride: Ride) -> bool:
    """Say whether a full turn on the spot tells the robot where it is."""
    for _ in range(TURN_STEPS):
        ride.drive((0.0, TURN_RATE))
        if ride.look().state == "localized":
            return True
    return False
