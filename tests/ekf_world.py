"""Walls drawn by their ends, and a robot that sees pieces of them with the noise it claims."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.lines import Lines
from pilotage.localizer.ekf_walls import Walls

Array = NDArray[np.float64]

SEEN = np.array([[1e-4, 0.0], [0.0, 4e-4]])
"""Covariance of a seen line: 0.01 rad and 0.02 m."""
MAPPED = np.array([[2.5e-5, 0.0], [0.0, 1e-4]])
"""Covariance of a line of the map about its middle: 0.005 rad and 0.01 m."""

ROOM = ((0.0, 0.0), (8.0, 0.0), (8.0, 5.0), (0.0, 5.0))
"""Corners of a room; walking along them the free space lies on the left."""
NICHED = (
    (0.0, 0.0),
    (5.0, 0.0),
    (5.0, -1.0),
    (6.5, -1.0),
    (6.5, 0.0),
    (9.0, 0.0),
    (9.0, 6.0),
    (3.5, 6.0),
    (3.5, 5.0),
    (0.0, 5.0),
)
"""A room with a niche and a bay: its walls lie at several distances."""


def lines_between(ends: ArrayLike, covariance: Array = SEEN) -> Lines:
    """The lines with these ends (n, 2, 2), free space on the left of each."""
    given = np.asarray(ends, float).reshape(-1, 2, 2)
    along = given[:, 1] - given[:, 0]
    alpha = np.asarray(wrap(np.arctan2(along[:, 0], -along[:, 1])))
    normal = np.stack([np.cos(alpha), np.sin(alpha)], axis=1)
    rho = np.sum(normal * given[:, 0], axis=1)
    # Errors belong to the middle of a wall; rho is that of the origin.
    lever = np.sum(np.stack([-normal[:, 1], normal[:, 0]], axis=1) * given.mean(axis=1), axis=1)
    jacobian = np.zeros((len(given), 2, 2))
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
    jacobian[:, 1, 0] = lever
    covariances = jacobian @ covariance @ jacobian.transpose(0, 2, 1)
    return Lines(given, np.stack([alpha, rho], axis=1), covariances)


def walls_around(corners: ArrayLike, covariance: Array = MAPPED) -> Walls:
    """The walls of a room by its corners (n, 2), in order."""
    given = np.asarray(corners, float)
    return Walls.of(lines_between(np.stack([given, np.roll(given, -1, 0)], axis=1), covariance))


def corridor(length: float = 60.0, width: float = 2.4) -> Walls:
    """Two bare walls along x, whose ends nobody sees."""
    half, side = length / 2.0, width / 2.0
    ends = [[[half, side], [-half, side]], [[-half, -side], [half, -side]]]
    return Walls.of(lines_between(ends, MAPPED))


def erring(lines: Lines, covariance: Array, rng: np.random.Generator) -> Lines:
    """The lines, each wrong by an error of this covariance about its middle."""
    errors = rng.multivariate_normal(np.zeros(2), covariance, len(lines))
    middle = lines.ends.mean(axis=1)
    alpha = np.asarray(wrap(lines.polar[:, 0] + errors[:, 0]))
    normal = np.stack([np.cos(alpha), np.sin(alpha)], axis=1)
    along = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    half = lines.lengths[:, None] / 2.0
    moved = middle + errors[:, 1:] * normal
    ends = np.stack([moved - half * along, moved + half * along], axis=1)
    return lines_between(ends, covariance)


def seen_from(pose: ArrayLike, walls: Walls, rng: np.random.Generator, reach: float = 6.0) -> Walls:
    """What a robot at a pose (3,) sees within reach [m]: pieces of the walls, in base_link."""
    near = walls.near(np.asarray(pose, float), reach).lines
    ends = [piece for piece in map(_piece, near.moved(se2.inverse(pose)).ends) if piece is not None]
    clipped = [piece for piece in (_within(piece, reach) for piece in ends) if piece is not None]
    exact = lines_between(np.array(clipped).reshape(-1, 2, 2))
    return Walls.of(erring(exact, SEEN, rng))


def _piece(ends: Array) -> Array | None:
    """A wall, if its free side is the robot's."""
    along = ends[1] - ends[0]
    return ends if ends[0, 0] * along[1] - ends[0, 1] * along[0] > 0.0 else None


def _within(ends: Array, reach: float) -> Array | None:
    """The part (2, 2) of a piece within reach of the origin, if it is worth seeing."""
    along = ends[1] - ends[0]
    length = float(np.hypot(*along))
    unit = along / length
    foot = -float(ends[0] @ unit)
    off = float(np.hypot(*(ends[0] + foot * unit)))
    if off >= reach:
        return None
    half = np.sqrt(reach**2 - off**2)
    low, high = max(0.0, foot - half), min(length, foot + half)
    return np.array([ends[0] + low * unit, ends[0] + high * unit]) if high - low > 0.4 else None
