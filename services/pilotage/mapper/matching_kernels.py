"""Kernel of the scan matcher: one step's normal equations of points against surfels."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.mapper.surfel_kernels import SurfelMap


@kernel
def normal_equations(
    pose: NDArray[np.float64],
    points: NDArray[np.float64],
    walls: SurfelMap,
    sigmas: tuple[float, float, float],
) -> tuple[NDArray[np.float64], NDArray[np.float64], float, int]:
    """Return H (3, 3), g (3,), the mean robust cost and the count of points near a surfel.

    Residual of a point is its place less its surfel's mean, weighed across the wall by `sigmas[0]`
    m and along it by a sigma that grows from that to `sigmas[1]` with flatness, robustly
    (Geman-McClure of scale `sigmas[2]` m). The pose's error is (x, y, theta), the translation in
    the map frame, the rotation about the pose.
    """
    corner_x, corner_y, cell = walls.corner[0], walls.corner[1], walls.cell
    across, along, scale = sigmas
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    H, g = np.zeros((3, 3)), np.zeros(3)
    cost, seen = 0.0, 0
    rows, cols = walls.nearest.shape
    J = np.zeros(3)
    for i in range(len(points)):
        rx = cos * points[i, 0] - sin * points[i, 1]
        ry = sin * points[i, 0] + cos * points[i, 1]
        x, y = pose[0] + rx, pose[1] + ry
        col, row = int(np.floor((x - corner_x) / cell)), int(np.floor((y - corner_y) / cell))
        k = -1
        if 0 <= row < rows and 0 <= col < cols:
            k = walls.nearest[row, col]
        if k < 0:
            cost += 1.0
            continue
        seen += 1
        nx, ny, flat = walls.normals[k, 0], walls.normals[k, 1], walls.flatness[k]
        if flat <= 0.0:
            nx, ny = 1.0, 0.0
        ex, ey = x - walls.means[k, 0], y - walls.means[k, 1]
        en, et = nx * ex + ny * ey, nx * ey - ny * ex
        sigma_t = across + (along - across) * flat
        # Far along a straight wall is still on it; far across it is not.
        wn, wt = 1.0 / (across * across), 1.0 / (sigma_t * sigma_t)
        chi = (wn * en * en + wt * et * et) * across * across / (scale * scale)
        robust = 1.0 / ((1.0 + chi) * (1.0 + chi))
        cost += chi / (1.0 + chi)
        J[0], J[1], J[2] = nx, ny, -nx * ry + ny * rx
        for a in range(3):
            g[a] += robust * wn * J[a] * en
            for b in range(3):
                H[a, b] += robust * wn * J[a] * J[b]
        J[0], J[1], J[2] = -ny, nx, ny * ry + nx * rx
        for a in range(3):
            g[a] += robust * wt * J[a] * et
            for b in range(3):
                H[a, b] += robust * wt * J[a] * J[b]
    return H, g, cost / max(1, len(points)), seen
