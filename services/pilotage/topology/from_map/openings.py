"""Doors and passages of a map, and the rooms between them.

Zhuang et al. 2005, 2.2: a passage is the opening between neighbouring, rather closed spaces, a
door one with a frame. All chords cut the free space into pieces; chords whose pieces are not
closed enough are taken away again, the least fitting first, until all that are left hold.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pilotage.topology.from_map.chords import Chords
from pilotage.topology.from_map.space import Space

BAND = np.linspace(-0.15, 0.15, 7)
"""m beside a chord's line: a wall there continues the line."""
FLANKS = np.array([0.2, 0.3, 0.4, 0.5])
"""m before a wall's face, past bumps and pilasters."""
SLIVER = 0.1
"""m^2: what is smaller was cut off by the steps of a chord's line, and is as little a room."""


@dataclass(frozen=True)
class OpeningParams:
    """Which chords are openings, and which of these are doors."""

    least_room: float = 3.0
    """m^2: what is smaller behind an opening is a niche."""
    door_share: float = 0.75
    """A door is at most so wide, for each metre that a square as large as the room is wide."""
    passage_share: float = 0.5
    """The same of a passage: without a frame only a small opening makes two spaces of one."""
    widest_door: float = 2.6
    """m; two leaves."""
    single_door: float = 1.25
    """m: an opening of a single leaf's width is a door wherever walls bound it."""
    framed: float = 1.05
    """A wider door is narrower than what lies behind it, to either side."""


@dataclass(frozen=True)
class Openings:
    """Openings and the rooms that they join.

    `chords`: (n). `is_door` (n,). `rooms` (n, 2): to the left of the chord, to the right; from 1.
    `labels` (rows, cols): the room of each cell of the space, 0 where there is none.
    """

    chords: Chords
    is_door: NDArray[np.bool_]
    rooms: NDArray[np.int64]
    labels: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.is_door)


def find_openings(space: Space, chords: Chords, params: OpeningParams) -> Openings:
    """Return the doors and passages among the chords of a space, and the rooms between them."""
    is_door = _is_door(space, chords, params)
    pieces, areas = _pieces_between(space, chords)
    sides = _pieces_beside(space, chords, pieces)
    share = np.where(is_door, params.door_share, params.passage_share)
    pieces_to_rooms = _closed_rooms(sides, areas, (chords.widths / share, chords.salience), params)
    # Piece 0 is what is not free: it comes first, and so it stays 0.
    _, room_of_piece = np.unique(pieces_to_rooms, return_inverse=True)
    rooms = room_of_piece[sides]
    keep = (rooms[:, 0] != rooms[:, 1]) & (rooms > 0).all(axis=1)
    labels = np.asarray(room_of_piece, np.int32)[pieces]
    return Openings(chords.chosen(keep), is_door[keep], rooms[keep], labels)


def _is_door(space: Space, chords: Chords, params: OpeningParams) -> NDArray[np.bool_]:
    """Say which chords (n,) have jambs: walls that go on beyond both ends."""
    widths = chords.widths
    walled = np.array([_is_walled(space, chords, i) for i in range(len(widths))], bool)
    flanked = np.array([_is_flanked(space, chords, i) for i in range(len(widths))], bool)
    in_wall = flanked & (widths <= params.widest_door) & (chords.framing >= params.framed)
    return walled & (in_wall | (widths <= params.single_door))


def _is_walled(space: Space, chords: Chords, i: int) -> bool:
    """Say whether walls continue chord `i` for 0.2 m beyond either end."""
    beyond = np.linspace(0.05, 0.2, 4)
    for end, way in _ends(chords, i):
        at = end + beyond[:, None, None] * way + BAND[:, None] * chords.across[i]
        is_free = space.free_at(at.reshape(-1, 2)).reshape(len(beyond), len(BAND))
        if is_free.all(axis=1).any():
            return False
    return True


