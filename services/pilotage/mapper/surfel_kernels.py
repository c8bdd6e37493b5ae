"""Kernels that make a map of surfels from points: cells, directions of walls, who is nearest."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel


class SurfelMap(NamedTuple):
    """A piece of map as surfels, with the nearest one of every place around them.

    `means` (m, 2) with `normals` (m, 2) across the wall there, and `flatness` (m,): 1 a straight
    wall, 0 a blob. `nearest` (rows, cols) numbers the nearest surfel around each cell of `cell` m
    from `corner` (2,), -1 where none is within reach, and `distance` (rows, cols) says in m how far
    it is from the cell's centre.
    """

    means: NDArray[np.float64]
    normals: NDArray[np.float64]
    flatness: NDArray[np.float64]
    corner: NDArray[np.float64]
    cell: float
    nearest: NDArray[np.int32]
    distance: NDArray[np.float32]

    def distances_at(self, points: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the distances (n,) from the cells of points (n, 2), infinite beyond reach."""
        cols, rows = np.floor((points - self.corner) / self.cell).astype(np.int64).T
        height, width = self.distance.shape
        inside = (rows >= 0) & (rows < height) & (cols >= 0) & (cols < width)
        found = np.full(len(points), np.inf, np.float32)
        found[inside] = self.distance[rows[inside], cols[inside]]
        return found


@kernel
def thin_points(points: NDArray[np.float64], size: float) -> NDArray[np.float64]:
    """Return one point, the mean, per square of `size` m that holds any of the points (n, 2).

    Near walls send back many beams and far ones few; thinned, each metre of wall counts alike.
    """
    count = len(points)
    if count == 0:
        return np.empty((0, 2))
    left, low = points[:, 0].min(), points[:, 1].min()
    cells = np.empty(count, np.int64)
    for i in range(count):
        col, row = int((points[i, 0] - left) / size), int((points[i, 1] - low) / size)
        cells[i] = row * 4_000_000 + col
    order = np.argsort(cells)
    kept = np.empty((count, 2))
    n = 0
    i = 0
    while i < count:
        cell, x, y, many = cells[order[i]], 0.0, 0.0, 0
        while i < count and cells[order[i]] == cell:
            x += points[order[i], 0]
            y += points[order[i], 1]
            many += 1
            i += 1
        kept[n, 0], kept[n, 1] = x / many, y / many
        n += 1
    return kept[:n].copy()


@kernel
def pool_points(
    points: NDArray[np.float64], corner: NDArray[np.float64], index: NDArray[np.int32], size: float
) -> NDArray[np.float64]:
    """Return the means (m, 2) of the points (n, 2) per cell, and number the cells.

    `index` (rows, cols), all -1 before, becomes the number of the mean in each cell of `size` m
    from `corner`.
    """
    sums = np.zeros((len(points), 2))
    counts = np.zeros(len(points))
    n = 0
    for i in range(len(points)):
        col = int((points[i, 0] - corner[0]) / size)
        row = int((points[i, 1] - corner[1]) / size)
        at = index[row, col]
        if at < 0:
            at = n
            index[row, col] = n
            n += 1
        sums[at, 0] += points[i, 0]
        sums[at, 1] += points[i, 1]
        counts[at] += 1.0
    for k in range(n):
        sums[k, 0] /= counts[k]
        sums[k, 1] /= counts[k]
    return sums[:n].copy()


@kernel
def wall_directions(
    means: NDArray[np.float64],
    corner: NDArray[np.float64],
    index: NDArray[np.int32],
    size: float,
    reach: int,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the normal (m, 2) of the wall at each mean and how flat it is there (m,), 0 to 1.

    Principal directions of the means within `reach` cells; 1 is a straight line, 0 a blob or a
    lone point.
    """
    normals = np.zeros((len(means), 2))
    flatness = np.zeros(len(means))
    rows, cols = index.shape
    for k in range(len(means)):
        col = int((means[k, 0] - corner[0]) / size)
        row = int((means[k, 1] - corner[1]) / size)
        n, sx, sy, sxx, sxy, syy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
        for r in range(max(0, row - reach), min(rows, row + reach + 1)):
            for c in range(max(0, col - reach), min(cols, col + reach + 1)):
                j = index[r, c]
                if j >= 0:
                    x, y = means[j, 0] - means[k, 0], means[j, 1] - means[k, 1]
                    n += 1
                    sx += x
                    sy += y
                    sxx += x * x
                    sxy += x * y
                    syy += y * y
        if n < 3:
            continue
        vxx, vxy, vyy = sxx - sx * sx / n, sxy - sx * sy / n, syy - sy * sy / n
        half, root = 0.5 * (vxx + vyy), np.sqrt(0.25 * (vxx - vyy) ** 2 + vxy * vxy)
        large, small = half + root, max(half - root, 0.0)
        along = 0.5 * np.arctan2(2.0 * vxy, vxx - vyy)
        normals[k, 0], normals[k, 1] = -np.sin(along), np.cos(along)
        flatness[k] = 1.0 - np.sqrt(small / large) if large > 1e-9 else 0.0
    return normals, flatness


@kernel
def spread_nearest(
    means: NDArray[np.float64],
    corner: NDArray[np.float64],
    shape: tuple[int, int],
    size: float,
    reach: int,
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return for each cell of a raster the nearest mean within `reach` cells, else -1, and how far.

    The distance (m) is from the cell's centre; where there is none it is infinite.
    """
    nearest = np.full(shape, -1, np.int32)
    distance = np.full(shape, np.inf, np.float32)
    for k in range(len(means)):
        x, y = (means[k, 0] - corner[0]) / size, (means[k, 1] - corner[1]) / size
        row, col = int(y), int(x)
        for r in range(max(0, row - reach), min(shape[0], row + reach + 1)):
            dy = r + 0.5 - y
            for c in range(max(0, col - reach), min(shape[1], col + reach + 1)):
                dx = c + 0.5 - x
                apart = np.float32(np.sqrt(dx * dx + dy * dy) * size)
                if apart < distance[r, c]:
                    distance[r, c] = apart
                    nearest[r, c] = k
    return nearest, distance
