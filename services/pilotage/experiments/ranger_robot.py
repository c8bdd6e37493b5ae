"""The simulated robot of Wu & Bell 2003, section 4: two actions, four rangers, a compass; pure."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_scan

TURN = float(np.deg2rad(5.0))
FORWARD = 0.10
BEARINGS = np.array([0.0, np.pi / 2.0, -np.pi / 2.0, np.pi])
"""Rangers to the front, left, right and back."""

Pose = NDArray[np.float64]
"""(3,) in the map frame; an action is a pose too, seen from the robot before it."""


@dataclass(frozen=True)
class RobotParams:
    """What the robot's parts are good for, as standard deviations.

    `forward`: of a step of 0.10 m [m]; `turn`: of a turn of 5 degrees [rad]; `range`: of a
    ranger [m]; `compass` [rad]; `range_max`: the longest range [m].

    Turns are exact, as in the paper, where headings are multiples of 5 degrees for ever: see the
    README for what a heading between two bins costs.
    """

    forward: float = 0.003
    turn: float = 0.0
    range: float = 0.03
    compass: float = float(np.deg2rad(3.0))
    range_max: float = 25.0


@dataclass(frozen=True)
class Reading:
    """What the sensors say at one place: `ranges` (4,) [m] along BEARINGS, and a `yaw` [rad]."""

    ranges: NDArray[np.float64]
    yaw: float


def carried_out(pose: Pose, action: Pose, params: RobotParams, rng: np.random.Generator) -> Pose:
    """Return where an action really leads: only what moves errs."""
    sigma = np.array([params.forward * (action[0] != 0.0), 0.0, params.turn * (action[2] != 0.0)])
    return se2.compose(pose, action + sigma * rng.standard_normal(3))


def read_sensors(
    world: OccupancyMap, pose: Pose, params: RobotParams, rng: np.random.Generator
) -> Reading:
    """Return noisy ranges, infinite beyond `range_max`, and a noisy yaw."""
    ranges = cast_scan(world, pose, BEARINGS, params.range_max)
    noise = rng.standard_normal(len(BEARINGS))
    yaw = wrap(float(pose[2]) + params.compass * float(rng.standard_normal()))
    return Reading(np.abs(ranges + params.range * noise), yaw)


def next_action(pose: Pose, goal: ArrayLike) -> Pose:
    """Return the action that leads on to a goal (2,): a turn if it lies to the side, or forward."""
    x, y = np.asarray(goal, float)
    aside = wrap(float(np.arctan2(y - pose[1], x - pose[0])) - float(pose[2]))
    if abs(aside) > TURN / 2.0:
        return np.array([0.0, 0.0, np.copysign(TURN, aside)])
    return np.array([FORWARD, 0.0, 0.0])


def is_at(pose: Pose, goal: ArrayLike) -> bool:
    """Say whether a goal (2,) is reached: two steps away."""
    x, y = np.asarray(goal, float)
    return bool(np.hypot(x - pose[0], y - pose[1]) <= 2.0 * FORWARD)


def random_goals(
    low: tuple[float, float], high: tuple[float, float], rng: np.random.Generator
) -> Iterator[NDArray[np.float64]]:
    """Yield goals (2,) anywhere between two corners, for ever."""
    while True:
        yield rng.uniform(low, high)


def on_a_bin(x: float, y: float, heading: float) -> Pose:
    """Return a pose whose heading is the nearest multiple of 5 degrees."""
    return np.array([x, y, wrap(round(heading / TURN) * TURN)])
