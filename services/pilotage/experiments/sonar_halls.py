"""Worlds like the thesis's, their walls and the way through them (Li 2008, figures 5-1, 5-4, 5-7).

The thesis draws them without measures: sizes here follow from its ways (3.64 m, 7 m) and from
the 0.33 m of the robot.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pilotage.experiments.sonar_drive import Order
from pilotage.experiments.wall_segments import Floats

WAY = 3.64
"""m from left to right in the simple hall (table 5-1)."""

OPENING = 0.40
"""m between the edges of the opening (Li 2008, 5.2)."""

MIDDLE, UPPER = 2.5, 2.0
"""Where the opening is: x of its middle and y of the wall on the side of the hall, m."""

LEFT, RIGHT = Order(turn=np.pi / 2.0), Order(turn=-np.pi / 2.0)


@dataclass(frozen=True, eq=False)
class Hall:
    """Walls (n, 4) as segments, the start (3,) of the robot, and what it is told to do."""

    walls: Floats
    start: NDArray[np.float64]
    orders: tuple[Order, ...]


def simple_hall() -> Hall:
    """Return a hall of 5.2 m x 1.8 m with a cupboard: there and back, straight, and there again."""
    walls = _walls([(0.0, 0.0), (5.2, 0.0), (5.2, 1.8), (3.4, 1.8), (3.4, 1.5), (2.6, 1.5),
                    (2.6, 1.8), (0.0, 1.8), (0.0, 0.0)])  # fmt: skip
    there, back = Order(way=WAY), Order(way=-WAY)
    return Hall(walls, np.array([0.8, 0.8, 0.0]), (there, back, there, back, there))


def complex_hall() -> Hall:
    """Return a hall of 5.2 m x 4.6 m, angled four times, with a cupboard and a niche: a way of 7 m.

    The robot turns left, right and left.
    """
    walls = _walls([(0.0, 0.0), (1.2, 0.0), (1.2, 0.25), (1.7, 0.25), (1.7, 0.0), (3.4, 0.0),
                    (3.4, 1.4), (5.2, 1.4), (5.2, 2.6), (5.4, 2.6), (5.4, 3.4), (5.2, 3.4),
                    (5.2, 4.6), (3.8, 4.6), (3.8, 2.8), (2.0, 2.8), (2.0, 1.4), (0.0, 1.4),
                    (0.0, 0.0)])  # fmt: skip
    orders = (Order(2.0), LEFT, Order(1.4), RIGHT, Order(1.8), LEFT, Order(1.8))
    return Hall(walls, np.array([0.7, 0.7, 0.0]), orders)


def narrow_opening() -> Hall:
    """Return a hall whose upper wall has an opening of 0.40 m into a room; passed once.

    The robot passes 1.2 m from that wall, where its sonars are at their best (Li 2008, 3.4.3).
    """
    left, right = MIDDLE - OPENING / 2.0, MIDDLE + OPENING / 2.0
    hall = _walls([(left, UPPER), (0.0, UPPER), (0.0, 0.0), (5.0, 0.0), (5.0, UPPER),
                   (right, UPPER)])  # fmt: skip
    room = _walls([(left, UPPER), (left, 2.15), (1.4, 2.15), (1.4, 3.8), (3.6, 3.8), (3.6, 2.15),
                   (right, 2.15), (right, UPPER)])  # fmt: skip
    return Hall(np.concatenate([hall, room]), np.array([0.68, 0.8, 0.0]), (Order(way=WAY),))


def _walls(corners: Sequence[tuple[float, float]]) -> Floats:
    """Return the walls (n - 1, 4) from corner to corner."""
    return np.array([[*one, *other] for one, other in pairwise(corners)])
