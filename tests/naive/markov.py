"""The passes over the belief, state by state, in float64 and plain Python.

Twins of `localizer.kernels` and of the tables that they look things up in. They return what the
kernel leaves in place, and know nothing of runs: only of the mask of admissible cells.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from naive.raycast import cast_ray_in_grid
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap

Array = NDArray[np.float64]
Mask = NDArray[np.float32]


def covered(mask: Mask, runs: NDArray[np.int64]) -> NDArray[np.bool_]:
    """The cells that lie in any run."""
    inside = np.zeros(mask.shape, bool)
    for row, first, last in runs:
        inside[row, first:last] = True
    return inside


def runs_of(mask: Mask, merged: int) -> list[tuple[int, int, int]]:
    """Row, first and end of the stretches of ones; `merged` zeros or more part two of them."""
    runs: list[tuple[int, int, int]] = []
    for row, line in enumerate(mask):
        for col in np.nonzero(line)[0]:
            same_row = bool(runs) and runs[-1][0] == row
            if same_row and col - runs[-1][2] < merged:
                runs[-1] = (row, runs[-1][1], int(col) + 1)
            else:
                runs.append((row, int(col), int(col) + 1))
    return runs


def add_floor(belief: Array, mask: Mask, scale: float, floor: float, heading: Array) -> Array:
    """Twin of `kernels.weigh_prior`: the prior of eq. 8 and eq. 12 in every state."""
    prior = np.zeros(belief.shape)
    for k, row, col in np.ndindex(belief.shape):
        if mask[row, col]:
            prior[k, row, col] = (belief[k, row, col] * scale + floor) * heading[k]
    return prior


def weigh_scan(
    belief: Array,
    mask: Mask,
    beams: NDArray[np.int64],
    costs: NDArray[np.uint8],
    likelihood: NDArray[np.float32],
) -> Array:
    """Twin of `kernels.weigh_scan`."""
    weighed = belief.copy()
    for k, row, col in np.ndindex(belief.shape):
        if mask[row, col]:
            total = sum(int(costs[c, row + up, col + right]) for c, up, right in beams[k])
            weighed[k, row, col] *= likelihood[total]
    return weighed


def weigh_ranges(
    belief: Array,
    mask: Mask,
    directions: NDArray[np.int64],
    levels: NDArray[np.uint8],
    likelihoods: NDArray[np.float32],
) -> Array:
    """Twin of `kernels.weigh_ranges` (eq. 14)."""
    weighed = belief.copy()
    for k, row, col in np.ndindex(belief.shape):
        if mask[row, col]:
            for beam, direction in enumerate(directions[k]):
                weighed[k, row, col] *= likelihoods[k, beam, levels[direction, row, col]]
    return weighed


def shifted(likelihoods: Array, ranges: Array, ahead: float) -> Array:
    """Twin of `kernels.shift_levels`, for one beam and layer: what is read between the levels."""
    return np.append(np.interp(ranges[:-1] - ahead, ranges, likelihoods), likelihoods[-1])


def beams_through_walls(
    directions: NDArray[np.int64],
    allowed: NDArray[np.uint8],
    levels: NDArray[np.uint8],
    state: tuple[int, int, int],
) -> int:
    """How many beams of a state (heading, row, col) are longer than its expected ranges allow."""
    k, row, col = state
    pairs = zip(directions[k], allowed, strict=True)
    return sum(int(levels[direction, row, col] < least) for direction, least in pairs)


def sum_runs(belief: Array, runs: NDArray[np.int64]) -> tuple[Array, Array]:
    """Twin of `kernels.sum_runs`: sums and maxima (headings, runs)."""
    pieces = [[layer[row, first:last] for row, first, last in runs] for layer in belief]
    mass = np.array([[math.fsum(piece) for piece in layer] for layer in pieces])
    peak = np.array([[max(piece) for piece in layer] for layer in pieces])
    return mass, peak


def entropy_bits(belief: Array) -> float:
    """Entropy of a belief that need not sum to one."""
    share = belief.ravel() / math.fsum(belief.ravel())
    return -math.fsum(b * math.log2(b) for b in share if b > 0.0)


def shift_layer(layer: Array, up: int, right: int) -> Array:
    """Twin of `kernels.shift_layers`, for one layer."""
    moved = np.zeros(layer.shape)
    for row, col in np.ndindex(layer.shape):
        if 0 <= row + up < layer.shape[0] and 0 <= col + right < layer.shape[1]:
            moved[row + up, col + right] = layer[row, col]
    return moved


def spread_layer(layer: Array, share: float) -> Array:
    """Twin of `kernels.spread_layers`, for one layer; what would leave stays."""
    for axis in (0, 1):
        spread = (1.0 - 2.0 * share) * layer
        for cell in np.ndindex(layer.shape):
            for step in (-1, 1):
                other = list(cell)
                other[axis] = min(max(cell[axis] + step, 0), layer.shape[axis] - 1)
                spread[tuple(other)] += share * layer[cell]
        layer = spread
    return layer


def spread_headings(belief: Array, share: float, shifts: NDArray[np.int64]) -> Array:
    """Twin of `kernels.spread_headings`: each state gives to the nearest state either side."""
    headings = len(belief)
    spread = (1.0 - 2.0 * share) * belief
    for k, row, col in np.ndindex(belief.shape):
        ahead, behind = (k + 1) % headings, k - 1
        # The next layer lies shifts[k] farther, so the same place has a smaller index there.
        for layer, shift in ((ahead, -shifts[k]), (behind, shifts[behind])):
            there = row + shift[0], col + shift[1]
            if 0 <= there[0] < belief.shape[1] and 0 <= there[1] < belief.shape[2]:
                spread[layer, there[0], there[1]] += share * belief[k, row, col]
    return spread


def range_likelihood(
    measured: float, expected: float, range_max: float, model: tuple[float, float, float]
) -> float:
    """Eq. 5 with outliers and silence, for one beam; `model` is delta, outlier, no_echo."""
    delta, outlier, no_echo = model
    if math.isinf(measured) or measured == range_max:
        return 1.0 if expected >= range_max else no_echo
    hit = math.exp(-((min(measured, range_max) - expected) ** 2) / (2.0 * delta**2))
    return outlier + (1.0 - outlier) * hit


def expected_range(
    world: OccupancyMap, point: tuple[float, float], direction: float, range_max: float
) -> float:
    """The range in m from a point of the map frame, `range_max` where nothing is met."""
    geometry = world.geometry
    ray = se2.compose(se2.inverse(geometry.origin), [*point, direction])
    x, y = ray[:2] / geometry.resolution
    cells = cast_ray_in_grid(world.is_wall, x, y, float(ray[2]), range_max / geometry.resolution)
    return min(cells * geometry.resolution, range_max)


def end_likelihood(distance: float, sigma: float, outlier: float) -> float:
    """How likely a laser's beam ends at a distance from the nearest wall (best: 1)."""
    return outlier + (1.0 - outlier) * math.exp(-(distance**2) / (2.0 * sigma**2))


