"""Where the nodes of a finished map stand: in openings, before them, at bends, and in between.

Zhuang et al. 2005, 2.2: nodes lie by equal spacing, which is simple but leaves some without
features, or by variable spacing, only where enough features can be bound. All lie half way between
walls, as the paper's lie on the middle line of its corridor.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.corners import Corners
from pilotage.topology.from_map.chords import medial_cells
from pilotage.topology.from_map.openings import Openings
from pilotage.topology.from_map.rooms import WIDE, Room, room_at
from pilotage.topology.from_map.space import Mask, Space
from pilotage.topology.topological_map import NodeKind, Spacing

OPEN = 0.7
"""Share of the usual distance from walls at which a place is no niche."""
A_STEP = 1.2
"""m that the node before an opening stands from it in a place too wide to have a middle."""


@dataclass(frozen=True)
class NodeParams:
    """How close nodes stand."""

    spacing: Spacing = "variable"
    distance: float = 4.0
    """m between the nodes of equal spacing; with variable spacing every place of the middle line
    has a node within one and a half times that."""
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
        return self._chosen(self.rooms == number)

    def away_from(self, points: NDArray[np.float64], apart: float) -> "MiddleLine":
        """Return the part that is `apart` m and more from all points (m, 2); all if none is."""
        gaps = self.poses[:, None, :2] - points
        far = np.asarray((np.hypot(gaps[..., 0], gaps[..., 1]) >= apart).all(axis=1))
        return self._chosen(far) if far.any() else self

    def _chosen(self, which: NDArray[np.bool_]) -> "MiddleLine":
        return MiddleLine(self.poses[which], self.rooms[which], self.clearance[which])


def middle_line(space: Space, openings: Openings, least: float, can_stand: Mask) -> MiddleLine:
    """Return the middle line of a space, `least` m and more from the walls.

    Only where a robot can stand (rows, cols); of a room with a furnished middle all that is left.
    """
    found = medial_cells(space, least)
    found = found[can_stand[tuple(found[:, :2].T)]]
    reached = np.unique(openings.labels[tuple(found[:, :2].T)])
    left = np.argwhere(can_stand & ~np.isin(openings.labels, np.append(reached, 0)))
    cells = np.concatenate([found[:, :2], left])
    up, right = (found[:, 4:] - found[:, 2:4]).T
    along = np.concatenate([np.arctan2(right, -up), np.zeros(len(left))])
    heading = wrap(along + space.geometry.origin[2])
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
        part = line.of_room(number).away_from(_openings_of(openings, room), params.apart / 2.0)
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


def _openings_of(openings: Openings, room: Room) -> NDArray[np.float64]:
    """Return the middles (n, 2) of the openings of a room."""
    beside = (openings.rooms == room.number).any(axis=1)
    middles: NDArray[np.float64] = openings.chords.middles[beside]
    return middles


def _anchors(openings: Openings, room: Room, corners: Corners) -> NDArray[np.float64]:
    """Return the points (n, 2) that nodes of a room should stand near, the needful first.

    Before its openings; and in corridors at bends and mouths, where walls jut out.
    """
    before = _openings_of(openings, room)
    if room.kind != "corridor":
        return before
    return np.concatenate([before, corners.poses[corners.convex, :2]])


def _in_room(
    line: MiddleLine, anchors: NDArray[np.float64], room: Room, params: NodeParams
) -> list[int]:
    """Return which places of a room's middle line become nodes."""
    if params.spacing == "equal":
        return _evenly(line, params.distance)
    chosen = _at_anchors(line, anchors, room, params.apart)
    if not chosen or room.kind != "corridor":
        _add(line, chosen, int(np.argmax(line.clearance)), params.apart)
    return _without_holes(line, chosen, 1.5 * params.distance)


def _at_anchors(
    line: MiddleLine, anchors: NDArray[np.float64], room: Room, apart: float
) -> list[int]:
    """Return the places before the anchors: on the middle of the room, or a step into a hall."""
    middle = room.width / 2.0 if room.width <= WIDE else A_STEP
    openness = np.minimum(line.clearance, 0.95 * middle)
    chosen: list[int] = []
    for anchor in anchors:
        away = _away(line, anchor)
        # Twice: a step from the opening to the middle of the room gains as much as it costs.
        nearest = int(np.argmin(away - 2.0 * openness))
        if away[nearest] <= 1.5 * middle + apart / 2.0:
            _add(line, chosen, nearest, apart)
    return chosen


def _add(line: MiddleLine, chosen: list[int], place: int, apart: float) -> None:
    """Choose a place unless another one stands near."""
    if np.all(_away(line, line.poses[place])[chosen] >= apart):
        chosen.append(place)


def _without_holes(line: MiddleLine, chosen: list[int], hole: float) -> list[int]:
    """Return the chosen places and a few more, so that no open one is farther than `hole` m.

    Open ones are no narrower than most of the line is: nothing needs a node in a niche.
    """
    is_open = line.clearance >= OPEN * np.median(line.clearance)
    away = np.where(is_open, np.inf, 0.0)
    for place in chosen:
        away = np.minimum(away, _away(line, line.poses[place]))
    while away.max() > hole:
        farthest = int(np.argmax(away))
        chosen.append(farthest)
        away = np.minimum(away, _away(line, line.poses[farthest]))
    return chosen


def _evenly(line: MiddleLine, distance: float) -> list[int]:
    """Return places from one end of the line on, each `distance` m from those before it."""
    chosen = [int(np.argmax(_away(line, line.poses[0])))]
    away = _away(line, line.poses[chosen[0]])
    while away.max() >= distance:
        beyond = np.where(away >= distance, away, np.inf)
        chosen.append(int(np.argmin(beyond)))
        away = np.minimum(away, _away(line, line.poses[chosen[-1]]))
    return chosen


def _away(line: MiddleLine, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far (n,) the places of a line are from a point, m."""
    return np.asarray(np.hypot(*(line.poses[:, :2] - point[:2]).T))
