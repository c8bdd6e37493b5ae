"""The two fields of Liu et al. 2008, section 3: their landmarks, and how far each is recognised.

Positions in m from the middle of the field, x along it. The carpet is 6 m x 4 m, the playing area
5.4 m x 3.6 m.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.planner.potential_field import Recognition, Sources, sources_of

CARPET = (6.0, 4.0)
PLAYING_AREA = (5.4, 3.6)
CELL = 0.10
START = (2.4, -0.1, float(np.pi / 2.0))
"""The true start of both experiments (section 3.1)."""

Place = tuple[float, float]


@dataclass(frozen=True)
class LandmarkField:
    """A field: its landmarks, how far each class is recognised, and the lines to draw (n, 2)."""

    name: str
    landmarks: LandmarkMap
    recognitions: Mapping[str, Recognition]
    lines: tuple[NDArray[np.float64], ...]

    @property
    def sources(self) -> Sources:
        """The landmarks as sources of the potential field."""
        return sources_of(self.landmarks, self.recognitions)


def carpet() -> OccupancyMap:
    """Return where a robot may be: everywhere on the carpet."""
    rows, cols = round(CARPET[1] / CELL), round(CARPET[0] / CELL)
    origin = (-CARPET[0] / 2.0, -CARPET[1] / 2.0, 0.0)
    return OccupancyMap(GridGeometry(rows, cols, CELL, origin), np.zeros((rows, cols), np.int8))


def robocup_field() -> LandmarkField:
    """Return the field of the four-legged league, 2006 (figure 1, table 1).

    Positions by the rules of 2005, as far as they are known: the paper prints none.
    """
    signs = (1.0, -1.0)
    corners = [(2.7 * a, 1.8 * b) for a, b in product(signs, signs)]
    box = [(2.05 * a, 0.65 * b) for a, b in product(signs, signs)]
    meetings = [(2.7 * a, 0.65 * b) for a, b in product(signs, signs)]
    halfway = [(0.0, 1.8 * b) for b in signs]
    beacons = [(1.35 * a, 1.95 * b) for a, b in product(signs, signs)]
    goals = [(2.7 * a, 0.0) for a in signs]
    return LandmarkField(
        "RoboCup 2006 four-legged field",
        _landmarks(
            unique={"goal": goals, "beacon": beacons, "circle": [(0.0, 0.0)]},
            alike={"L": corners + box, "T": halfway + meetings},
        ),
        {
            "goal": Recognition(5.692, 0.650),
            "beacon": Recognition(4.000, 0.600),
            "circle": Recognition(1.800, 0.200),
            "L": Recognition(1.200, 0.150),
            "T": Recognition(1.200, 0.150),
        },
        (*_playing_area(), _box(1.0), _box(-1.0), _circle(0.18)),
    )


def similar_field() -> LandmarkField:
    """Return a field whose halves look the same (figure 3, table 2).

    The paper prints no positions. Here the four alike landmarks of one half, turned by half a
    turn about the middle, are those of the other: whoever sees nothing but these has for every
    pose another one that fits exactly as well. The two unique ones stand in the middle, out of
    sight from the start.
    """
    half = [(2.6, 0.5), (2.0, 0.5), (1.7, -0.3), (2.4, -0.8)]
    return LandmarkField(
        "Field with exactly similar parts",
        _landmarks(
            unique={"square": [(0.0, 0.3)], "disc": [(0.0, -0.3)]},
            alike={"cone": half + [(-x, -y) for x, y in half]},
        ),
        {
            "square": Recognition(1.800, 0.180),
            "disc": Recognition(1.800, 0.180),
            "cone": Recognition(1.000, 0.150),
        },
        _playing_area(),
    )


def _landmarks(unique: Mapping[str, list[Place]], alike: Mapping[str, list[Place]]) -> LandmarkMap:
    """Return landmarks by class; each of a unique class is told from its likes."""
    positions, classes, identities = [], [], []
    for kinds, is_unique in ((unique, True), (alike, False)):
        for kind, places in kinds.items():
            for number, place in enumerate(places, start=1):
                positions.append(place)
                classes.append(kind)
                identities.append(f"{kind} {number}" if is_unique else None)
    return LandmarkMap(np.array(positions), tuple(classes), tuple(identities))


def _playing_area() -> tuple[NDArray[np.float64], ...]:
    x, y = PLAYING_AREA[0] / 2.0, PLAYING_AREA[1] / 2.0
    border = np.array([(x, y), (-x, y), (-x, -y), (x, -y), (x, y)])
    return border, np.array([(0.0, y), (0.0, -y)])


def _box(side: float) -> NDArray[np.float64]:
    return np.array([(2.7, 0.65), (2.05, 0.65), (2.05, -0.65), (2.7, -0.65)]) * (side, 1.0)


def _circle(radius: float) -> NDArray[np.float64]:
    turns = np.linspace(0.0, 2.0 * np.pi, 49)
    return radius * np.column_stack([np.cos(turns), np.sin(turns)])