def distance_at(world: OccupancyMap, point: tuple[float, float]) -> float:
    """Distance in m from the centre of the cell that holds a point to the nearest wall's."""
    (cell,) = world.geometry.cells_of([point])
    if not world.geometry.contains(np.array([cell]))[0]:
        return math.inf
    walls = np.argwhere(world.is_wall)
    if not len(walls):
        return math.inf
    return float(np.hypot(*(walls - cell).T).min()) * world.geometry.resolution


def largest_neighbour(levels: NDArray[np.uint8], state: tuple[int, int, int]) -> int:
    """The largest level among a state's 27 neighbours; headings go round, cells end."""
    headings, rows, cols = levels.shape
    k, row, col = state
    return max(
        int(levels[turned % headings, r, c])
        for turned in (k - 1, k, k + 1)
        for r, c in _around(row, col)
        if 0 <= r < rows and 0 <= c < cols
    )


def _around(row: int, col: int) -> Iterator[tuple[int, int]]:
    return ((r, c) for r in range(row - 1, row + 2) for c in range(col - 1, col + 2))


def cell_centre(geometry: GridGeometry, row: int, col: int) -> tuple[float, float]:
    """The centre of a cell in the map frame."""
    x, y = (col + 0.5) * geometry.resolution, (row + 0.5) * geometry.resolution
    pose = se2.compose(geometry.origin, [x, y, 0.0])
    return float(pose[0]), float(pose[1])


def compass_likelihood(yaw: float, heading: float, eps: float) -> float:
    """Eq. 12 to the letter."""
    return float((math.cos((yaw - heading) / 2.0) ** 2) ** (1.0 / eps))


def tile_sums(belief: Array, phases: NDArray[np.int64], side: int) -> Array:
    """What the states of each tile (headings, tile rows, tile cols) weigh together."""
    tiles = [-(-length // side) + 1 for length in belief.shape[1:]]
    sums = np.zeros((len(belief), *tiles))
    for k, row, col in np.ndindex(belief.shape):
        up, right = phases[k]
        sums[k, (row + side - up) // side, (col + side - right) // side] += belief[k, row, col]
    return sums
