"""What one reading of a sonar says about a point of its cone (Li 2008, chapter 3).

Each model returns a signed certainty s in (-1, 1): the point is occupied with probability
(1 + s) / 2, so that its log-odds are 2 atanh(s) and 0 says nothing. A point lies `distance` m from
the sonar, `offset` rad aside of its axis; the sonar measured `reading` m.
"""

import math
from typing import Literal, NamedTuple

from pilotage.core.jit import kernel

SonarModel = Literal["centre_line", "gaussian", "uniform_arc", "bayes", "atm", "improved_atm"]
CENTRE_LINE, GAUSSIAN, UNIFORM_ARC, BAYES, ARC_POINT = range(5)
KERNEL_OF: dict[str, int] = {
    "centre_line": CENTRE_LINE,
    "gaussian": GAUSSIAN,
    "uniform_arc": UNIFORM_ARC,
    "bayes": BAYES,
    "atm": ARC_POINT,
    "improved_atm": ARC_POINT,
}
"""How a reading is drawn; the arc-transversal methods draw the point that they found."""


class BeamShape(NamedTuple):
    """How a sonar sees; a tuple, because kernels take it."""

    half_cone: float
    """Half the opening angle, rad."""
    depth: float
    """delta: half the thickness of the arc, m."""
    visible: float
    """rho_v: the range at which a reading is trusted half, m."""
    certainty: float
    """Certainty of the best reading, 0 to 1."""
    point_certainty: float
    """The same of a point from which an echo is known to come."""
    width: float
    """Width of a line or a point as it is drawn, m."""


@kernel
def range_weight(distance: float, visible: float) -> float:
    """Return 1 near the sonar, 1/2 at `visible` m, 0 far away (3-8)."""
    return 1.0 - (1.0 + math.tanh(2.0 * (distance - visible))) / 2.0


@kernel
def angular_weight(offset: float, half_cone: float) -> float:
    """Return 1 on the axis, 0 from the edge of the cone on.

    (3-7) is 1 - 21 theta^2 for the thesis's cone of 25 degrees: 21 is 1 / 12.5 degrees squared.
    """
    aside = offset / half_cone
    return max(0.0, 1.0 - aside * aside)


@kernel
def across_arc(depths: float) -> float:
    """Return -1 before the arc, 1 on it, 0 behind it, at (rho - r) / delta from it (3-10).

    The continuous form of Ribo & Pinz 2001; the print of the thesis jumps.
    """
    if depths < -2.0:
        return -1.0
    if depths < -1.0:
        return (2.0 + depths) ** 2 - 1.0
    if depths < 1.0:
        return 1.0 - depths * depths
    return 0.0


@kernel
def bayes(distance: float, offset: float, reading: float, shape: BeamShape) -> float:
    """Return the certainty of the Bayesian grid (3-7, 3-8, 3-10)."""
    trust = angular_weight(offset, shape.half_cone) * range_weight(distance, shape.visible)
    return shape.certainty * trust * across_arc((distance - reading) / shape.depth)


@kernel
def gaussian(distance: float, offset: float, reading: float, shape: BeamShape) -> float:
    """Return a certainty that falls off as a Gaussian from the middle of the arc.

    Two standard deviations reach the edge of the cone; before the arc the bell is turned over,
    so that certainty passes from free to occupied without a jump.
    """
    if abs(offset) > shape.half_cone:
        return 0.0
    aside = 2.0 * offset / shape.half_cone
    depths = (distance - reading) / shape.depth
    bell = math.exp(-2.0 * depths * depths)
    along = bell if depths > 0.0 else 2.0 * bell - 1.0
    return shape.certainty * math.exp(-aside * aside / 2.0) * along


@kernel
def centre_line(distance: float, offset: float, reading: float, shape: BeamShape) -> float:
    """Return the certainty if everything lies on the axis, as with a laser."""
    if 2.0 * abs(distance * math.sin(offset)) > shape.width or abs(offset) > math.pi / 2.0:
        return 0.0
    behind = distance - reading
    if 2.0 * behind > shape.width:
        return 0.0
    return shape.certainty if 2.0 * behind >= -shape.width else -shape.certainty


@kernel
def uniform_arc(distance: float, offset: float, reading: float, shape: BeamShape) -> float:
    """Return the certainty if the echo may come from anywhere on the arc alike (4-1).

    One point of the arc sent the echo back: the longer the arc, the less is known of each.
    """
    if abs(offset) > shape.half_cone or distance - reading > shape.depth:
        return 0.0
    if distance < reading - shape.depth:
        return -shape.certainty
    return shape.certainty * min(1.0, shape.width / (2.0 * reading * shape.half_cone))


@kernel
def arc_point(distance: float, aside: float, reading: float, shape: BeamShape) -> float:
    """Return the certainty if the echo came from one point, `aside` rad from here along the arc."""
    across = 2.0 * reading * aside / shape.width
    near = max(0.0, 1.0 - across * across / 4.0)
    along = across_arc((distance - reading) / shape.depth)
    return shape.point_certainty * range_weight(reading, shape.visible) * near * max(0.0, along)
