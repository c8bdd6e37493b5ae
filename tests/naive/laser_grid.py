"""The laser's grid cell by cell in plain Python: a dictionary, whole numbers, no tricks.

Twin of `mapper.laser_grid_kernels` and of what `LaserGrid` makes of them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.laser_grid_clock import FAR
from pilotage.mapper.laser_grid_params import GLIMPSE, TICKS, LaserGridParams, evidence_of

PARTS = 1024

Cell = tuple[int, int]
Point = tuple[int, int]
"""x, y on the raster of `PARTS` to a cell."""

NARROW, HIDDEN, WIDE = "narrow", "hidden", "wide"


def raster(cells: float) -> int:
    """The odd number whose pair of even neighbours holds the length."""
    return 2 * math.floor(cells * PARTS / 2) + 1


def crossed_cells(start: Point, end: Point) -> list[Cell]:
    """Cells (row, col) whose inside a segment meets, in order."""
    first = start[1] // PARTS, start[0] // PARTS
    last = end[1] // PARTS, end[0] // PARTS
    met = [
        (row, col)
        for row in range(min(first[0], last[0]), max(first[0], last[0]) + 1)
        for col in range(min(first[1], last[1]), max(first[1], last[1]) + 1)
        if (row, col) == first or _is_cut(start, end, (row, col))
    ]
    return sorted(met, key=lambda cell: abs(cell[0] - first[0]) + abs(cell[1] - first[1]))


def _is_cut(start: Point, end: Point, cell: Cell) -> bool:
    """Whether corners of a cell lie on both sides of the line through two points."""
    corners = [((cell[1] + x) * PARTS, (cell[0] + y) * PARTS) for x in (0, 1) for y in (0, 1)]
    sides = [
        (end[0] - start[0]) * (y - start[1]) - (end[1] - start[1]) * (x - start[0])
        for x, y in corners
    ]
    return min(sides) < 0 < max(sides)


def passed_cells(start: Point, end: Point, share: int) -> list[Cell]:
    """Those crossed cells that count as passed: none of the last `share` parts of the steps."""
    cells = crossed_cells(start, end)
    steps = [abs(row - cells[0][0]) + abs(col - cells[0][1]) for row, col in cells]
    left = steps[-1] - (steps[-1] * share >> 16)
    return [cells[0]] + [
        cell for cell, before in zip(cells[1:], steps[:-1], strict=True) if before < left
    ]


@dataclass
class PlainCell:
    """What is known of a cell."""

    level: int = 0
    is_passed: bool = False
    is_proven: bool = False
    since: int = 0


@dataclass
class PlainLaserGrid:
    """Twin of `LaserGrid` without growth: cells by row and col of the endless raster."""

    params: LaserGridParams = field(default_factory=LaserGridParams)
    cells: dict[Cell, PlainCell] = field(default_factory=dict)
    scans: list[tuple[float, float, float | None]] = field(default_factory=list)
    now: float = 0.0

    def insert(
        self,
        origin: Sequence[float],
        ends: NDArray[np.float64],
        is_hit: NDArray[np.bool_],
        stamp: float | None = None,
    ) -> None:
        """Draw a scan."""
        self.scans.append((origin[0], origin[1], stamp))
        self.now += min(self._gap(len(self.scans) - 1), 1.0)
        is_key = min(self._gap(len(self.scans) - 1), self._gap(len(self.scans) - 2)) >= FAR
        start = self._on_raster(np.asarray(origin, float))
        hit: dict[Cell, str] = {}
        passed: set[Cell] = set()
        kinds = surfaces(
            np.asarray(origin, float), ends, self._counting(origin, ends, is_hit), self.params
        )
        for i, end in enumerate(ends):
            length = math.dist(end, origin)
            if not (math.isfinite(length) and length > 0.0):
                continue
            point = self._on_raster(end)
            if length > self.params.range_max:
                cut = origin + self.params.range_max / length * (end - origin)
                point = self._on_raster(cut)
            share = 0
            if is_hit[i] and length <= self.params.range_max:
                hit.setdefault((point[1] // PARTS, point[0] // PARTS), kinds[i])
                share = int(65536 * min(1.0, self._graze(origin, ends, is_hit, i) / length))
            passed.update(passed_cells(start, point, share))
        for cell, kind in hit.items():
            self._learn_hit(cell, kind, {WIDE, HIDDEN} if is_key else {WIDE})
        for cell in passed - set(hit):
            self._learn_miss(cell)

    def _counting(
        self, origin: Sequence[float], ends: NDArray[np.float64], is_hit: NDArray[np.bool_]
    ) -> list[bool]:
        lengths = np.hypot(*(ends - np.asarray(origin)).T)
        return [
            bool(hit) and 0.0 < length <= self.params.range_max
            for hit, length in zip(is_hit, lengths, strict=True)
        ]

    def _on_raster(self, point: NDArray[np.float64]) -> Point:
        x, y = point / self.params.resolution
        return raster(float(x)), raster(float(y))

    def _gap(self, index: int) -> float:
        """Time or way since the scan before, in shares of a proof."""
        if index < 1:
            return math.inf
        (x, y, stamp), (x_before, y_before, before) = self.scans[index], self.scans[index - 1]
        if stamp is None or before is None:
            return math.inf
        way = math.hypot(x - x_before, y - y_before) / self.params.lasting_travel
        return max(0.0, way, (stamp - before) / self.params.lasting_time)

    def _graze(
        self,
        origin: Sequence[float],
        ends: NDArray[np.float64],
        is_hit: NDArray[np.bool_],
        i: int,
    ) -> float:
        """How far [m] the beam may run along its wall before it ends."""
        if not 0 < i < len(ends) - 1 or not (is_hit[i - 1] and is_hit[i + 1]):
            return 0.0
        back, on = ends[i] - ends[i - 1], ends[i + 1] - ends[i]
        cosine = back @ on / (math.hypot(*back) * math.hypot(*on) or math.inf)
        if not cosine > 0.94:
            return 0.0
        wall, beam = back + on, ends[i] - origin
        sine = abs(wall[0] * beam[1] - wall[1] * beam[0]) / (math.hypot(*wall) * math.hypot(*beam))
        depth = self.params.wall_depth_cells * self.params.resolution
        return float(min(self.params.graze_max, depth * (1.0 / max(sine, 1e-6) - 1.0)))

    def _learn_hit(self, cell: Cell, kind: str, sure_of: set[str]) -> None:
        tick = round(TICKS * self.now)
        here = self.cells.setdefault(cell, PlainCell())
        if here.level <= 0:
            here.since, here.is_proven = tick, False
        top = evidence_of(self.params.limit_log_odds)
        here.level = min(here.level + evidence_of(self.params.hit_log_odds), top)
        if here.level <= 0 or here.is_proven:
            return
        latest = tick - round(TICKS * (1.0 if kind == NARROW else GLIMPSE))
        if kind in sure_of:
            here.is_proven = True
            return
        for row in range(cell[0] - 1, cell[0] + 2):
            for col in range(cell[1] - 1, cell[1] + 2):
                near = self.cells.get((row, col))
                if near and near.level > 0 and near.since <= latest:
                    near.is_proven = here.is_proven = True

    def _learn_miss(self, cell: Cell) -> None:
        here = self.cells.setdefault(cell, PlainCell())
        here.is_passed = True
        least = -evidence_of(self.params.limit_log_odds)
        here.level = max(here.level - evidence_of(self.params.miss_log_odds), least)

    def value(self, cell: Cell) -> int:
        """Return 100, 0 or -1 as the map has it."""
        here = self.cells.get(cell, PlainCell())
        if here.level >= evidence_of(self.params.occupied_log_odds) and here.is_proven:
            return 100
        return 0 if here.is_passed else -1


def surfaces(
    origin: NDArray[np.float64],
    ends: NDArray[np.float64],
    counts: list[bool],
    params: LaserGridParams,
) -> list[str]:
    """What each beam that counts as a hit lies on; of others it says nothing of use."""
    groups: list[list[int]] = []
    for i in range(len(ends)):
        near = i > 0 and math.dist(ends[i], ends[i - 1]) <= params.surface_gap
        if near and counts[i] and counts[i - 1]:
            groups[-1].append(i)
        else:
            groups.append([i])
    kinds = []
    for group in groups:
        beside = [(group[0] - 1, group[0]), (group[-1] + 1, group[-1])]
        is_hidden = any(
            0 <= one < len(ends)
            and counts[one]
            and math.dist(ends[one], origin) < math.dist(ends[other], origin)
            for one, other in beside
        )
        width = math.dist(ends[group[0]], ends[group[-1]])
        kind = WIDE if width > params.person_width else HIDDEN if is_hidden else NARROW
        kinds += [kind] * len(group)
    return kinds
