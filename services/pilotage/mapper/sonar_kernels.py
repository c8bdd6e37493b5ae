"""Drawing readings of a sonar into cells, in log-odds."""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.mapper.sonar_models import (
    ARC_POINT,
    BAYES,
    CENTRE_LINE,
    GAUSSIAN,
    BeamShape,
    arc_point,
    bayes,
    centre_line,
    gaussian,
    uniform_arc,
)

SUREST = 0.999
"""No single reading is surer than this: its log-odds must stay finite."""


@kernel
def certainty_at(
    model: int,
    distance: float,
    offset: float,
    reading: NDArray[np.float64],
    shape: BeamShape,
) -> float:
    """Return what a reading (5,) says of the point `distance` m and `offset` rad from its sonar."""
    measured = reading[3]
    if model == BAYES:
        return bayes(distance, offset, measured, shape)
    if model == GAUSSIAN:
        return gaussian(distance, offset, measured, shape)
    if model == CENTRE_LINE:
        return centre_line(distance, offset, measured, shape)
    if model == ARC_POINT:
        point = arc_point(distance, offset - reading[4], measured, shape)
        return point if point > 0.0 else min(0.0, bayes(distance, offset, measured, shape))
    return uniform_arc(distance, offset, measured, shape)


@kernel
def add_readings(  # noqa: PLR0913, PLR0917  - compiled: plain numbers and arrays
    log_odds: NDArray[np.float32],
    corner: tuple[float, float],
    resolution: float,
    readings: NDArray[np.float64],
    model: int,
    shape: BeamShape,
) -> None:
    """Add what readings (k, 5) say to the log-odds (rows, cols) of the cells in their cones.

    A reading is x, y, direction of the sonar, range, and the angle along the arc at which the
    obstacle was found (used by the model of arc points only). `corner` is x, y of the outer
    corner of cell (0, 0); cells outside the array are passed over.
    """
    rows, cols = log_odds.shape
    slope = math.tan(shape.half_cone) if shape.half_cone < 1.5 else math.inf
    for k in range(len(readings)):
        x, y = readings[k, 0] - corner[0], readings[k, 1] - corner[1]
        axis_x, axis_y = math.cos(readings[k, 2]), math.sin(readings[k, 2])
        low_x, high_x, low_y, high_y = reach(readings[k], shape)
        first_row = max(0, math.floor((low_y - corner[1]) / resolution))
        last_row = min(rows - 1, math.floor((high_y - corner[1]) / resolution))
        first_col = max(0, math.floor((low_x - corner[0]) / resolution))
        last_col = min(cols - 1, math.floor((high_x - corner[0]) / resolution))
        for row in range(first_row, last_row + 1):
            dy = (row + 0.5) * resolution - y
            for col in range(first_col, last_col + 1):
                dx = (col + 0.5) * resolution - x
                ahead, aside = dx * axis_x + dy * axis_y, dy * axis_x - dx * axis_y
                distance = math.sqrt(ahead * ahead + aside * aside)
                # Arctangents are dear; a line or a point may be drawn a cell beside the cone.
                is_aside = abs(aside) > ahead * slope + 2.0 * shape.width
                is_beyond = distance > readings[k, 3] + shape.depth + shape.width
                if ahead < 0.0 or is_aside or is_beyond:
                    continue
                offset = math.atan2(aside, ahead)
                certainty = certainty_at(model, distance, offset, readings[k], shape)
                certainty = min(SUREST, max(-SUREST, certainty))
                if certainty != 0.0:
                    log_odds[row, col] += math.log((1.0 + certainty) / (1.0 - certainty))


@kernel
def reach(reading: NDArray[np.float64], shape: BeamShape) -> tuple[float, float, float, float]:
    """Return lowest and highest x, lowest and highest y, of what a reading (k, 5) says."""
    x, y, direction, far = reading[0], reading[1], reading[2], reading[3] + shape.depth
    low_x = high_x = x
    low_y = high_y = y
    half = shape.half_cone
    for side in range(6):
        # The ends of the arc, and where it crosses an axis of the map.
        angle = direction + (half if side == 0 else -half)
        if side >= 2:
            angle = (side - 2) * math.pi / 2.0
            if math.cos(angle - direction) < math.cos(half):
                continue
        low_x, high_x = (
            min(low_x, x + far * math.cos(angle)),
            max(high_x, x + far * math.cos(angle)),
        )
        low_y, high_y = (
            min(low_y, y + far * math.sin(angle)),
            max(high_y, y + far * math.sin(angle)),
        )
    pad = shape.width
    return low_x - pad, high_x + pad, low_y - pad, high_y + pad


@kernel
def bounds_of(readings: NDArray[np.float64], shape: BeamShape) -> tuple[float, float, float, float]:
    """Return lowest and highest x, lowest and highest y, of what readings (k, 5) say; k > 0."""
    low_x, high_x, low_y, high_y = reach(readings[0], shape)
    for k in range(1, len(readings)):
        box = reach(readings[k], shape)
        low_x, high_x = min(low_x, box[0]), max(high_x, box[1])
        low_y, high_y = min(low_y, box[2]), max(high_y, box[3])
    return low_x, high_x, low_y, high_y


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    reading, shape = (
        np.array([[0.0, 0.0, 0.0, 0.5, 0.0]]),
        BeamShape(0.2, 0.05, 1.0, 0.5, 0.5, 0.05),
    )
    for model in range(ARC_POINT + 1):
        add_readings(np.zeros((2, 2), np.float32), (0.0, 0.0), 0.1, reading, model, shape)
    bounds_of(reading, shape)
