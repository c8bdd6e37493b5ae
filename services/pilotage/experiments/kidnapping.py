"""One kidnapping, watched by M1 and M2 (Wu & Bell 2003, example 1); pure.

The belief is certain at l1. The robot is carried to l_i, which its odometry does not notice; then
it goes on measuring. M1 only multiplies (eq. 3), so a belief that is zero at l_i stays zero
(eq. 7); M2's floor P0 lets it grow again (eq. 9).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.experiments.ranger_localizer import Place, RangerLocalizer, RangerModel
from pilotage.experiments.ranger_robot import (
    Pose,
    carried_out,
    is_at,
    next_action,
    on_a_bin,
    random_goals,
    read_sensors,
)
from pilotage.localizer.modes import apart

ALGORITHMS: tuple[Literal["m1", "m2"], ...] = ("m1", "m2")
STEPS_BEFORE, STEPS_AFTER = 20, 100
CARRIED_AT_LEAST = 3.0
"""How far [m] the robot is carried at least."""

CLEAR = 1.0
"""Places and goals keep this far [m] from the walls."""

CERTAIN = np.diag([0.05**2, 0.05**2, np.deg2rad(2.0) ** 2])
"""Covariance of the belief at l1."""


@dataclass(frozen=True)
class Seen:
    """What one algorithm said at every step (n,).

    `share`: of the belief within 0.5 m and 15 degrees of the truth; `error_m`, `error_rad`: of
    the most probable place; `poses` (n, 3) of that place.
    """

    share: NDArray[np.float64]
    error_m: NDArray[np.float64]
    error_rad: NDArray[np.float64]
    poses: NDArray[np.float64]

    def is_right(self, distance: float, turn: float) -> NDArray[np.bool_]:
        """Say of every step (n,) whether the most probable place is this near to the truth."""
        right: NDArray[np.bool_] = (self.error_m <= distance) & (self.error_rad <= turn)
        return right


@dataclass(frozen=True)
class Kidnapping:
    """The true `path` (n, 3), carried off before step STEPS_BEFORE, and what was seen by whom."""

    path: NDArray[np.float64]
    seen: dict[str, Seen]


def kidnap(place: Place, model: RangerModel, rng: np.random.Generator) -> Kidnapping:
    """Let a robot with a compass start at l1, carry it off, and let it go on."""
    pose = _anywhere(place, rng)
    localizers = {
        name: RangerLocalizer(place, model, name, has_compass=True) for name in ALGORITHMS
    }
    for localizer in localizers.values():
        localizer.grid.set_gaussian(pose, CERTAIN)
    goals = random_goals(*_corners(place), rng)
    goal, path = next(goals), []
    said: dict[str, list[tuple[float, ...]]] = {name: [] for name in ALGORITHMS}
    for step in range(STEPS_BEFORE + STEPS_AFTER):
        if step == STEPS_BEFORE:
            pose = _elsewhere(place, pose, rng)
        if is_at(pose, goal):
            goal = next(goals)
        action = next_action(pose, goal)
        pose = carried_out(pose, action, model.robot, rng)
        reading = read_sensors(place.world, pose, model.robot, rng)
        for name, localizer in localizers.items():
            localizer.update(action, reading)
            said[name].append(_judged(localizer, pose))
        path.append(pose)
    return Kidnapping(np.array(path), {name: _seen(rows) for name, rows in said.items()})


def _judged(localizer: RangerLocalizer, truth: Pose) -> tuple[float, ...]:
    """Return the share near the truth, the best place's error, and its pose."""
    modes = localizer.modes()
    if not modes:
        return 0.0, np.nan, np.nan, np.nan, np.nan, np.nan
    return localizer.share_near(truth), *apart(modes[0].pose, truth), *modes[0].pose


def _seen(rows: list[tuple[float, ...]]) -> Seen:
    table = np.array(rows)
    return Seen(table[:, 0], table[:, 1], table[:, 2], table[:, 3:])


def _anywhere(place: Place, rng: np.random.Generator) -> Pose:
    x, y = rng.uniform(*_corners(place))
    return on_a_bin(x, y, float(rng.uniform(-np.pi, np.pi)))


def _elsewhere(place: Place, pose: Pose, rng: np.random.Generator) -> Pose:
    """Return a pose at least CARRIED_AT_LEAST away."""
    while True:
        other = _anywhere(place, rng)
        if apart(other, pose)[0] >= CARRIED_AT_LEAST:
            return other


def _corners(place: Place) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the corners of what lies CLEAR of a hall's walls."""
    x, y, _ = place.states.geometry.origin
    width, height = place.states.geometry.size_m
    return (x + CLEAR, y + CLEAR), (x + width - CLEAR, y + height - CLEAR)
