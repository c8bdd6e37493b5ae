"""Processor time of a round of a sonar ring, beside its plain twin.

    .venv/bin/python tests/benchmarks/sonar_update.py

Eight sonars, readings of 0.3 to 2 m, cells of 0.05 m, 1500 arcs in memory. Placing 100 echoes is
what Li 2008, table 4-1, gives as 1.426 s (ATM) and 1.736 s (improved ATM) on its computer. The
twins ask every cell of a grid of 5 m x 5 m, and cross every arc of PART with every other; the
second is scaled up to the memory's pairs.
"""

import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "tests"))

from naive import sonar as naive  # noqa: E402 - the twins are no package
from pilotage.mapper.arc_median import place_echoes  # noqa: E402 - after the path
from pilotage.mapper.sonar_grid import SonarGrid, SonarGridParams, beam_shape  # noqa: E402 - same
from pilotage.mapper.sonar_kernels import add_readings  # noqa: E402 - after the path
from pilotage.mapper.sonar_models import KERNEL_OF, SonarModel  # noqa: E402 - after the path
from pilotage.mapper.sonar_ring import SonarRing  # noqa: E402 - after the path

MODELS: tuple[SonarModel, ...] = (
    "centre_line",
    "gaussian",
    "uniform_arc",
    "bayes",
    "atm",
    "improved_atm",
)
ARCS, PART, ROUNDS = 1500, 60, 400
DIRECTIONS = np.radians([90.0, 44.0, 12.0, -12.0, -44.0, -90.0, -144.0, 144.0])
RULES = {"atm": False, "improved_atm": True}


def cpu_ms(work: Callable[[], object], runs: int) -> float:
    """Processor time of the work in ms, after one run that is not counted."""
    work()
    start = time.process_time()
    for _ in range(runs):
        work()
    return 1e3 * (time.process_time() - start) / runs


def ring() -> SonarRing:
    """The ring of MORCS-2."""
    return SonarRing(np.column_stack([np.zeros((8, 2)), DIRECTIONS]), math.radians(25.0), 4.0)


def drive() -> tuple[np.ndarray, np.ndarray]:
    """Poses and ranges of a robot that goes round and round."""
    rng = np.random.default_rng(1)
    angle = np.linspace(0.0, 20.0, ROUNDS)
    poses = np.column_stack([np.cos(angle), np.sin(angle), angle + math.pi / 2.0])
    return poses, rng.uniform(0.3, 2.0, (ROUNDS, 8))


def rounds(model: SonarModel) -> float:
    """Processor time of a round in ms, once the memory is full."""
    grid = SonarGrid(SonarGridParams(), ring(), model)
    poses, ranges = drive()
    for pose, heard in zip(poses[: ROUNDS // 2], ranges, strict=False):
        grid.insert(pose, heard)
    start = time.process_time()
    for pose, heard in zip(poses[ROUNDS // 2 :], ranges[ROUNDS // 2 :], strict=True):
        grid.insert(pose, heard)
    return 1e3 * (time.process_time() - start) / (ROUNDS // 2)


def drawing(model: SonarModel) -> tuple[float, float]:
    """Processor time of drawing a round in ms, by kernel and by twin."""
    poses, ranges = drive()
    readings = ring().readings(poses[0], ranges[0])
    echoes = np.column_stack([readings, np.zeros(8)])
    cells, plain, corner = np.zeros((100, 100), np.float32), np.zeros((100, 100)), (-1.5, -2.5)
    beam, kind = beam_shape(SonarGridParams(), ring()), KERNEL_OF[model]
    fast = cpu_ms(lambda: add_readings(cells, corner, 0.05, echoes, kind, beam), 200)
    slow = cpu_ms(lambda: naive.add_readings(plain, corner, 0.05, echoes, (kind, beam)), 1)
    return fast, slow


def placing(model: str) -> tuple[float, float]:
    """Processor time of placing 100 echoes among ARCS in ms, by kernel and by twin."""
    poses, ranges = drive()
    arcs = np.concatenate(
        [ring().readings(p, r) for p, r in zip(poses[: ARCS // 8], ranges, strict=False)]
    )
    rule = RULES[model], math.radians(30.0), np.ones(12), 0.03
    cone = math.radians(25.0)
    fast = cpu_ms(lambda: place_echoes(arcs, 700, 800, cone, rule), 20)
    part = arcs[:PART]
    slow = cpu_ms(lambda: naive.place_on_arc(part, 0, cone, rule), 1)
    pairs = PART * (PART - 1) / 2.0
    return fast, 100.0 * slow * len(arcs) / pairs


def main() -> None:
    """Print a table."""
    print(f"{'':28}{'kernel':>12}{'twin':>14}{'times':>9}")
    for model in MODELS:
        fast, slow = drawing(model)
        print(f"draw a round, {model:14}{fast:9.3f} ms{slow:11.1f} ms{slow / fast:9.0f}")
    for name in RULES:
        fast, slow = placing(name)
        print(f"place 100 echoes, {name:12}{fast:7.3f} ms{slow:11.1f} ms{slow / fast:9.0f}")
    for model in MODELS:
        print(f"a whole round, {model:14}{rounds(model):8.3f} ms")


if __name__ == "__main__":
    main()
