"""A piece of the way through Freiburg's building 079, whole and disturbed: it stays right.

Of all pieces of 100 s this one comes back most often to where it was: raw odometry is off from its
relations by 0.30 m and 7.7 degrees in the mean.
"""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from pilotage.core.logs import Log, OdometryRecord, Record, ScanRecord, read_log
from pilotage.mapper.log_run import LogUse, map_records, records_of
from pilotage.mapper.map_products import FinishedMap, finish
from pilotage.mapper.methods import MappingSetup, make_method
from slam_metrics import RelationErrors, Relations, read_relations, relation_errors

pytestmark = [pytest.mark.data, pytest.mark.timeout(180)]

BEGIN, SECONDS = 680.0, 100.0
FEWEST_SCANS, FEWEST_RELATIONS = 420, 140

Disturb = Callable[[list[Record]], Iterable[Record]]


@cache
def piece(folder: Path) -> Log:
    """Its scans say no odometry of their own: they have that of their stamp."""
    log = read_log(folder / "slam" / "fr079.clf.gz")
    begin = log.records[0].stamp + BEGIN
    kept = tuple(
        replace(record, odom_pose=None) if isinstance(record, ScanRecord) else record
        for record in log.records
        if begin <= record.stamp < begin + SECONDS
    )
    return Log(log.format, kept, 0)


def undisturbed(records: list[Record]) -> Iterable[Record]:
    return records


def off(records: list[Record]) -> Iterable[Record]:
    """The laser says nothing for three seconds, twice."""
    begin = records[0].stamp
    silent = [(begin + 20.0, begin + 23.0), (begin + 60.0, begin + 63.0)]
    return [
        r
        for r in records
        if not (isinstance(r, ScanRecord) and any(a <= r.stamp < b for a, b in silent))
    ]


def spiked(records: list[Record]) -> Iterable[Record]:
    """Of every fourth scan a third of the beams are anything."""
    rng = np.random.default_rng(7)
    return [
        replace(r, ranges=spikes(r.ranges, rng)) if isinstance(r, ScanRecord) and k % 8 < 2 else r
        for k, r in enumerate(records)
    ]


def spikes(ranges: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    wrong = rng.uniform(0.1, 20.0, len(ranges)).astype(np.float32)
    return np.where(rng.random(len(ranges)) < 1.0 / 3.0, wrong, ranges)


def delayed(records: list[Record]) -> Iterable[Record]:
    """Scans are stamped a tenth of a second late."""
    return [replace(r, stamp=r.stamp + 0.1) if isinstance(r, ScanRecord) else r for r in records]


def repeated(records: list[Record]) -> Iterable[Record]:
    """Everything comes twice."""
    return chain.from_iterable((record, record) for record in records)


@cache
def mapped(folder: Path, disturb: Disturb, beams: int | None = None) -> tuple[FinishedMap, int]:
    log = piece(folder)
    records = tuple(sorted(disturb(list(log.records)), key=lambda record: record.stamp))
    method = make_method("laser", MappingSetup())
    used = records_of(Log(log.format, records, 0), LogUse("laser", beams))
    scans = sum(1 for _ in map_records(used, method))
    return finish(method), scans


def errors(folder: Path, finished: FinishedMap) -> RelationErrors:
    whole = read_relations(folder / "slam" / "fr079.relations")
    first, last = finished.stamps[[0, -1]]
    both = np.stack([whole.first, whole.second])
    covered = ((both >= first) & (both <= last)).all(axis=0)
    relations = Relations(whole.first[covered], whole.second[covered], whole.poses[covered])
    return relation_errors((finished.stamps, finished.poses), relations)


@pytest.mark.parametrize(
    ("disturb", "translation", "rotation"),
    [
        (undisturbed, 0.04, 0.6),
        (off, 0.045, 0.7),
        (spiked, 0.045, 0.7),
        (delayed, 0.06, 2.8),  # in a tenth of a second this robot turns by up to 5 degrees
        (repeated, 0.04, 0.6),
    ],
)
def test_way_keeps_to_its_relations(
    data_dir: Path, disturb: Disturb, translation: float, rotation: float
) -> None:
    """Mean errors in m and degrees."""
    finished, scans = mapped(data_dir, disturb)
    left = errors(data_dir, finished)
    assert scans >= (FEWEST_SCANS if disturb is not off else FEWEST_SCANS - 40)
    assert len(left.translation) >= FEWEST_RELATIONS
    assert left.missing == 0
    assert left.translation.mean() < translation
    assert np.rad2deg(left.rotation.mean()) < rotation


def test_few_beams_keep_to_the_relations_too(data_dir: Path) -> None:
    finished, _ = mapped(data_dir, undisturbed, 11)
    left = errors(data_dir, finished)
    assert len(left.translation) >= FEWEST_RELATIONS
    assert left.translation.mean() < 0.09
    assert np.rad2deg(left.rotation.mean()) < 4.0


def test_way_has_a_pose_for_all_odometry(data_dir: Path) -> None:
    finished, _ = mapped(data_dir, undisturbed)
    stamps = [r.stamp for r in piece(data_dir).records if isinstance(r, OdometryRecord)]
    assert finished.stamps.tolist() == pytest.approx(stamps)


def test_walls_are_thin_and_the_floor_is_free(data_dir: Path) -> None:
    """The corridor and some offices; a map that drifts shows walls twice."""
    finished, _ = mapped(data_dir, undisturbed)
    walls = float(finished.world.is_wall.sum()) * finished.world.geometry.resolution
    assert 110.0 < finished.free_area < 170.0
    assert 80.0 < walls < 150.0
