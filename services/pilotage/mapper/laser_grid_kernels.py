"""Drawing a scan into a grid: which cells its beams cross, and what each cell learns from it.

Exact traversal after Amanatides & Woo 1987, "A fast voxel traversal algorithm", in whole numbers:
points stand at the middles of a raster `PARTS` times as fine as the cells, so no point lies on a
border between cells, and a mirrored or turned scan crosses the mirrored or turned cells. A beam
that passes exactly through a corner where four cells meet goes from one to the opposite one.

A cell's evidence is one int16. Its three lowest bits say whether the cell is known at all, whether
a beam ever passed it, and whether what stands there lasted; the rest is log-odds, `STEP` or more
being positive.
Each kernel has a plain twin in tests/naive/laser_grid.py.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

PARTS = 1024
"""Raster of points to a side of a cell; 0.05 mm of a cell of 0.05 m."""

KNOWN, PASSED, PROVEN = 1, 2, 4
"""Lowest bits of evidence."""

STEP = 8
"""Evidence comes in multiples of this, so that the lowest bits stay."""

SKIPPED, PASSING, HIT = -1, 0, 1
"""Kinds of beams: not used, without a return, ending on something."""

HIT_MARK = 2
"""Mark of a cell that the scan has hit; 1 marks those that beams cross."""

RUN = 32
"""Cells in a row that are looked at together."""

SHARE = 1 << 16
"""The share of a beam that it may graze its wall is counted in such parts."""

ALONE, HIDDEN, LARGE = 0, 1, 2
"""Surfaces: narrow and seen whole, narrow with something before it, wider than a person."""

ROW_OF_SAME_WALL = 0.94
"""Cosine between the steps to the neighbouring ends of beams that end on one plane wall."""


class Layers(NamedTuple):
    """The arrays (rows, cols) of a grid.

    `evidence`: int16 as above, 0 never seen. `since`: int32, the tick of the hit since which the
    evidence is positive; meaningless where it is not. `marks`: uint8, all zero between scans.
    """

    evidence: NDArray[np.int16]
    since: NDArray[np.int32]
    marks: NDArray[np.uint8]


class Reading(NamedTuple):
    """How beams become steps over cells.

    `per_metre`: cells to a metre; `longest`: beams are cut there; `depth` of the face of a wall,
    in which a grazing beam runs before it ends; `graze`: the longest such run; all in cells. `gap`,
    `piece`: ends no farther apart than the one are one surface, which is no person if its own ends
    are farther apart than the other; m.
    """

    per_metre: float
    longest: float
    depth: float
    graze: float
    gap: float
    piece: float


class Weights(NamedTuple):
    """`hit`, `miss`: how far evidence goes up or down; `low`, `high`: its limits, without bits.

    `lasting`: ticks after which an obstacle that is hit again is proven; `glimpse`: ticks that do
    for one that something hides in part.
    """

    hit: int
    miss: int
    low: int
    high: int
    lasting: int
    glimpse: int


class Moment(NamedTuple):
    """`tick` of the scan; the least surface on which a hit needs nothing to confirm it."""

    tick: int
    sure_from: int


class Place(NamedTuple):
    """Where a scan is drawn.

    `corner`: row and col of the first cell of the layers; `start`: x, y of the laser on the raster;
    `window`: rows and cols (from, to, from, to) that the beams touch.
    """

    corner: tuple[int, int]
    start: tuple[int, int]
    window: tuple[int, int, int, int]


@kernel
def raster(cells: float) -> int:
    """Return a length in cells as the odd number of half raster steps nearest to it."""
    return 2 * math.floor(cells * (PARTS // 2)) + 1


@kernel
def slant(
    ends: NDArray[np.float64], is_hit: NDArray[np.bool_], i: int, at: tuple[float, float]
) -> float:
    """Return the sine of the angle between beam `i` and the wall it ends on; 1 if it is unknown.

    The wall is known where the ends before and after lie in one row with this one; the beam
    starts `at` x, y.
    """
    if i == 0 or i + 1 == len(ends) or not (is_hit[i - 1] and is_hit[i + 1]):
        return 1.0
    x, y = ends[i, 0], ends[i, 1]
    back_x, back_y = x - ends[i - 1, 0], y - ends[i - 1, 1]
    on_x, on_y = ends[i + 1, 0] - x, ends[i + 1, 1] - y
    along = back_x * on_x + back_y * on_y
    squares = (back_x * back_x + back_y * back_y) * (on_x * on_x + on_y * on_y)
    if not (along > 0.0 and along * along > ROW_OF_SAME_WALL**2 * squares):
        return 1.0
    wall_x, wall_y = back_x + on_x, back_y + on_y
    beam_x, beam_y = x - at[0], y - at[1]
    squares = (wall_x * wall_x + wall_y * wall_y) * (beam_x * beam_x + beam_y * beam_y)
    across = abs(wall_x * beam_y - wall_y * beam_x)
    return across / math.sqrt(squares) if squares > 0.0 else 1.0


@kernel
def read_beams(
    beams: NDArray[np.int64],
    origin: tuple[float, float],
    ends: NDArray[np.float64],
    is_hit: NDArray[np.bool_],
    reading: Reading,
) -> tuple[int, int, int, int]:
    """Fill `beams` (n, 5): x, y on the raster, kind, share that may graze its wall, surface.

    Beams of no length, or that have no number for an end, are skipped.

    Returns:
        The least and greatest row and col that the scan touches, greatest exclusive.
    """
    start_x, start_y = origin[0] * reading.per_metre, origin[1] * reading.per_metre
    low_x = high_x = raster(start_x)
    low_y = high_y = raster(start_y)
    for i in range(len(ends)):
        along_x = ends[i, 0] * reading.per_metre - start_x
        along_y = ends[i, 1] * reading.per_metre - start_y
        length = math.sqrt(along_x * along_x + along_y * along_y)
        if not (math.isfinite(length) and length > 0.0):
            beams[i, 2] = SKIPPED
            continue
        x, y = raster(ends[i, 0] * reading.per_metre), raster(ends[i, 1] * reading.per_metre)
        beams[i, 2] = HIT if is_hit[i] else PASSING
        if length > reading.longest:
            cut = reading.longest / length
            x, y = raster(start_x + cut * along_x), raster(start_y + cut * along_y)
            beams[i, 2] = PASSING
        beams[i, 0], beams[i, 1] = x, y
        beams[i, 3] = 0
        if beams[i, 2] == HIT:
            sine = slant(ends, is_hit, i, origin)
            run = min(reading.graze, reading.depth * (1.0 / max(sine, 1e-6) - 1.0))
            beams[i, 3] = int(SHARE * min(1.0, run / length))
        low_x, high_x = min(low_x, x), max(high_x, x)
        low_y, high_y = min(low_y, y), max(high_y, y)
    find_surfaces(beams, origin, ends, reading)
    return low_y // PARTS, high_y // PARTS + 1, low_x // PARTS, high_x // PARTS + 1


@kernel
def find_surfaces(
    beams: NDArray[np.int64],
    origin: tuple[float, float],
    ends: NDArray[np.float64],
    reading: Reading,
) -> None:
    """Say in `beams` what each hit may lie on: something `LARGE`, `HIDDEN` in part, or `ALONE`."""
    first, last = 0, len(ends)
    for i in range(1, last + 1):
        is_next = i < last and beams[i - 1, 2] == HIT and beams[i, 2] == HIT
        if is_next and squared_length(ends[i - 1], ends[i, 0], ends[i, 1]) <= reading.gap**2:
            continue
        if beams[first, 2] == HIT:
            surface = ALONE
            end_x, end_y = ends[i - 1, 0], ends[i - 1, 1]
            if squared_length(ends[first], end_x, end_y) > reading.piece**2:
                surface = LARGE
            elif (first > 0 and hides(beams, origin, ends, (first - 1, first))) or (
                i < last and hides(beams, origin, ends, (i, i - 1))
            ):
                surface = HIDDEN
            beams[first:i, 4] = surface
        first = i


@kernel
def squared_length(point: NDArray[np.float64], x: float, y: float) -> float:
    """Return the square of the distance of a point (2,) from x, y."""
    along_x, along_y = point[0] - x, point[1] - y
    return float(along_x * along_x + along_y * along_y)


@kernel
def hides(
    beams: NDArray[np.int64],
    origin: tuple[float, float],
    ends: NDArray[np.float64],
    pair: tuple[int, int],
) -> bool:
    """Return whether the first of a pair of beams hits something nearer than the other's end."""
    if beams[pair[0], 2] != HIT:
        return False
    x, y = origin
    return squared_length(ends[pair[0]], x, y) < squared_length(ends[pair[1]], x, y)


