"""How far a trajectory is from reference poses, such as those of aces, seattle and acapulco.

    pilotage map ../shared/datasets/slam/aces.clf.gz --out /tmp/aces
    .venv/bin/python tests/benchmarks/slam_reference.py /tmp/aces/trajectory.tum aces

The second argument is a building of the recorded data or a file of lines `stamp x y theta`. The
trajectory is laid over the reference rigidly, by least squares; printed are the distances of the
poses, and what is left of the relations of poses 1, 10 and 50 apart, which need no laying over.
The references are another program's, not the truth.
"""

import sys
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "tests"))

from slam_metrics import (  # noqa: E402 - tests/ is no package of the installation
    Array,
    distances_to_reference,
    read_reference,
    read_tum,
    relation_errors,
    relations_of,
)

BUILDINGS = REPOSITORY.parent / "shared" / "datasets" / "slam"
APART = (1, 10, 50)


def main(arguments: list[str]) -> int:
    """Print the table; 2 if the arguments are wrong."""
    if len(arguments) != 2:
        sys.stderr.write("slam_reference.py: takes TRAJECTORY.tum and a building or a file\n")
        return 2
    trajectory, reference = read_tum(Path(arguments[0])), read_reference(file_of(arguments[1]))
    print(f"{'':22}{'n':>6}{'mean':>9}{'sd':>9}{'p50':>9}{'p90':>9}{'max':>9}")
    show("laid over, m", distances_to_reference(trajectory, reference))
    for apart in APART:
        errors = relation_errors(trajectory, relations_of(reference, apart))
        show(f"{apart} apart, m", errors.translation)
        show(f"{apart} apart, deg", np.rad2deg(errors.rotation))
    return 0


def file_of(name: str) -> Path:
    """The file that is meant."""
    return Path(name) if Path(name).is_file() else BUILDINGS / f"{name}.reference.txt"


def show(name: str, values: Array) -> None:
    """A line of the table."""
    row = [values.mean(), values.std(), *np.percentile(values, [50, 90, 100])]
    print(f"{name:22}{len(values):6}" + "".join(f"{value:9.4f}" for value in row))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
