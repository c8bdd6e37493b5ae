"""Kernels of the smoother: points against the walls that others show, and banded systems."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.mapper.wall_kernels import wall_of


class Bins(NamedTuple):
    """Points sorted into squares of `size` m from `corner` (2,).

    Square c (counted row by row, `cols` each) holds the points numbered `order[start[c]]` to
    `order[start[c + 1] - 1]`.
    """

    corner: NDArray[np.float64]
    size: float
    rows: int
    cols: int
    start: NDArray[np.int64]
    order: NDArray[np.int64]


class Pull(NamedTuple):
    """How points are weighed: `sigma` m of one, and residuals beyond `scale` m count less and less.

    Points are compared with those of poses at least `nearest` and at most `farthest` numbers away.
    """

    sigma: float
    scale: float
    nearest: int
    farthest: int


@kernel
def binned(points: NDArray[np.float64], size: float) -> Bins:
    """Sort points (n, 2), n at least one, into squares with one to spare around them."""
    corner = np.array([points[:, 0].min() - 1.5 * size, points[:, 1].min() - 1.5 * size])
    cols = int((points[:, 0].max() - corner[0]) / size) + 2
    rows = int((points[:, 1].max() - corner[1]) / size) + 2
    start = np.zeros(rows * cols + 1, np.int64)
    cells = np.empty(len(points), np.int64)
    for i in range(len(points)):
        row, col = int((points[i, 1] - corner[1]) / size), int((points[i, 0] - corner[0]) / size)
        cells[i] = row * cols + col
        start[cells[i] + 1] += 1
    for c in range(rows * cols):
        start[c + 1] += start[c]
    free, order = start.copy(), np.empty(len(points), np.int64)
    for i in range(len(points)):
        order[free[cells[i]]] = i
        free[cells[i]] += 1
    return Bins(corner, size, rows, cols, start, order)


@kernel
def pull_to_walls(
    poses: NDArray[np.float64],
    points: NDArray[np.float64],
    owners: NDArray[np.int64],
    bins: Bins,
    pull: Pull,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return H (m, 3, 3) and g (m, 3) of the points of each pose (m, 3) against others' walls.

    `points` (n, 2) are in the frame of the poses, seen from pose number `owners` (n,), and sorted
    into `bins` as large as the reach of a wall. Errors of a pose are (x, y, theta), the rotation
    about itself.
    """
    H, g = np.zeros((len(poses), 3, 3)), np.zeros((len(poses), 3))
    J = np.zeros(3)
    for i in range(len(points)):
        k = owners[i]
        kind, (nx, ny, off, spread) = _wall_at(points, owners, i, bins, pull)
        if kind < 2:
            continue
        robust = 1.0 / (1.0 + off * off / (pull.scale * pull.scale))
        weight = robust * robust / (pull.sigma * pull.sigma + spread)
        J[0], J[1] = nx, ny
        J[2] = ny * (points[i, 0] - poses[k, 0]) - nx * (points[i, 1] - poses[k, 1])
        for a in range(3):
            g[k, a] += weight * J[a] * off
            for b in range(3):
                H[k, a, b] += weight * J[a] * J[b]
    return H, g


@kernel
def _wall_at(
    points: NDArray[np.float64], owners: NDArray[np.int64], i: int, bins: Bins, pull: Pull
) -> tuple[int, tuple[float, float, float, float]]:
    """Return `wall_of` the points around point i that other poses have seen."""
    x, y = points[i, 0], points[i, 1]
    row, col = int((y - bins.corner[1]) / bins.size), int((x - bins.corner[0]) / bins.size)
    weight, sx, sy, sxx, sxy, syy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for r in range(row - 1, row + 2):
        for c in range(col - 1, col + 2):
            square = r * bins.cols + c
            for q in range(bins.start[square], bins.start[square + 1]):
                j = bins.order[q]
                apart = abs(owners[j] - owners[i])
                ex, ey = points[j, 0] - x, points[j, 1] - y
                near = 1.0 - (ex * ex + ey * ey) / (bins.size * bins.size)
                if near > 0.0 and pull.nearest <= apart <= pull.farthest:
                    weight += near
                    sx += near * ex
                    sy += near * ey
                    sxx += near * ex * ex
                    sxy += near * ex * ey
                    syy += near * ey * ey
    return wall_of(weight, (sx, sy), (sxx, sxy, syy))


@kernel
def solve_banded(band: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return x (n,) of A x = right for a positive definite A, by Cholesky.

    `band` (n, k): row i holds A[i, i], A[i, i - 1], ... A[i, i - k + 1].
    """
    n, width = band.shape
    L, x = band.copy(), right.copy()
    for i in range(n):
        for d in range(min(width - 1, i), -1, -1):
            j = i - d
            for q in range(max(0, i - width + 1, j - width + 1), j):
                L[i, d] -= L[i, i - q] * L[j, j - q]
            L[i, d] = np.sqrt(L[i, 0]) if d == 0 else L[i, d] / L[j, 0]
    for i in range(n):
        for q in range(max(0, i - width + 1), i):
            x[i] -= L[i, i - q] * x[q]
        x[i] /= L[i, 0]
    for i in range(n - 1, -1, -1):
        for q in range(i + 1, min(n, i + width)):
            x[i] -= L[q, q - i] * x[q]
        x[i] /= L[i, 0]
    return x
