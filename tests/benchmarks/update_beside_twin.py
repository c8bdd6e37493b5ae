"""Processor time of one measurement of the office, beside its plain twin on a part of it.

    .venv/bin/python tests/benchmarks/update_beside_twin.py

Prior, scan of 60 beams and sums over the whole belief of the office (0.10 m, 72 headings); the
plain twin of tests/naive does the same for PART of the headings and rows and is scaled up.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "tests"))

from naive import markov as naive  # noqa: E402 - the twins are no package
from pilotage.core.map_files import load_map  # noqa: E402 - after the path
from pilotage.localizer import kernels  # noqa: E402 - after the path
from pilotage.localizer.kernels import Admissible, Prior  # noqa: E402 - after the path
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid  # noqa: E402 - after the path

BEAMS, MARGIN, RUNS = 60, 162, 5
PART_HEADINGS, PART_ROWS = 1, 4


def cpu_ms(work: Callable[[], object], runs: int) -> float:
    """Return the median processor time of some runs in ms."""
    spent = []
    for _ in range(runs):
        begun = time.process_time()
        work()
        spent.append((time.process_time() - begun) * 1e3)
    return float(np.median(spent))


def main() -> None:
    """Measure both and print them."""
    grid = pose_grid(load_map(REPOSITORY / "deploy/worlds/office_map.yaml"), PoseGridParams())
    rng = np.random.default_rng(0)
    headings, rows, cols = grid.shape
    belief = rng.random(grid.shape, np.float32)
    costs = rng.integers(0, 256, (4, rows + 2 * MARGIN, cols + 2 * MARGIN)).astype(np.uint8)
    beams = np.stack(
        [rng.integers(0, 4, (headings, BEAMS))]
        + [rng.integers(MARGIN - 100, MARGIN + 100, (headings, BEAMS)) for _ in "xy"],
        axis=-1,
    )
    likelihood = np.exp(-1e-3 * np.arange(BEAMS * 255 + 1)).astype(np.float32)
    prior = Prior(1.0, 1e-9, np.ones(headings, np.float32))

    def measure() -> None:
        kernels.add_floor(belief, grid.admissible, prior)
        kernels.weigh_scan(belief, grid.admissible, beams, costs, likelihood)
        kernels.sum_runs(belief, grid.admissible)

    def measure_plainly() -> None:
        part = belief[:PART_HEADINGS, :PART_ROWS].astype(np.float64)
        mask = grid.admissible.mask[:PART_ROWS]
        runs = grid.admissible.runs[grid.admissible.runs[:, 0] < PART_ROWS]
        part = naive.add_floor(part, mask, 1.0, 1e-9, np.ones(headings))
        part = naive.weigh_scan(part, mask, beams, costs, likelihood)
        naive.sum_runs(part, Admissible(mask, runs).runs)

    measure()
    fast = cpu_ms(measure, RUNS)
    states = headings * int(grid.admissible.mask.sum())
    share = PART_HEADINGS * float(grid.admissible.mask[:PART_ROWS].sum()) / states
    plain = cpu_ms(measure_plainly, 1) / share
    print(f"{states} admissible states of {belief.size}, {BEAMS} beams")
    print(f"kernels {fast:.0f} ms; plain twin {plain:.0f} ms (on {share:.2e} of it, scaled)")
    print(f"ratio {plain / fast:.0f}")


if __name__ == "__main__":
    main()
