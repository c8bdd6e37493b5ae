"""The rooms of a map: what lies between its openings, sorted by shape and named."""

from collections import Counter
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.from_map.openings import Openings
from pilotage.topology.from_map.space import Space

RoomKind = Literal["corridor", "hall", "room"]

LONG = 2.5
"""A corridor is so many times as long as wide, at least."""
WIDE = 5.0
"""m: what is wider is no corridor."""
LARGE = 80.0
"""m^2: what is no corridor and larger is a hall."""


@dataclass(frozen=True)
class Room:
    """A room: `number` as in the labels of the openings, `area` m^2, `width` m where it is widest.

    `name` is for people: corridor 1, hall 1, room 1 and so on, the largest of its kind first.
    """

    number: int
    kind: RoomKind
    name: str
    area: float
    width: float


def rooms_of(space: Space, openings: Openings) -> dict[int, Room]:
    """Return the rooms by their numbers."""
    labels = openings.labels
    areas = np.bincount(labels.ravel()) * space.resolution**2
    widths = np.zeros(len(areas))
    np.maximum.at(widths, labels.ravel(), 2.0 * space.clearance.ravel())
    largest = [int(i) for i in np.argsort(-areas, kind="stable") if i > 0 and areas[i] > 0.0]
    counted: Counter[str] = Counter()
    rooms = {}
    for i in largest:
        kind = _kind(areas[i], widths[i])
        counted[kind] += 1
        name = f"{kind} {counted[kind]}"
        rooms[i] = Room(i, kind, name, float(areas[i]), float(widths[i]))
    return rooms


def _kind(area: float, width: float) -> RoomKind:
    if area >= LONG * width**2 and width <= WIDE:
        return "corridor"
    return "hall" if area >= LARGE else "room"


def room_at(openings: Openings, space: Space, points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the rooms (n,) that points (n, 2) of the map lie in, 0 where in none."""
    cells = space.geometry.cells_of(points)
    inside = space.geometry.contains(cells)
    rooms = np.zeros(len(cells), np.int64)
    rooms[inside] = openings.labels[tuple(cells[inside].T)]
    return rooms
