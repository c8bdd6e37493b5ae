"""Where the nodes of a finished map stand: in openings, before them, at bends, and in between.

Zhuang et al. 2005, 2.2: nodes lie by equal spacing, which is simple but leaves some without
features, or by variable spacing, only where enough features can be bound. All lie half way between
walls, as the paper's lie on the middle line of its corridor.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.corners import Corners
from pilotage.topology.map_chords import medial_cells
from pilotage.topology.map_openings import Openings
from pilotage.topology.map_rooms import WIDE, Room, room_at
from pilotage.topology.map_space import Space
from pilotage.topology.topological_map import NodeKind

Spacing = Literal["variable", "equal"]

A_STEP = 1.2
"""m that the node before an opening stands from it in a place too wide to have a middle."""


@dataclass(frozen=True)
class NodeParams:
    """How close nodes stand."""

    spacing: Spacing = "variable"
    distance: float = 4.0
    """m between the nodes of equal spacing; variable spacing leaves no larger hole than twice
    that."""
    apart: float = 1.2
    """Nodes within a room keep so far from each other, m."""
    least_clearance: float = 0.3
    """m from walls."""


@dataclass(frozen=True)
class Site:
    """A place for a node: `pose` (3,) in map, in `room`, or in `opening` between two."""

    kind: NodeKind
    pose: NDArray[np.float64]
    room: int = 0
    opening: int | None = None


@dataclass(frozen=True)
class MiddleLine:
    """Places half way between walls: `poses` (n, 3) along the way, `rooms` and `clearance` (n,)."""

    poses: NDArray[np.float64]
    rooms: NDArray[np.int64]
    clearance: NDArray[np.float64]

    def of_room(self, number: int) -> "MiddleLine":
        """Return the part in one room."""
        inside = self.rooms == number
        return MiddleLine(self.poses[inside], self.rooms[inside], self.clearance[inside])


def middle_line(space: Space, openings: Openings, least: float) -> MiddleLine:
    """Return the middle line of a space, `least` m and more from the walls."""
    found = medial_cells(space, least)
    cells, walls = found[:, :2], found[:, 2:]
    up, right = (walls[:, 2:] - walls[:, :2]).T
    heading = wrap(np.arctan2(right, -up) + space.geometry.origin[2])
    poses = np.column_stack([space.geometry.centres_of(cells), heading])
    clearance = space.clearance[tuple(cells.T)].astype(float)
    return MiddleLine(poses, room_at(openings, space, poses[:, :2]), clearance)


def place_nodes(
    line: MiddleLine,
    openings: Openings,
    rooms: dict[int, Room],
    corners: Corners,
    params: NodeParams,
) -> list[Site]:
    """Return where nodes stand: first in the openings, then room by room."""
    sites = [_in_opening(openings, i) for i in range(len(openings))]
    for number, room in rooms.items():
        part = line.of_room(number)
        if len(part.poses):
            chosen = _in_room(part, _anchors(openings, room, corners), room, params)
            sites += [Site("node", part.poses[i], number) for i in chosen]
    return sites


def _in_opening(openings: Openings, i: int) -> Site:
    chords = openings.chords
    x, y = chords.middles[i]
    across = chords.across[i]
    pose = np.array([x, y, wrap(float(np.arctan2(across[1], across[0])))])
    return Site("door" if openings.is_door[i] else "passage", pose, opening=i)


def _anchors(openings: Openings, room: Room, corners: Corners) -> NDArray[np.float64]:
    """Return the points (n, 2) that nodes of a room should stand near, the needful first.

    Before its openings; and in corridors at bends and mouths, where walls jut out.
    """
    beside = (openings.rooms == room.number).any(axis=1)
    before = openings.chords.middles[beside]
    if room.kind != "corridor":
        return before
    return np.concatenate([before, corners.poses[corners.convex, :2]])


def _in_room(
    line: MiddleLine, anchors: NDArray[np.float64], room: Room, params: NodeParams
) -> list[int]:
    """Return which places of a room's middle line become nodes."""
    chosen: list[int] = []
    if params.spacing == "variable":
        chosen = _at_anchors(line, anchors, room, params.apart)
    if not chosen or room.kind == "room":
        _add(line, chosen, int(np.argmax(line.clearance)), params.apart)
    hole = params.distance * (2.0 if params.spacing == "variable" else 1.0)
    return _filled(line, chosen, hole)


def _at_anchors(
    line: MiddleLine, anchors: NDArray[np.float64], room: Room, apart: float
) -> list[int]:
    """Return the places before the anchors: on the middle of the room, or a step into a hall."""
    middle = room.width / 2.0 if room.width <= WIDE else A_STEP
    openness = np.minimum(line.clearance, 0.95 * middle)
    chosen: list[int] = []
    for anchor in anchors:
        away = np.hypot(*(line.poses[:, :2] - anchor).T)
        # Twice: a step from the opening to the middle of the room gains as much as it costs.
        nearest = int(np.argmin(away - 2.0 * openness))
        if away[nearest] <= 1.5 * middle + apart / 2.0:
            _add(line, chosen, nearest, apart)
    return chosen


def _add(line: MiddleLine, chosen: list[int], place: int, apart: float) -> None:
    """Choose a place unless another one stands near."""
    away = np.hypot(*(line.poses[chosen, :2] - line.poses[place, :2]).T)
    if np.all(away >= apart):
        chosen.append(place)


def _filled(line: MiddleLine, chosen: list[int], hole: float) -> list[int]:
    """Return the chosen places and the fewest more that leave none farther than half a hole, m."""
    away = np.full(len(line.poses), np.inf)
    for place in chosen:
        away = np.minimum(away, np.hypot(*(line.poses[:, :2] - line.poses[place, :2]).T))
    while away.max() > hole / 2.0 * 1.5:
        farthest = int(np.argmax(away))
        chosen.append(farthest)
        step = np.hypot(*(line.poses[:, :2] - line.poses[farthest, :2]).T)
        away = np.minimum(away, step)
    return chosen
