"""How far a trajectory is from the measured relations of Freiburg's building 079.

    pilotage map ../shared/datasets/slam/fr079.clf.gz --out /tmp/fr079
    .venv/bin/python tests/benchmarks/slam_relations.py /tmp/fr079/trajectory.tum [RELATIONS]

Printed are mean, standard deviation and quantiles of what is left of each relation (Kuemmerle et
al. 2009), over all of them, over those of neighbouring poses and over those that close loops.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "tests"))

from slam_metrics import (  # noqa: E402 - tests/ is no package of the installation
    RelationErrors,
    Relations,
    read_relations,
    read_tum,
    relation_errors,
)

RELATIONS = REPOSITORY.parent / "shared" / "datasets" / "slam" / "fr079.relations"
NEIGHBOURS = 10.0
"""Poses at most so far apart in time [s] are neighbours on the way, others close a loop."""


def main(arguments: list[str]) -> int:
    """Print the table; 2 if the arguments are wrong."""
    if not 1 <= len(arguments) <= 2:
        sys.stderr.write("slam_relations.py: takes TRAJECTORY.tum [RELATIONS]\n")
        return 2
    trajectory = read_tum(Path(arguments[0]))
    relations = read_relations(Path(arguments[1]) if len(arguments) == 2 else RELATIONS)
    is_near = np.abs(relations.second - relations.first) <= NEIGHBOURS
    print(f"{'':12}{'n':>6}{'missing':>8}{'mean':>9}{'sd':>9}{'p50':>9}{'p90':>9}{'max':>9}")
    for name, chosen in (("all", is_near | True), ("neighbours", is_near), ("loops", ~is_near)):
        show(name, relation_errors(trajectory, some(relations, chosen)))
    return 0


def some(relations: Relations, chosen: NDArray[np.bool_]) -> Relations:
    """The chosen ones."""
    return Relations(relations.first[chosen], relations.second[chosen], relations.poses[chosen])


def show(name: str, errors: RelationErrors) -> None:
    """Two lines of the table: m and degrees."""
    for unit, values in (("m", errors.translation), ("deg", np.rad2deg(errors.rotation))):
        head = f"{name:12}{len(values):6}{errors.missing:8}"
        if len(values):
            row = [values.mean(), values.std(), *np.percentile(values, [50, 90, 100])]
            head += "".join(f"{value:9.4f}" for value in row)
        print(head, unit)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
