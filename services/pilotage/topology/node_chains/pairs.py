"""Features seen paired with features that are there, and the pose that pairs speak for.

A pair says by how much its nearness beats a feature that is there by accident. Each kernel has a
plain twin in tests/naive/node_chain.py.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

LOG_ROOT_TURN = float(0.5 * np.log(2.0 * np.pi))
"""Normalization of a normal density in one dimension."""


class Seen(NamedTuple):
    """Features (n,) in base_link: kinds, poses (n, 3), widths, and variances of position, m^2."""

    kinds: NDArray[np.int64]
    poses: NDArray[np.float64]
    widths: NDArray[np.float64]
    variances: NDArray[np.float64]


class There(NamedTuple):
    """Features (n,) bound to a node, in the frame of the pose that is expected there.

    `place` m and `turn` rad: standard deviations of that pose.
    """

    kinds: NDArray[np.int64]
    poses: NDArray[np.float64]
    widths: NDArray[np.float64]
    variances: NDArray[np.float64]
    place: float
    turn: float


class Model(NamedTuple):
    """How features vary.

    `direction` rad and `width` m: of a pair; `detection`: probability that a bound feature in
    view is seen; `strays` (kinds,): features there by accident, per m^2, any direction and per
    metre of width; `reach` m and `half_view` rad: what is surely in view.
    """

    direction: float
    width: float
    detection: float
    strays: NDArray[np.float64]
    reach: float
    half_view: float


@kernel
def weigh_pairs(
    seen: Seen,
    there: There,
    model: Model,
    offset: NDArray[np.float64],
    gains: NDArray[np.float64],
) -> None:
    """Fill in what each pair (n, m) would add to the evidence if the robot were at `offset`."""
    cos, sin = np.cos(offset[2]), np.sin(offset[2])
    for i in range(len(seen.kinds)):
        x = cos * seen.poses[i, 0] - sin * seen.poses[i, 1] + offset[0]
        y = sin * seen.poses[i, 0] + cos * seen.poses[i, 1] + offset[1]
        for j in range(len(there.kinds)):
            gains[i, j] = -np.inf
            if seen.kinds[i] != there.kinds[j]:
                continue
            variance = seen.variances[i] + there.variances[j]
            squared = (there.poses[j, 0] - x) ** 2 + (there.poses[j, 1] - y) ** 2
            turn = _turn_left(seen, there, i, j, offset[2])
            gain = -0.5 * squared / variance - np.log(2.0 * np.pi * variance)
            gain += _agreement(turn, model.direction)
            gain += np.log(2.0 * np.pi if seen.kinds[i] == 0 else np.pi)
            wider = seen.widths[i] - there.widths[j]
            if not np.isnan(wider):
                gain += _agreement(wider, model.width)
            gain -= np.log(model.strays[seen.kinds[i]])
            gains[i, j] = gain + np.log(model.detection) - _miss(there, j, model, offset)


@kernel
def choose_pairs(gains: NDArray[np.float64], partner: NDArray[np.int64]) -> None:
    """Pair the most telling first, each feature once, as long as a pair is worth it."""
    partner[:] = -1
    columns = gains.shape[1]
    is_taken = np.zeros(columns, np.bool_)
    while True:
        best, row, col = 0.0, -1, -1
        for i in range(len(partner)):
            if partner[i] >= 0:
                continue
            for j in range(columns):
                if not is_taken[j] and gains[i, j] > best:
                    best, row, col = gains[i, j], i, j
        if row < 0:
            return
        partner[row] = col
        is_taken[col] = True


@kernel
def fit_pairs(
    both: tuple[Seen, There],
    model: Model,
    partner: NDArray[np.int64],
    offset: NDArray[np.float64],
    information: NDArray[np.float64],
) -> None:
    """Move `offset` (3,) by a step of Gauss-Newton; fill in the information (4,) it is known with.

    With variances alike along x and y the normal equations are solved by hand. `both`: the
    features seen, and those that are there.
    """
    seen, there = both
    across, turning = 1.0 / there.place**2, 1.0 / there.turn**2
    along_x, along_y = 0.0, 0.0
    x, y, theta = -across * offset[0], -across * offset[1], -turning * offset[2]
    cos, sin = np.cos(offset[2]), np.sin(offset[2])
    for i in range(len(partner)):
        j = partner[i]
        if j < 0:
            continue
        weight = 1.0 / (seen.variances[i] + there.variances[j])
        u = cos * seen.poses[i, 0] - sin * seen.poses[i, 1]
        v = sin * seen.poses[i, 0] + cos * seen.poses[i, 1]
        left_x = there.poses[j, 0] - u - offset[0]
        left_y = there.poses[j, 1] - v - offset[1]
        across += weight
        along_x -= weight * v
        along_y += weight * u
        turning += weight * (u**2 + v**2) + 1.0 / model.direction**2
        x += weight * left_x
        y += weight * left_y
        theta += weight * (u * left_y - v * left_x)
        theta += _turn_left(seen, there, i, j, offset[2]) / model.direction**2
    information[:] = across, along_x, along_y, turning
    left = turning - (along_x**2 + along_y**2) / across
    turned = (theta - (along_x * x + along_y * y) / across) / left
    offset[0] += (x - along_x * turned) / across
    offset[1] += (y - along_y * turned) / across
    offset[2] += turned


@kernel
def all_unseen(there: There, model: Model, offset: NDArray[np.float64]) -> float:
    """Return what it would say if nothing that should be in view were seen."""
    total = 0.0
    for j in range(len(there.kinds)):
        total += _miss(there, j, model, offset)
    return total


@kernel
def _miss(there: There, j: int, model: Model, offset: NDArray[np.float64]) -> float:
    """Return the log-probability that bound feature `j` is not seen."""
    dx, dy = there.poses[j, 0] - offset[0], there.poses[j, 1] - offset[1]
    bearing = np.arctan2(dy, dx) - offset[2]
    bearing = abs((bearing + np.pi) % (2.0 * np.pi) - np.pi)
    if bearing > model.half_view or dx**2 + dy**2 > model.reach**2:
        return 0.0
    return float(np.log(1.0 - model.detection))


@kernel
def _turn_left(seen: Seen, there: There, i: int, j: int, turned: float) -> float:
    """Return the turn that is left from feature `i` seen, `turned` already, to feature `j`.

    The nearest to none: half a turn is none but for corners.
    """
    turn = there.poses[j, 2] - seen.poses[i, 2] - turned
    period = 2.0 * np.pi if seen.kinds[i] == 0 else np.pi
    return float((turn + 0.5 * period) % period - 0.5 * period)


@kernel
def _agreement(difference: float, sigma: float) -> float:
    """Return the log-density of a normal error."""
    return float(-0.5 * (difference / sigma) ** 2 - np.log(sigma) - LOG_ROOT_TURN)
