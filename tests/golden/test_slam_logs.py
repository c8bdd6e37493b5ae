"""Real buildings mapped, and how far the way is from what was measured of it."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pilotage.core.logs import read_log
from pilotage.mapper.log_run import LogUse, map_records, records_of
from pilotage.mapper.map_products import FinishedMap, finish
from pilotage.mapper.methods import MappingSetup, make_method
from slam_metrics import (
    Relations,
    distances_to_reference,
    read_reference,
    read_relations,
    relation_errors,
)

pytestmark = [pytest.mark.data, pytest.mark.timeout(300)]

BEGINNING = 150.0
"""s of Freiburg's building 079."""


@cache
def mapped(folder: Path, name: str, seconds: float = np.inf) -> FinishedMap:
    """The map of the beginning of a log."""
    records = records_of(read_log(folder / "slam" / f"{name}.clf.gz"), LogUse())
    begin = records[0].stamp
    method = make_method("laser", MappingSetup())
    for _ in map_records([r for r in records if r.stamp < begin + seconds], method):
        pass
    return finish(method)


def covered(whole: Relations, stamps: np.ndarray) -> Relations:
    """The relations of a stretch of time."""
    both = np.stack([whole.first, whole.second])
    inside = ((both >= stamps[0]) & (both <= stamps[-1])).all(axis=0)
    return Relations(whole.first[inside], whole.second[inside], whole.poses[inside])


def test_freiburg_keeps_to_its_relations(data_dir: Path) -> None:
    """GMapping leaves 0.069 m of all of them, Cartographer 0.045 m."""
    finished = mapped(data_dir, "fr079", BEGINNING)
    whole = read_relations(data_dir / "slam" / "fr079.relations")
    relations = covered(whole, finished.stamps)
    left = relation_errors((finished.stamps, finished.poses), relations)
    assert len(left.translation) > 100
    assert left.missing == 0
    assert left.translation.mean() <= 0.06
    assert np.rad2deg(left.rotation.mean()) <= 1.0


@pytest.mark.parametrize(("name", "median"), [("seattle", 0.1), ("aces", 0.2)])
def test_buildings_lie_as_their_references_do(data_dir: Path, name: str, median: float) -> None:
    """Other programs' poses, not the truth; odometry is metres off."""
    finished = mapped(data_dir, name)
    reference = read_reference(data_dir / "slam" / f"{name}.reference.txt")
    distances = distances_to_reference((finished.stamps, finished.poses), reference)
    assert len(distances) > 200
    assert np.median(distances) <= median
    assert distances.max() <= 5.0 * median


@pytest.mark.parametrize(("name", "floor"), [("seattle", 200.0), ("aces", 700.0)])
def test_buildings_are_drawn_whole(data_dir: Path, name: str, floor: float) -> None:
    """Free m2, of which a map that fell apart has far more or less."""
    finished = mapped(data_dir, name)
    assert floor < finished.free_area < 2.0 * floor
    assert finished.graph.is_closure.sum() > 20
