"""SLAM with eleven beams round a simulated building, and what is kept of it."""

from functools import cache

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import OCCUPIED_FROM
from pilotage.core.logs import OdometryRecord, ScanRecord
from pilotage.mapper.laser_mapping import FEW_BEAMS, LaserMapping
from pilotage.mapper.laser_slam import LaserSlam
from pilotage.mapper.sparse_slam import SparseSlam, params_for
from slam_world import ROUND, Drive, apart, building, drive, odometry_errors, way_along

BEAMS = 11
WAY = way_along([*ROUND, *ROUND[:3]])


@cache
def usual() -> Drive:
    return drive(building(), WAY, beams=BEAMS)


def fed(count: int | None = None) -> SparseSlam:
    slam = SparseSlam(np.random.default_rng(0))
    for record in usual().records[:count]:
        slam.process(record)
    return slam


@cache
def whole() -> SparseSlam:
    slam = fed()
    slam.settle()
    return slam


def errors(slam: SparseSlam | LaserMapping) -> np.ndarray:
    """How far (n,) in m the poses at the scans are from the truth."""
    stamps, poses = slam.trajectory()
    at = np.searchsorted(stamps, [scan.stamp for scan in usual().scans])
    return apart(poses[np.minimum(at, len(poses) - 1)], WAY)


def test_the_way_round_the_building_is_right() -> None:
    found = errors(whole())
    assert found.mean() < 0.25
    assert found.mean() < 0.4 * odometry_errors(usual()).mean()


def test_the_loop_is_closed() -> None:
    assert whole().pose_graph().is_closure.any()


def test_walls_are_drawn_where_there_are_some() -> None:
    """Seen from the first pose; the loop being closed, no wall is drawn twice."""
    world = building()
    gaps = distance_to_walls(world.is_wall, world.geometry.resolution)
    drawn = whole().map()
    places = se2.transform_points(
        WAY[0], drawn.geometry.centres_of(np.argwhere(drawn.cells >= OCCUPIED_FROM))
    )
    cells = world.geometry.cells_of(places)
    inside = world.geometry.contains(cells)
    off = gaps[cells[inside, 0], cells[inside, 1]]
    assert len(off) > 100
    assert inside.mean() > 0.9
    assert np.percentile(off, 80) < 0.3


def test_the_newest_scans_are_in_the_way_and_on_the_map_at_once() -> None:
    slam = fed(60)
    stamps, poses = slam.trajectory()
    assert stamps[-1] == usual().records[59].stamp
    assert len(slam.map().cells)
    assert np.isfinite(poses).all()


def test_a_pose_is_told_before_the_first_keyframe() -> None:
    slam = SparseSlam(np.random.default_rng(0))
    steps = [slam.process(record) for record in usual().records[:12]]
    told = [step for step in steps if step is not None]
    assert told
    assert told[0].map_from_base == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert not slam.pose_graph().stamps.size


def test_an_empty_map_is_one_too() -> None:
    slam = SparseSlam(np.random.default_rng(0))
    assert not slam.map().cells.size
    assert not slam.pose_at(np.ones(3)).any()
    slam.settle()


def test_odometry_moves_the_pose_on() -> None:
    slam = fed(200)
    odom = np.array(usual().scans[-1].odom_pose)
    assert np.isfinite(slam.pose_at(odom)).all()


def test_what_is_remembered_goes_on() -> None:
    half = len(usual().records) // 2
    first = fed(half)
    second = SparseSlam(np.random.default_rng(1))
    second.resume(first.remember())
    assert np.array_equal(second.pose_graph().poses, first.pose_graph().poses)
    for record in usual().records[half:]:
        second.process(record)
    second.settle()
    assert errors(second).mean() < 0.4


def test_a_memory_of_the_beginning_goes_on() -> None:
    second = SparseSlam(np.random.default_rng(1))
    second.resume(SparseSlam(np.random.default_rng(0)).remember())
    for record in usual().records[:30]:
        second.process(record)
    assert second.map().cells.size


def test_a_memory_of_something_else_is_refused() -> None:
    with pytest.raises(ValueError, match="no memory of laser mapping"):
        SparseSlam(np.random.default_rng(0)).resume({"numbers": np.zeros(3)})


def beams_of(method: LaserMapping, beams: int) -> LaserMapping:
    for record in drive(building(), WAY[:30], beams=beams).records:
        method.process(record)
    return method


@pytest.mark.parametrize(("beams", "sparse"), [(BEAMS, True), (FEW_BEAMS, False)])
def test_the_first_scan_says_how_to_map(beams: int, sparse: bool) -> None:  # noqa: FBT001 - a case
    memory = beams_of(LaserMapping(np.random.default_rng(0)), beams).remember()
    assert ("window.counts" in memory) == sparse
    again = LaserMapping(np.random.default_rng(0))
    again.resume(memory)
    assert np.array_equal(again.pose_graph().poses, again.pose_graph().poses)
    assert set(again.remember()) == set(memory)


@pytest.mark.parametrize(("beams", "particles"), [(0, 550), (4, 550), (11, 200), (50, 200)])
def test_the_fewer_beams_the_more_ways_are_held_possible(beams: int, particles: int) -> None:
    assert params_for(beams).front_end.particles.particles == particles


def test_odometry_before_the_first_scan_is_part_of_the_way() -> None:
    method = LaserMapping(np.random.default_rng(0))
    method.process(OdometryRecord(99.0, (0.0, 0.0, 0.0)))
    assert method.trajectory()[0].tolist() == [99.0]
    scans = 0
    for record in usual().records[:80]:
        scans += isinstance(record, ScanRecord)
        method.process(record)
    method.settle()
    assert method.trajectory()[0][0] == 99.0
    assert method.map().cells.size
    assert scans > 10


def test_full_scans_go_to_the_full_method() -> None:
    full = LaserSlam()
    records = drive(building(), WAY[:30]).records
    for record in records:
        full.process(record)
    method = LaserMapping(np.random.default_rng(0))
    for record in records:
        method.process(record)
    assert np.array_equal(method.trajectory()[1], full.trajectory()[1])
    odom = np.array([0.1, 0.0, 0.0])
    assert np.array_equal(method.pose_at(odom), full.pose_at(odom))
