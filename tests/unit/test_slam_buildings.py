"""Laser SLAM round a simulated building, undisturbed and with all that may happen to a robot."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.logs import HeadingRecord, OdometryRecord, Record, ScanRecord
from pilotage.mapper.laser_slam import LaserSlam
from pilotage.mapper.pose_edges import Edge, mismatch
from slam_world import (
    BEAMS,
    CELL,
    ROUND,
    Drive,
    building,
    drive,
    errors,
    feed,
    mapped,
    odometry_errors,
    scan_record,
    way_along,
)

WAY = way_along([*ROUND, *ROUND[:3]])
"""Once round the building, and on for a while where it began."""

SILENCE = 3.0
"""s."""

Change = Callable[[ScanRecord], ScanRecord | None]


@cache
def usual() -> Drive:
    return drive(building(), WAY)


@cache
def slam() -> LaserSlam:
    return mapped(usual().records)


def changed(records: list[Record], begin: int, change: Change) -> list[Record]:
    """Change the scans of SILENCE from scan `begin` on."""
    start = [record.stamp for record in records if isinstance(record, ScanRecord)][begin]
    new = [
        change(r) if isinstance(r, ScanRecord) and start <= r.stamp < start + SILENCE else r
        for r in records
    ]
    return [record for record in new if record is not None]


def silent(_scan: ScanRecord) -> None:
    """There is no scan."""


def blind(scan: ScanRecord) -> ScanRecord:
    """No beam comes back."""
    return replace(scan, ranges=np.full(BEAMS, np.inf, np.float32))


def nearly_blind(scan: ScanRecord) -> ScanRecord:
    """Two beams come back."""
    seen = np.isin(np.arange(BEAMS), [3, 70])
    return replace(scan, ranges=np.where(seen, scan.ranges, np.float32(np.inf)))


def dazzled(scan: ScanRecord) -> ScanRecord:
    """Ranges that are none."""
    ranges = scan.ranges.copy()
    ranges[::3] = np.nan
    ranges[1::7] = -1.0
    ranges[2::7] = 0.0
    return replace(scan, ranges=ranges)


def steps_of(slam: LaserSlam) -> np.ndarray:
    _, poses = slam.trajectory()
    lengths: np.ndarray = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    return lengths


@pytest.mark.parametrize("seed", [0, 1])
def test_the_way_is_far_better_than_odometry(seed: int) -> None:
    driven = usual() if seed == 0 else drive(building(), WAY, seed)
    found = errors(slam() if seed == 0 else mapped(driven.records), driven)
    assert found.mean() < 0.02
    assert found.max() < 0.06
    assert found.mean() < 0.05 * odometry_errors(driven).mean()


def test_bad_odometry_does_no_harm() -> None:
    driven = drive(building(), WAY, 1, noise=3.0)
    assert odometry_errors(driven).max() > 2.0
    assert errors(mapped(driven.records), driven).max() < 0.08


@pytest.mark.parametrize("seed", [1, 2])
def test_eleven_beams_do_as_well_as_they_can(seed: int) -> None:
    driven = drive(building(), WAY, seed, beams=11)
    found = errors(mapped(driven.records), driven)
    assert found.mean() < 0.2
    assert found.mean() < 0.4 * odometry_errors(driven).mean()


def test_walls_of_the_map_are_those_of_the_building() -> None:
    world, found = building(), slam().map()
    walls = found.geometry.centres_of(np.argwhere(found.is_wall))
    cells = world.geometry.cells_of(se2.transform_points(WAY[0], walls))
    off = distance_to_walls(world.is_wall, CELL)[tuple(cells.T)]
    assert len(walls) > 1500
    assert np.percentile(off, 99) <= 1.01 * CELL
    assert off.max() < 0.25


def test_free_floor_of_the_map_is_free_in_the_building() -> None:
    world, found = building(), slam().map()
    floor = found.geometry.centres_of(np.argwhere(found.is_free))
    cells = world.geometry.cells_of(se2.transform_points(WAY[0], floor))
    assert len(floor) * found.geometry.resolution**2 > 50.0
    assert world.is_free[tuple(cells.T)].mean() > 0.99


def test_what_nobody_saw_stays_unknown() -> None:
    """The inside of the block."""
    found = slam().map()
    inside = se2.transform_points(se2.inverse(WAY[0]), np.array([[5.4, 4.5], [4.0, 4.0]]))
    assert (found.cells[tuple(found.geometry.cells_of(inside).T)] == -1).all()


def test_the_loop_is_closed_and_its_edges_agree() -> None:
    graph = slam().pose_graph()
    assert graph.is_closure.sum() >= 5
    assert len(graph.poses) < len(WAY) // 2
    for k in np.nonzero(graph.is_closure)[0]:
        first, second = graph.edges[k].tolist()
        covariance = np.linalg.inv(graph.information[k])
        edge = Edge(first, second, graph.relative[k], covariance, is_closure=True)
        assert mismatch(edge, graph.poses[first], graph.poses[second]) < 6.0


def test_the_map_begins_where_the_robot_stood() -> None:
    assert slam().pose_graph().poses[0] == pytest.approx(np.zeros(3), abs=1e-9)


def test_steps_tell_pose_and_certainty() -> None:
    method, redrawn = LaserSlam(), 0
    for record in usual().records[:400]:
        step = method.process(record)
        if not isinstance(record, ScanRecord):
            assert step is None
        else:
            assert step is not None
            assert step.stamp == record.stamp
            assert step.map_from_base == pytest.approx(method.pose_at(np.array(record.odom_pose)))
            assert np.linalg.eigvalsh(step.covariance)[0] > 0.0
            assert np.sqrt(np.diag(step.covariance)).max() < 0.2
            redrawn += step.redrawn
    assert redrawn == 0  # no loop was closed yet


def test_a_closed_loop_redraws_the_map() -> None:
    method = LaserSlam()
    steps = [step for record in usual().records if (step := method.process(record)) is not None]
    assert any(step.redrawn for step in steps)
    assert not any(step.redrawn for step in steps[:150])


def test_between_scans_odometry_moves_the_pose() -> None:
    method = mapped(usual().records[:40])
    scans = [record for record in usual().records[:40] if isinstance(record, ScanRecord)]
    odom = np.array(scans[-1].odom_pose)
    here = method.pose_at(odom)
    ahead = method.pose_at(se2.compose(odom, (0.2, 0.1, 0.3)))
    assert se2.between(here, ahead) == pytest.approx([0.2, 0.1, 0.3])


@pytest.mark.parametrize("at", [60, 250])
def test_a_robot_that_is_lifted_and_turned_unnoticed_is_followed(at: int) -> None:
    """By 80 degrees; then it turns back by itself."""
    turn = np.deg2rad(80.0)
    lifted = se2.compose(WAY[at], (0.0, 0.0, turn))
    back = [se2.compose(lifted, (0.0, 0.0, -turn * k / 5.0)) for k in range(1, 5)]
    truth = np.concatenate([WAY[: at + 1], [lifted], back, WAY[at:]])
    driven = drive(building(), truth, 2, carried={at + 1: (0.0, 0.0, turn)})
    assert odometry_errors(driven).max() > 4.0
    assert errors(mapped(driven.records), driven).max() < 0.08


@pytest.mark.parametrize("change", [silent, blind, nearly_blind, dazzled])
def test_three_seconds_without_good_scans_do_no_harm(change: Change) -> None:
    driven = drive(building(), WAY, 3)
    method = mapped(changed(driven.records, 250, change))
    assert errors(method, driven).mean() < 0.05
    assert errors(method, driven).max() < 0.25
    assert steps_of(method).max() < 0.25


def test_a_robot_that_sees_nothing_for_long_goes_by_odometry() -> None:
    """Ten metres in the dark, among them places where it has been."""
    method = mapped(usual().records)
    keyframes = len(method.pose_graph().poses)
    last = usual().scans[-1]
    odom, dark = np.array(last.odom_pose), np.full(BEAMS, np.inf)
    for k in range(100):
        odom = se2.compose(odom, (0.1, 0.0, 0.05))
        method.process(scan_record(last.stamp + 1.0 + k, dark, odom))
    assert len(method.pose_graph().poses) == keyframes
    assert method.pose_at(odom) == pytest.approx(
        se2.compose(slam().pose_at(np.array(last.odom_pose)), moved_by(last, odom)), abs=0.02
    )


def moved_by(last: ScanRecord, odom: np.ndarray) -> np.ndarray:
    return se2.between(np.array(last.odom_pose), odom)


def test_who_stands_still_adds_nothing() -> None:
    first = usual().scans[0]
    method = LaserSlam()
    for k in range(100):
        method.process(replace(first, stamp=first.stamp + 0.2 * k))
    assert len(method.pose_graph().poses) == 1
    assert np.abs(method.pose_at(np.array(first.odom_pose))).max() < 1e-3


def test_driving_to_and_fro_adds_little() -> None:
    """What was driven over often enough costs no more keyframes."""
    there = way_along([(1.5, 7.2), (6.0, 7.2)])
    turns = np.vstack([there, there[::-1]])
    counts = []
    for rounds in (3, 6):
        method = mapped(drive(building(), np.vstack([turns] * rounds), 5).records)
        counts.append(len(method.pose_graph().poses))
    assert counts[1] < 1.3 * counts[0]


@pytest.mark.parametrize("at", [100, 290])
def test_mapping_goes_on_from_memory_as_if_it_had_not_stopped(at: int) -> None:
    records = usual().records
    cut = records.index(usual().scans[at]) + 1
    method, again = LaserSlam(), LaserSlam()
    for record in records[:cut]:
        method.process(record)
    again.resume(method.remember())
    following = records[cut : cut + 200]
    there, here = (np.array(list(feed(each, following))) for each in (method, again))
    assert len(here) == len(there) >= 50
    assert np.abs(se2.between(there, here)[:50]).max() < 0.005
    assert len(again.pose_graph().edges) == len(method.pose_graph().edges)
    assert np.abs(again.trajectory()[1] - method.trajectory()[1]).max() < 0.01
    assert again.map().geometry == method.map().geometry
    assert (again.map().cells != method.map().cells).mean() < 0.002


def test_memory_is_of_arrays_that_can_be_saved() -> None:
    memory = slam().remember()
    assert all(isinstance(array, np.ndarray) for array in memory.values())
    assert all(array.dtype != object for array in memory.values())
    assert sum(array.nbytes for array in memory.values()) < 2e6


def test_memory_of_nothing_is_a_new_beginning() -> None:
    again = LaserSlam()
    again.resume(LaserSlam().remember())
    for record in usual().records[:40]:
        again.process(record)
    assert len(again.pose_graph().poses) >= 1


@pytest.mark.parametrize("lost", ["odom", "points", "edge_ends", "counts", "track.scans"])
def test_a_memory_that_lacks_something_is_refused(lost: str) -> None:
    memory = slam().remember()
    del memory[lost]
    with pytest.raises(ValueError, match="no memory of laser mapping"):
        LaserSlam().resume(memory)


def test_an_empty_log_is_an_empty_map() -> None:
    method = LaserSlam()
    method.settle()
    stamps, poses = method.trajectory()
    assert (stamps.shape, poses.shape) == ((0,), (0, 3))
    assert method.map().cells.size == 0
    assert method.pose_graph().poses.shape == (0, 3)
    assert not method.pose_at(np.array([1.0, 2.0, 0.5])).any()


def test_odometry_alone_draws_nothing_but_a_way() -> None:
    only = [r for r in usual().records if isinstance(r, OdometryRecord)]
    method = mapped(only)
    assert method.map().cells.size == 0
    _, poses = method.trajectory()
    assert poses == pytest.approx(np.array([record.pose for record in only]))


def test_scans_without_odometry_and_other_records_are_of_no_use() -> None:
    method = LaserSlam()
    assert method.process(replace(usual().scans[0], odom_pose=None)) is None
    assert method.process(HeadingRecord(1.0, 0.3, 0.1)) is None
    assert method.map().cells.size == 0


def test_a_first_scan_of_nothing_waits_for_the_next() -> None:
    first, second = usual().scans[:2]
    method = LaserSlam()
    assert method.process(blind(first)) is None
    step = method.process(second)
    assert step is not None
    assert not step.map_from_base.any()


def test_a_scan_without_beams_is_odometrys_word() -> None:
    method = LaserSlam()
    method.process(usual().scans[0])
    odom = se2.compose(np.array(usual().scans[0].odom_pose), (0.1, 0.0, 0.0))
    step = method.process(scan_record(200.0, np.empty(0), odom))
    assert step is not None
    assert step.map_from_base == pytest.approx([0.1, 0.0, 0.0], abs=1e-6)
