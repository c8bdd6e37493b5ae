"""Corners: where two nearly perpendicular walls nearly meet (Zhuang et al. 2005, eq. 1-3).

Eq. 1 is printed as `| |arctan(..) - arctan(..) - 90| < e_theta`: arctangents of slopes, whose
difference jumps by 180 degrees where a wall turns through the vertical. Meant is the angle
between the two walls, each looked at from the corner; it is measured here by wrapped directions,
so that 90 and -90 degrees both count and no orientation of the building is special.

Eq. 3 takes the middle between the near ends for the corner, "because e_d is small". A laser's
lines stop up to a beam's spacing short of the corner, so that middle lies inside the room: by
43 mm rms in simulated rooms (0.5 degrees, 1 cm), where the crossing of the two lines errs by
2 mm. The crossing is therefore the tip, unless eq. 3 is asked for.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.lines import Lines
from pilotage.core.near_points import near_pairs


@dataclass(frozen=True)
class CornerParams:
    """The paper's two thresholds, which it leaves to experiment."""

    most_off_square: float = float(np.deg2rad(15.0))
    """rad, e_theta: how far from perpendicular the walls may be (eq. 1)."""
    most_apart: float = 0.3
    """m, e_d: how far apart the near ends may lie (eq. 2)."""
    tip: Literal["crossing", "mean of ends"] = "crossing"
    """Where the corner is said to be; "mean of ends" is eq. 3 to the letter."""


@dataclass(frozen=True)
class Corners:
    """Corners in the frame of their lines.

    `poses` (k, 3): the tip, and the direction of the bisector into free space. `covariances`
    (k, 2, 2) of the tips, m^2. `convex` (k,): the wall juts out, as at a corridor's mouth;
    otherwise it is the inner corner of a room. `lines` (k, 2): indices of the walls, free space
    on the left: the corner is the second end of the one and the first end of the other.
    """

    poses: NDArray[np.float64]
    covariances: NDArray[np.float64]
    convex: NDArray[np.bool_]
    lines: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.poses)


def find_corners(lines: Lines, params: CornerParams = CornerParams()) -> Corners:
    """Return the corners that lines form two by two.

    Both walls are seen from free space on their left, so a corner is where one ends and the
    other begins; the two faces of the end of a thin wall are no corner with each other.
    """
    pairs = _pairs(lines, params)
    inward = _normals(lines, pairs[:, 0]) + _normals(lines, pairs[:, 1])
    outward = _away(lines, pairs[:, 0], 1) + _away(lines, pairs[:, 1], 0)
    tips, covariances = (_crossings if params.tip == "crossing" else _means)(lines, pairs)
    poses = np.column_stack([tips, wrap(np.arctan2(inward[:, 1], inward[:, 0]))])
    convex = np.sum(inward * outward, axis=1) < 0.0
    return Corners(poses, covariances, convex, pairs)


def _pairs(lines: Lines, params: CornerParams) -> NDArray[np.int64]:
    """Return the pairs (k, 2) that eq. 1 and 2 accept, the wall that ends there first."""
    near = near_pairs(lines.ends[:, 1], lines.ends[:, 0], params.most_apart)
    first, second = near[:, 0], near[:, 1]
    one, two = _away(lines, first, 1), _away(lines, second, 0)
    between = wrap(np.arctan2(one[:, 1], one[:, 0]) - np.arctan2(two[:, 1], two[:, 0]))
    square = np.abs(np.abs(between) - np.pi / 2.0) < params.most_off_square
    pairs: NDArray[np.int64] = near[square & (first != second)]
    return pairs


def _normals(lines: Lines, which: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return unit vectors (k, 2) into free space."""
    alpha = lines.polar[which, 0]
    return np.column_stack([np.cos(alpha), np.sin(alpha)])


def _away(lines: Lines, which: NDArray[np.int64], end: int) -> NDArray[np.float64]:
    """Return unit vectors (k, 2) along the walls, from their first (0) or second (1) end."""
    vectors = lines.ends[which, 1 - end] - lines.ends[which, end]
    unit: NDArray[np.float64] = vectors / np.hypot(*vectors.T)[:, None]
    return unit


def _crossings(
    lines: Lines, pairs: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where the walls cross (k, 2), and the covariances (k, 2, 2)."""
    if len(pairs) == 0:
        return np.empty((0, 2)), np.empty((0, 2, 2))
    normals = np.stack([_normals(lines, which) for which in pairs.T], axis=1)
    unmixed = np.linalg.inv(normals)
    tips = (unmixed @ lines.polar[pairs, 1][:, :, None])[:, :, 0]
    variances = np.stack([_variances_at(lines, which, tips) for which in pairs.T], axis=1)
    covariances: NDArray[np.float64] = (unmixed * variances[:, None]) @ unmixed.transpose(0, 2, 1)
    return tips, covariances


def _means(
    lines: Lines, pairs: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the middles between the near ends (k, 2), and the covariances (k, 2, 2).

    Across its wall an end is as uncertain as the line there; along it, it may stop short of the
    corner by as much as the other end lies ahead.
    """
    ends = lines.ends[pairs[:, 0], 1], lines.ends[pairs[:, 1], 0]
    total = np.zeros((len(pairs), 2, 2))
    for which, end in zip(pairs.T, ends, strict=True):
        normals = _normals(lines, which)
        along = np.column_stack([-normals[:, 1], normals[:, 0]])
        short = np.sum((ends[0] - ends[1]) * along, axis=1)
        across = _variances_at(lines, which, end)
        total += across[:, None, None] * normals[:, :, None] * normals[:, None]
        total += (short**2)[:, None, None] * along[:, :, None] * along[:, None]
    return (ends[0] + ends[1]) / 2.0, total / 4.0


def _variances_at(
    lines: Lines, which: NDArray[np.int64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the variances (k,) of lines along their normals at points (k, 2), m^2."""
    normals = _normals(lines, which)
    along = np.column_stack([-normals[:, 1], normals[:, 0]])
    places = np.sum(points * along, axis=1)
    # A point of the line at place s moves by d rho - s d alpha along the normal.
    jacobian = np.stack([-places, np.ones(len(places))], axis=1)
    variances: NDArray[np.float64] = np.einsum(
        "ki,kij,kj->k", jacobian, lines.covariances[which], jacobian
    )
    return variances
