"""One walk through a symmetric place, localized without and with the compass; pure.

Wu & Bell 2003, figures 4 and 5: after every metre the most probable states are shown. A place
that looks the same after a turn by 2 pi / n about its middle must hold n modes of equal mass
without the compass (eq. 10 and 11), and one with it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.experiments.ranger_localizer import Place, RangerLocalizer, RangerModel
from pilotage.experiments.ranger_robot import (
    FORWARD,
    Pose,
    carried_out,
    is_at,
    next_action,
    read_sensors,
)
from pilotage.localizer.modes import Mode, apart

STEPS_PER_METRE = round(1.0 / FORWARD)


@dataclass(frozen=True)
class Symmetry:
    """A place that looks the same `fold` times when turned about `middle` (2,) [m, map frame]."""

    fold: int
    middle: tuple[float, float]

    def images(self, pose: Pose) -> NDArray[np.float64]:
        """Return the poses (fold, 3) that no ranger can tell apart, the pose itself first."""
        about = np.array([*self.middle, 0.0])
        turns = np.zeros((self.fold, 3))
        turns[:, 2] = np.arange(self.fold) * (2.0 * np.pi / self.fold)
        return se2.compose(se2.compose(about, turns), se2.between(about, pose))


@dataclass(frozen=True)
class Shown:
    """What is shown after a metre: the modes, and the belief's `marginal` (rows, cols)."""

    truth: Pose
    modes: list[Mode]
    marginal: NDArray[np.float32]


@dataclass(frozen=True)
class Walk:
    """The true `path` (n, 3), and what was shown on the way without and with the compass."""

    path: NDArray[np.float64]
    without_compass: list[Shown]
    with_compass: list[Shown]


@dataclass(frozen=True)
class Route:
    """From a pose (3,) by way of goals (2,) for so many metres."""

    start: Pose
    goals: Iterator[NDArray[np.float64]]
    metres: int


def walk(
    place: Place,
    model: RangerModel,
    route: Route,
    rng: np.random.Generator,
    advance: Callable[[], None],
) -> Walk:
    """Let a robot that does not know where it is follow a route.

    Args:
        place: where.
        model: the robot and what the localizers know of it.
        route: ends after its metres, whatever goals are left.
        rng: the noise.
        advance: called after every metre.
    """
    without = RangerLocalizer(place, model, "m2", has_compass=False)
    compass = RangerLocalizer(place, model, "m2", has_compass=True)
    shown: tuple[list[Shown], list[Shown]] = ([], [])
    path, goal, steps = [route.start], next(route.goals), 0
    while steps < route.metres * STEPS_PER_METRE:
        if is_at(path[-1], goal):
            goal = next(route.goals)
        action = next_action(path[-1], goal)
        path.append(carried_out(path[-1], action, model.robot, rng))
        reading = read_sensors(place.world, path[-1], model.robot, rng)
        for localizer in (without, compass):
            localizer.update(action, reading)
        steps += int(action[0] > 0.0)
        if action[0] > 0.0 and steps % STEPS_PER_METRE == 0:
            for localizer, said in zip((without, compass), shown, strict=True):
                said.append(Shown(path[-1], localizer.modes(), localizer.grid.marginal()))
            advance()
    return Walk(np.array(path), *shown)


def spread_of_masses(modes: list[Mode]) -> float:
    """Return by what share of their mean the modes' masses differ from it at most."""
    masses = np.array([mode.mass for mode in modes])
    return float(np.abs(masses / masses.mean() - 1.0).max())


def errors(modes: list[Mode], images: NDArray[np.float64]) -> tuple[float, float]:
    """Return the largest distance [m] and turn [rad] of the images (n, 3) to their next modes."""
    off = [min((apart(mode.pose, image) for mode in modes), key=sum) for image in images]
    return max(distance for distance, _ in off), max(turn for _, turn in off)
