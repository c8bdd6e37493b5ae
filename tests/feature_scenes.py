"""Features of a corridor with doors, and what a robot in it sees of them."""

import numpy as np
from numpy.typing import ArrayLike

from pilotage.core import se2
from pilotage.topology.features import KINDS, FeatureKind, Features

SIGMA_PLACE, SIGMA_TURN = 0.03, 0.05
"""m and rad by which each feature is seen wrongly."""


def feature(kind: FeatureKind, pose: tuple[float, float, float], width: float = np.nan) -> Features:
    """Return one feature."""
    return Features(
        np.array([KINDS.index(kind)]),
        np.array([pose]),
        np.array([width]),
        SIGMA_PLACE**2 * np.eye(2)[None],
    )


def door(x: float, y: float, turn: float = np.pi / 2.0, width: float = 0.9) -> Features:
    """Return a door in a wall along x, if not turned."""
    return feature("door", (x, y, turn), width)


def corner(x: float, y: float, turn: float) -> Features:
    """Return a corner that opens toward `turn`."""
    return feature("corner", (x, y, turn))


def uneven_corridor() -> Features:
    """Return the end of a corridor along x, 2 m wide, with doors at uneven distances."""
    return Features.joined(
        [
            corner(0.0, 1.0, -np.pi / 4.0),
            corner(0.0, -1.0, np.pi / 4.0),
            door(1.5, 1.0),
            door(2.6, -1.0),
            door(4.7, 1.0, width=1.2),
            feature("passage", (5.6, -1.0, np.pi / 2.0), 2.0),
            corner(4.6, -1.0, 3.0 * np.pi / 4.0),
        ]
    )


def even_corridor(count: int = 6, spacing: float = 1.0) -> Features:
    """Return doors on both sides of a corridor along x, exactly alike and evenly spaced."""
    places = [(spacing * (k + 1), side) for k in range(count) for side in (1.0, -1.0)]
    return Features.joined([door(x, y) for x, y in places])


def seen_from(
    pose: ArrayLike,
    world: Features,
    rng: np.random.Generator | None = None,
    missed: float = 0.0,
    reach: float = 8.0,
) -> Features:
    """Return the features ahead of a robot at `pose` (3,), in base_link, noisy with an `rng`."""
    seen = world.moved(se2.inverse(pose))
    near = (np.hypot(*seen.poses[:, :2].T) < reach) & (seen.poses[:, 0] > 0.0)
    if rng is None:
        return seen.chosen(near)
    near &= rng.random(len(seen)) >= missed
    kept = seen.chosen(near)
    noise = rng.normal(size=kept.poses.shape) * [SIGMA_PLACE, SIGMA_PLACE, SIGMA_TURN]
    spread = np.tile(SIGMA_PLACE**2 * np.eye(2), (len(kept), 1, 1))
    poses = kept.poses + noise
    # An opening's direction is either way.
    flips = np.where(kept.kinds != 0, rng.integers(0, 2, len(kept)) * np.pi, 0.0)
    poses[:, 2] = (poses[:, 2] + flips + np.pi) % (2.0 * np.pi) - np.pi
    return Features(kept.kinds, poses, kept.widths, spread)
