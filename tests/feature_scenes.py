"""Features of a corridor with doors, and what a robot in it sees of them."""

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.topology.features import KINDS, FeatureKind, Features
from pilotage.topology.topological_map import Edge, Node, TopologicalMap

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


def corridor_map(world: Features, nodes: list[float], reach: float = 5.0) -> TopologicalMap:
    """Return nodes along y = 0 at these x, each bound to the features within `reach` m of it."""
    placed = [
        Node(k, "node", f"node {k}", np.array([x, 0.0, 0.0]), world.chosen(_near(world, x, reach)))
        for k, x in enumerate(nodes)
    ]
    edges = [
        Edge(len(nodes) + k, k, k + 1, "corridor", b - a, np.array([[a, 0.0], [b, 0.0]]))
        for k, (a, b) in enumerate(pairwise(nodes))
    ]
    return TopologicalMap("corridor", tuple(placed), tuple(edges))


def _near(world: Features, x: float, reach: float) -> NDArray[np.bool_]:
    near: NDArray[np.bool_] = np.abs(world.poses[:, 0] - x) <= reach
    return near


def long_corridor() -> Features:
    """Return a corridor of 30 m along x with doors of two widths at uneven distances."""
    left = [1.2, 3.0, 7.1, 9.2, 13.5, 15.1, 19.0, 22.6, 24.1, 28.0]
    right = [2.2, 5.9, 8.0, 11.7, 14.2, 18.1, 20.9, 23.4, 27.2]
    doors = [door(x, 1.0, width=0.9 + 0.4 * (k % 3 == 0)) for k, x in enumerate(left)]
    doors += [door(x, -1.0, width=0.9 + 0.4 * (k % 4 == 1)) for k, x in enumerate(right)]
    ends = [corner(0.0, 1.0, -np.pi / 4.0), corner(0.0, -1.0, np.pi / 4.0)]
    ends += [corner(30.0, 1.0, -3.0 * np.pi / 4.0), corner(30.0, -1.0, 3.0 * np.pi / 4.0)]
    return Features.joined([*doors, *ends])