@kernel
def mark_beam(
    marks: NDArray[np.uint8], cols: int, start: tuple[int, int], end: tuple[int, int], share: int
) -> None:
    """Set the cells that a beam crosses in `marks`, flat, rows of `cols`; points on the raster.

    Of its last `share` parts in `SHARE` nothing is marked.
    """
    wide, tall = abs(end[0] - start[0]), abs(end[1] - start[1])
    col, row = start[0] // PARTS, start[1] // PARTS
    steps = abs(end[0] // PARTS - col) + abs(end[1] // PARTS - row)
    left = steps - ((steps * share) >> 16)
    step_x = 1 if end[0] > start[0] else -1
    step_y = cols if end[1] > start[1] else -cols
    to_x = (col + 1) * PARTS - start[0] if end[0] > start[0] else start[0] - col * PARTS
    to_y = (row + 1) * PARTS - start[1] if end[1] > start[1] else start[1] - row * PARTS
    # Negative while the next border crossed is one between cols, positive if between rows.
    ahead = to_x * tall - to_y * wide
    per_x, per_y = PARTS * tall, PARTS * wide
    at = row * cols + col
    marks[at] = 1
    while left > 0:
        if ahead < 0:
            at += step_x
            ahead += per_x
            left -= 1
        elif ahead > 0:
            at += step_y
            ahead -= per_y
            left -= 1
        else:
            at += step_x + step_y
            ahead += per_x - per_y
            left -= 2
        marks[at] = 1


@kernel
def learn_hit(
    layers: Layers, cell: tuple[int, int], surface: int, weights: Weights, moment: Moment
) -> None:
    """Add a hit on a surface to a cell; obstacles are proven that are wide or stood long enough."""
    row, col = cell
    evidence, since = layers.evidence, layers.since
    before = int(evidence[row, col])
    bits = (before & PASSED) | KNOWN
    if before < STEP:
        since[row, col] = moment.tick
    else:
        bits |= before & PROVEN
    level = min((before & -STEP) + weights.hit, weights.high)
    if level > 0 and not bits & PROVEN:
        lasting = weights.lasting if surface == ALONE else weights.glimpse
        if surface >= moment.sure_from or prove_beside(layers, cell, moment.tick - lasting):
            bits |= PROVEN
    evidence[row, col] = level | bits


@kernel
def prove_beside(layers: Layers, cell: tuple[int, int], latest: int) -> bool:
    """Mark the obstacles in a cell and its eight neighbours that stand since `latest` as proven.

    Returns:
        Whether there are any.
    """
    rows, cols = layers.evidence.shape
    found = False
    for row in range(max(cell[0] - 1, 0), min(cell[0] + 2, rows)):
        for col in range(max(cell[1] - 1, 0), min(cell[1] + 2, cols)):
            if layers.evidence[row, col] >= STEP and layers.since[row, col] <= latest:
                layers.evidence[row, col] |= PROVEN
                found = True
    return found


@kernel
def learn_misses(layers: Layers, window: tuple[int, int, int, int], weights: Weights) -> None:
    """Take a miss off every marked cell of a window (rows from, to, cols from, to); unmark it.

    Runs of `RUN` cells without a mark are left out; the layers have a multiple of that in a row.
    """
    low = np.int16(weights.low | PASSED | KNOWN)
    words = layers.marks.view(np.uint64)
    per_run = RUN // 8
    for row in range(window[0], window[1]):
        for run in range(window[2] // RUN, (window[3] - 1) // RUN + 1):
            any_mark = np.uint64(0)
            for word in range(run * per_run, (run + 1) * per_run):
                any_mark |= words[row, word]
            if any_mark == 0:
                continue
            evidence = layers.evidence[row, run * RUN : (run + 1) * RUN]
            marks = layers.marks[row, run * RUN : (run + 1) * RUN]
            for k in range(RUN):
                mark = np.int16(marks[k])
                passed = np.int16(evidence[k] | (mark * (PASSED | KNOWN)))
                evidence[k] = max(np.int16(passed - np.int16(mark * weights.miss)), low)
                marks[k] = 0


@kernel
def insert_beams(
    layers: Layers, beams: NDArray[np.int64], place: Place, weights: Weights, moment: Moment
) -> None:
    """Draw a scan: a cell learns from it once, and a hit counts more than any beam that passes.

    `beams` (n, 5) are as `read_beams` fills them; the layers hold all of the window of `place`.
    """
    corner, start, window = place
    marks = layers.marks.reshape(-1)
    cols = layers.marks.shape[1]
    left, below = corner[1] * PARTS, corner[0] * PARTS
    begin = start[0] - left, start[1] - below
    for i in range(len(beams)):
        if beams[i, 2] != SKIPPED:
            end = beams[i, 0] - left, beams[i, 1] - below
            mark_beam(marks, cols, begin, end, beams[i, 3])
    for i in range(len(beams)):
        row, col = beams[i, 1] // PARTS - corner[0], beams[i, 0] // PARTS - corner[1]
        if beams[i, 2] == HIT and layers.marks[row, col] != HIT_MARK:
            layers.marks[row, col] = HIT_MARK
            learn_hit(layers, (row, col), beams[i, 4], weights, moment)
    for i in range(len(beams)):
        if beams[i, 2] == HIT:
            row, col = beams[i, 1] // PARTS - corner[0], beams[i, 0] // PARTS - corner[1]
            layers.marks[row, col] = 0
    inside = (
        window[0] - corner[0],
        window[1] - corner[0],
        window[2] - corner[1],
        window[3] - corner[1],
    )
    learn_misses(layers, inside, weights)


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    size = RUN
    layers = Layers(
        np.zeros((size, size), np.int16),
        np.zeros((size, size), np.int32),
        np.zeros((size, size), np.uint8),
    )
    beams = np.zeros((1, 5), np.int64)
    ends, is_hit = np.ones((1, 2)), np.ones(1, bool)
    window = read_beams(beams, (0.5, 0.5), ends, is_hit, Reading(1.0, 9.0, 1.0, 9.0, 1.0, 1.0))
    moment = Moment(1, ALONE)
    weights = Weights(STEP, STEP, -STEP, STEP, 1, 1)
    place = Place((0, 0), (raster(0.5), raster(0.5)), window)
    insert_beams(layers, beams, place, weights, moment)
