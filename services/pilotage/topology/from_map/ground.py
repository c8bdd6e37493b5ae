"""The ground of a map that a robot can drive on, furniture and all, and nodes moved onto it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.from_map.nodes import Site
from pilotage.topology.from_map.space import Space

NEAR = 0.6
"""m within which a node may move to ground that a robot can stand on."""


@dataclass(frozen=True)
class GroundParams:
    """Where a robot may go, and where it rather goes."""

    body: float = 0.2
    """Least distance from walls, m."""
    ease: float = 0.6
    """Distance from walls, m, from which on it does not matter."""
    dislike: float = 3.0
    """How many times dearer a metre right beside a wall is."""


def cell_costs(space: Space, params: GroundParams) -> NDArray[np.float32]:
    """Return what a metre costs in each cell (rows, cols); infinite where no robot fits."""
    clearance = space.clearance
    tight = np.clip((params.ease - clearance) / (params.ease - params.body), 0.0, 1.0)
    costs = 1.0 + params.dislike * tight
    return np.where(clearance > params.body, costs, np.inf).astype(np.float32)


def on_ground(
    ground: Space, costs: NDArray[np.float32], sites: list[Site]
) -> tuple[list[Site], NDArray[np.int64]]:
    """Return the sites that a robot can stand on or right beside, and their cells (n, 2)."""
    kept, cells = [], []
    taken: set[tuple[int, int]] = set()
    for site in sites:
        cell = _standing(ground, costs, site.pose)
        if cell is not None and cell not in taken:
            taken.add(cell)
            x, y = ground.geometry.centres_of([cell])[0]
            kept.append(replace(site, pose=np.array([x, y, site.pose[2]])))
            cells.append(cell)
    return kept, np.array(cells, np.int64).reshape(-1, 2)


def _standing(
    ground: Space, costs: NDArray[np.float32], pose: NDArray[np.float64]
) -> tuple[int, int] | None:
    """Return the cell nearest to a pose (3,) that a robot fits in; None if none is near."""
    row, col = ground.geometry.cells_of([pose[:2]])[0]
    reach = int(np.ceil(NEAR / ground.resolution))
    top, left = max(row - reach, 0), max(col - reach, 0)
    near = np.argwhere(np.isfinite(costs[top : row + reach + 1, left : col + reach + 1]))
    if len(near) == 0:
        return None
    near += (top, left)
    best = near[int(np.argmin(np.hypot(*(near - (row, col)).T)))]
    return int(best[0]), int(best[1])
