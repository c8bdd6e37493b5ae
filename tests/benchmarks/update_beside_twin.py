"""Processor time of each pass over the belief, beside its plain twin on a part of it.

    .venv/bin/python tests/benchmarks/update_beside_twin.py

The belief of the office (0.10 m, 72 headings), even, so that nothing can be left out, and scans
of 60 beams. The plain twins of tests/naive do the same for PART of the headings and rows of an
even smaller hall and are scaled up to the admissible states. Last comes a robot that is tracked.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "tests"))

from naive import markov as naive  # noqa: E402 - the twins are no package
from pilotage.core.grid import OccupancyMap  # noqa: E402 - after the path
from pilotage.core.map_files import load_map  # noqa: E402 - after the path
from pilotage.core.raycast import cast_scan  # noqa: E402 - after the path
from pilotage.localizer import kernels  # noqa: E402 - after the path
from pilotage.localizer.kernels import (  # noqa: E402 - after the path
    LANES,
    MOST_COST,
    Prior,
    Scan,
    Sight,
)
from pilotage.localizer.likelihood_field import (  # noqa: E402 - after the path
    LikelihoodFieldParams,
    likelihood_field,
)
from pilotage.localizer.markov_grid import MarkovGrid, MotionSpread  # noqa: E402 - after the path
from pilotage.localizer.pose_grid import (  # noqa: E402 - after the path
    PoseGrid,
    PoseGridParams,
    pose_grid,
)

BEAMS, MARGIN, RUNS = 60, 170, 5
PART = (2, 4, 40)
"""Headings, rows and cols that the twins work on."""

Passes = dict[str, tuple[Callable[[], object], Callable[[], object]]]


def cpu_ms(work: Callable[[], object], runs: int) -> float:
    """Return the median processor time of some runs in ms, the first not counted."""
    work()
    spent = []
    for _ in range(runs):
        begun = time.process_time()
        work()
        spent.append((time.process_time() - begun) * 1e3)
    return float(np.median(spent))


class Case:
    """Random tables for a random belief over the states of a building."""

    def __init__(self, grid: PoseGrid) -> None:
        self.rng = np.random.default_rng(0)
        self.area = kernels.in_all_layers(grid.admissible, grid.headings)
        self.room = kernels.whole_area(grid.shape)
        self.belief = self.rng.random(grid.shape, np.float32)
        self.mask = grid.admissible.mask
        headings, rows, cols = grid.shape
        field = (4, rows + 2 * MARGIN, cols + 2 * MARGIN)
        self.costs = self.rng.integers(0, MOST_COST + 1, field).astype(np.uint8)
        self.beams = np.stack(
            [self.rng.integers(0, 4, (headings, BEAMS))]
            + [self.rng.integers(MARGIN - 100, MARGIN + 100, (headings, BEAMS)) for _ in "xy"],
            axis=-1,
        )
        self.likelihood = np.exp(-1e-3 * np.arange(BEAMS * MOST_COST + 1)).astype(np.float32)
        self.levels = self.rng.integers(0, 256, grid.shape).astype(np.uint8)
        self.directions = self.rng.integers(0, headings, (headings, BEAMS))
        self.looks = self.rng.random((headings, 4, 256)).astype(np.float32) * 0.5 + 0.5
        self.prior = Prior(1.0, 1e-9, np.ones(headings, np.float32))
        self.shifts = self.rng.integers(-1, 2, (headings, 2))

    def scan(self) -> Scan:
        """Return the scan as the kernels take it."""
        _, height, width = self.costs.shape
        starts = (self.beams[..., 0] * height + self.beams[..., 1]) * width + self.beams[..., 2]
        flat = np.append(self.costs.ravel(), np.zeros(LANES, np.uint8))
        return Scan(starts.astype(np.uint64), flat, width, self.likelihood)

    def passes(self) -> Passes:
        """Return each pass by name, and its twin on PART of the belief."""
        belief, area, room, prior = self.belief, self.area, self.room, self.prior
        headings, rows, cols = PART
        part = belief[:headings, :rows, :cols].astype(np.float64)
        mask, ones = np.ones((rows, cols), np.float32), np.ones(headings)
        scan, runs = self.scan(), kernels.sum_runs(belief, area)
        echoes = kernels.echoes_of(self.directions[:, :4].copy(), self.levels, self.looks)
        factors = np.linspace(1.0, 0.9, BEAMS + 1).astype(np.float32)
        allowed = self.rng.integers(0, 256, BEAMS).astype(np.uint8)
        sight = Sight(self.directions, self.levels, allowed, factors, np.float32(0.0))
        places = np.array([[row, 0, cols] for row in range(rows)])
        states = list(np.ndindex(*PART))
        ahead = self.directions
        return {
            "prior, scan of 60 beams, sums": (
                lambda: kernels.weigh_scan(belief, area, prior, scan),
                lambda: (
                    naive.add_floor(part, mask, 1.0, 1e-9, ones),
                    naive.weigh_scan(part, mask, self.beams, self.costs, self.likelihood),
                    naive.sum_runs(part, places),
                ),
            ),
            "prior, 4 ranges, sums": (
                lambda: kernels.weigh_ranges(belief, area, prior, echoes),
                lambda: (
                    naive.add_floor(part, mask, 1.0, 1e-9, ones),
                    naive.weigh_ranges(part, mask, ahead[:, :4], self.levels, self.looks),
                    naive.sum_runs(part, places),
                ),
            ),
            "visibility of 60 beams, every state": (
                lambda: kernels.weigh_visibility(belief, area, runs, sight),
                lambda: [naive.beams_through_walls(ahead, allowed, self.levels, s) for s in states],
            ),
            "sums": (
                lambda: kernels.sum_runs(belief, area),
                lambda: naive.sum_runs(part, places),
            ),
            "shift of all layers": (
                lambda: kernels.shift_layers(belief, room, self.shifts),
                lambda: [naive.shift_layer(layer, 1, 1) for layer in part],
            ),
            "spread over cells": (
                lambda: kernels.spread_layers(belief, room, 0.1),
                lambda: [naive.spread_layer(layer, 0.1) for layer in part],
            ),
            "spread over headings": (
                lambda: kernels.spread_headings(belief, room, 0.1, self.shifts),
                lambda: naive.spread_headings(part, 0.1, self.shifts),
            ),
        }


def tracked_ms(world: OccupancyMap, grid: PoseGrid) -> tuple[float, float, float]:
    """Return ms of a scan with its motion while tracking, the area's share, and the rest's."""
    field = likelihood_field(world, grid.geometry, grid.heading_step, LikelihoodFieldParams())
    belief = MarkovGrid(grid, MotionSpread())
    free = world.geometry.centres_of(np.argwhere(world.is_free))
    pose = np.array([*free[len(free) // 2], 0.5])
    bearings = np.linspace(-2.3, 2.3, BEAMS)
    belief.set_gaussian(pose, np.diag([0.02, 0.02, 0.01]))
    ranges = cast_scan(world, pose, bearings, 16.0)
    beams = np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
    ends = (ranges[:, None] * beams)[np.isfinite(ranges)]

    def scan() -> None:
        belief.predict([0.0, 0.0, 0.1])
        belief.predict([0.0, 0.0, -0.1])
        belief.add_floor(1e-6)
        belief.weigh_scan(ends, field, 0.15)
        belief.settle()

    for _ in range(6):
        scan()
    spent = cpu_ms(scan, 20)
    held = float(np.diff(belief.area.runs[:, 1:]).sum()) / belief.belief.size
    return spent, held, belief.rest_mass


def main() -> None:
    """Measure all of it and print it."""
    world = load_map(REPOSITORY / "deploy/worlds/office_map.yaml")
    grid = pose_grid(world, PoseGridParams())
    case = Case(grid)
    share = float(np.prod(PART)) / grid.admissible_states
    print(f"{grid.admissible_states} admissible states of {np.prod(grid.shape)}")
    for name, (fast, plain) in case.passes().items():
        kernel_ms, plain_ms = cpu_ms(fast, RUNS), cpu_ms(plain, 1) / share
        print(
            f"{name:36} {kernel_ms:7.1f} ms; plain {plain_ms:9.0f} ms, {plain_ms / kernel_ms:.0f}x"
        )
    spent, held, rest = tracked_ms(world, grid)
    print(
        f"{'tracking, a scan and two turns':36} {spent:7.1f} ms; {held:.1%} of the states worked on"
    )
    print(f"rest bounded by {rest:.1e} of the belief")


if __name__ == "__main__":
    main()