def _is_flanked(space: Space, chords: Chords, i: int) -> bool:
    """Say whether chord `i` is a hole in a wall: free before the wall beside both its ends."""
    beside = np.linspace(0.1, 0.4, 6)
    for side in (chords.across[i], -chords.across[i]):
        flanks = []
        for end, way in _ends(chords, i):
            at = end + FLANKS[:, None, None] * side + beside[:, None] * way
            is_free = space.free_at(at.reshape(-1, 2)).reshape(len(FLANKS), len(beside))
            flanks.append(is_free.mean(axis=1).max())
        if min(flanks) > 0.8:
            return True
    return False


def _ends(chords: Chords, i: int) -> tuple[tuple[NDArray[np.float64], NDArray[np.float64]], ...]:
    """Return each end of a chord and the unit vector that leads out of the opening there."""
    return (chords.ends[i, 0], -chords.along[i]), (chords.ends[i, 1], chords.along[i])


def opening_cells(space: Space, chords: Chords) -> NDArray[np.bool_]:
    """Return the cells (rows, cols) under chords: without them nothing leads through."""
    under = np.zeros(space.geometry.shape, np.uint8)
    for ends in chords.ends:
        first, second = space.geometry.cells_of(ends)[:, ::-1]
        cv2.line(under, first.tolist(), second.tolist(), (1,), thickness=2)
    return np.asarray(under > 0)


def _pieces_between(space: Space, chords: Chords) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return the pieces (rows, cols) that all chords cut a space into, and their areas, m^2."""
    cut = (space.is_free & ~opening_cells(space, chords)).astype(np.uint8)
    _, pieces, sizes, _ = cv2.connectedComponentsWithStats(cut, connectivity=4)
    areas = sizes[:, cv2.CC_STAT_AREA].astype(float) * space.resolution**2
    return np.where(areas[pieces] < SLIVER, 0, pieces).astype(np.int32), areas


def _pieces_beside(space: Space, chords: Chords, pieces: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return the pieces (n, 2) to the left and to the right of chords; 0 where there is none."""
    sides = np.zeros((len(chords.ends), 2), np.int64)
    for column, sign in enumerate((1.0, -1.0)):
        for step in range(7, 1, -1):
            at = chords.middles + sign * step * space.resolution * chords.across
            cells = space.geometry.cells_of(at)
            cells = np.clip(cells, 0, np.array(space.geometry.shape) - 1)
            found = pieces[tuple(cells.T)]
            sides[:, column] = np.where(found > 0, found, sides[:, column])
    return sides


def _closed_rooms(
    sides: NDArray[np.int64],
    areas: NDArray[np.float64],
    claims: tuple[NDArray[np.float64], NDArray[np.float64]],
    params: OpeningParams,
) -> NDArray[np.int64]:
    """Return to which room each piece belongs, named by one of its pieces; 0 stays 0.

    Args:
        sides: the pieces (n, 2) that chords part.
        areas: of the pieces (m,), m^2.
        claims: how wide (n,) a square of the smaller room's area must be for each chord, m; and
            the salience of each chord, by which those of a niche are taken away.
        params: how large a room is at least.
    """
    needed, salience = claims
    room_of = np.arange(len(areas))
    areas = areas.copy()
    while True:
        rooms = room_of[sides]
        parts = (rooms[:, 0] != rooms[:, 1]) & (rooms > 0).all(axis=1)
        smaller = np.minimum(*areas[rooms].T)
        in_niche = 10.0 + needed / salience
        misfit = needed / np.sqrt(smaller + 1e-9)
        misfit = np.where(smaller < params.least_room, in_niche, misfit)
        misfit[~parts] = 0.0
        if len(misfit) == 0 or misfit.max() <= 1.0:
            return room_of
        kept, lost = rooms[int(np.argmax(misfit))]
        room_of[room_of == lost] = kept
        areas[kept] += areas[lost]
