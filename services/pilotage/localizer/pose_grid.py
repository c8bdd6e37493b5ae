"""The states of the Markov grid: cells of the map times headings (Wu & Bell 2003, section 2)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.grid_resampling import resample
from pilotage.localizer.kernels import Admissible

MERGED = 256
"""Working on this many needless columns costs no more than starting another run (measured)."""


@dataclass(frozen=True)
class PoseGridParams:
    """Parameters of the state space.

    `resolution`: cell size [m]; a finer map is resampled, a coarser one used as it is.
    `headings`: layers of the belief; 72 are 5 degrees each (the paper's).
    `most_states`: a larger building gets coarser cells, so that the belief fits the memory.
    """

    resolution: float = 0.10
    headings: int = 72
    most_states: int = 100_000_000


@dataclass(frozen=True)
class PoseGrid:
    """The state space over a map: `geometry` of a layer, `headings` layers, where states exist.

    `asked_resolution`: the cell size [m] that map and parameters ask for; if it is smaller than
    the geometry's, memory did not allow it (`is_coarsened`).
    """

    world: OccupancyMap
    geometry: GridGeometry
    headings: int
    admissible: Admissible
    asked_resolution: float

    @property
    def is_coarsened(self) -> bool:
        """Whether the cells are coarser than asked for, because of `most_states`."""
        return self.geometry.resolution > self.asked_resolution

    @property
    def heading_step(self) -> float:
        """Width of a heading bin [rad]."""
        return 2.0 * np.pi / self.headings

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape (headings, rows, cols) of the belief."""
        return self.headings, *self.geometry.shape

    @property
    def admissible_states(self) -> int:
        """The paper's |Omega|."""
        return self.headings * int(self.admissible.mask.sum())


def pose_grid(world: OccupancyMap, params: PoseGridParams) -> PoseGrid:
    """Return the state space over a map; ValueError if the map has no free cell."""
    if not world.is_free.any():
        raise ValueError("the map has no free cell: a robot can be nowhere on it")
    asked = max(params.resolution, world.geometry.resolution)
    cells = resample(world, max(asked, _least_resolution(world, params)))
    if not cells.is_free.any():
        raise ValueError("the map has no free cell: a robot can be nowhere on it")
    geometry, is_free = _cropped(cells)
    return PoseGrid(world, geometry, params.headings, _admissible(is_free), asked)


def _cropped(cells: OccupancyMap) -> tuple[GridGeometry, NDArray[np.bool_]]:
    """Return the smallest grid that holds all free cells, and which of its cells are free."""
    old, is_free = cells.geometry, cells.is_free
    rows, cols = np.nonzero(is_free.any(axis=1))[0], np.nonzero(is_free.any(axis=0))[0]
    bottom, left = int(rows[0]), int(cols[0])
    inside = is_free[bottom : rows[-1] + 1, left : cols[-1] + 1]
    corner = [left * old.resolution, bottom * old.resolution, 0.0]
    x, y, theta = (float(value) for value in se2.compose(old.origin, corner))
    geometry = GridGeometry(len(inside), inside.shape[1], old.resolution, (x, y, theta))
    return geometry, np.ascontiguousarray(inside)


def _least_resolution(world: OccupancyMap, params: PoseGridParams) -> float:
    """Return the finest cell size [m] of which `most_states` cover the part that is free."""
    rows, cols = (np.nonzero(world.is_free.any(axis=axis))[0] for axis in (1, 0))
    cells = float(np.ptp(rows) + 1) * float(np.ptp(cols) + 1)
    states = cells * params.headings
    return world.geometry.resolution * float(np.sqrt(states / params.most_states))


def _admissible(is_free: NDArray[np.bool_]) -> Admissible:
    """Return mask and runs; runs that less than MERGED columns part become one."""
    runs: list[tuple[int, int, int]] = []
    edges = np.diff(np.pad(is_free, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    for row in np.nonzero(is_free.any(axis=1))[0]:
        starts, ends = np.nonzero(edges[row] == 1)[0], np.nonzero(edges[row] == -1)[0]
        parted = starts[1:] - ends[:-1] >= MERGED
        firsts, lasts = starts[np.append(True, parted)], ends[np.append(parted, True)]
        runs.extend((int(row), int(a), int(b)) for a, b in zip(firsts, lasts, strict=True))
    return Admissible(
        is_free.astype(np.float32), np.array(runs, np.int64), _gaps(runs, is_free.shape)
    )


def _gaps(runs: list[tuple[int, int, int]], shape: tuple[int, ...]) -> NDArray[np.int64]:
    """Return the stretches (n, 3) of the rows that lie in no run."""
    rows, cols = shape
    gaps, end = [], [0] * rows
    for row, first, last in runs:
        gaps.append((row, end[row], first))
        end[row] = last
    gaps.extend((row, end[row], cols) for row in range(rows))
    return np.array(sorted(gap for gap in gaps if gap[1] < gap[2]), np.int64).reshape(-1, 3)
