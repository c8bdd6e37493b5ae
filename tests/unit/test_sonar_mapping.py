import math

import numpy as np
import pytest

from drawing import draw
from pilotage.core import se2
from pilotage.core.logs import (
    CommandRecord,
    HeadingRecord,
    OdometryRecord,
    Record,
    ScanRecord,
    SonarRecord,
    TruthRecord,
)
from pilotage.mapper.method import MappingMethod
from pilotage.mapper.sonar_mapping import SonarMapping
from pilotage.mapper.trajectory import Trajectory
from sonar_world import along, hear, ring_of

HALL = draw(
    """
    ##############################
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    ##############################
    """,
    resolution=0.1,
)
RING = ring_of(*np.radians([90.0, 44.0, 12.0, -12.0, -44.0, -90.0, -144.0, 144.0]))
WAY = along((0.6, 0.4), (2.4, 0.4), 60)


def odometry(stamp: float, pose: np.ndarray, angular: float | None = None) -> OdometryRecord:
    x, y, theta = pose.tolist()
    return OdometryRecord(stamp, (x, y, theta), None if angular is None else 0.0, angular)


def sonar(stamp: float, ranges: np.ndarray) -> SonarRecord:
    return SonarRecord(stamp, ranges.astype(np.float32), RING.mounts, RING.cone, RING.range_max)


def drive() -> list[Record]:
    """A way through the hall, heard ten times a second."""
    records: list[Record] = []
    for tick, pose in enumerate(WAY):
        records += [odometry(0.1 * tick, pose), sonar(0.1 * tick, hear(HALL, pose, RING))]
    return records


def mapped(records: list[Record]) -> SonarMapping:
    mapping = SonarMapping()
    for record in records:
        mapping.process(record)
    return mapping


def test_it_is_a_way_of_mapping() -> None:
    method: MappingMethod = SonarMapping()
    assert method.name == "sonar"


def test_a_drive_becomes_a_map_and_a_way() -> None:
    mapping = mapped(drive())
    world = mapping.map()
    assert world.is_wall.sum() > 20
    cell = tuple(world.geometry.cells_of([[1.5, 0.42]])[0])
    assert 0 <= world.cells[cell] < 20
    stamps, poses = mapping.trajectory()
    assert stamps == pytest.approx(0.1 * np.arange(60))
    assert poses == pytest.approx(WAY)


def test_before_the_first_measurement_nothing_is_known() -> None:
    mapping = SonarMapping()
    assert mapping.map().cells.tolist() == [[-1]]
    assert len(mapping.trajectory()[0]) == 0
    assert mapping.pose_graph().poses.shape == (0, 3)
    assert mapping.pose_at(np.array([1.0, 2.0, 0.5])) == pytest.approx([0.0, 0.0, 0.0])


def test_sonar_without_odometry_is_nowhere() -> None:
    assert SonarMapping().process(sonar(0.0, np.ones(8))) is None


def test_each_round_is_a_step_with_its_covariance() -> None:
    mapping, records = SonarMapping(), drive()
    steps = [step for record in records if (step := mapping.process(record)) is not None]
    assert len(steps) == 60
    assert steps[-1].map_from_base == pytest.approx(WAY[-1])
    assert steps[-1].stamp == pytest.approx(5.9)
    assert not any(step.redrawn for step in steps)
    assert np.linalg.eigvalsh(steps[-1].covariance).min() > 0.0
    assert steps[-1].covariance[0, 0] > steps[5].covariance[0, 0]


def test_other_measurements_do_not_matter() -> None:
    laser = ScanRecord(0.0, np.ones(3, np.float32), -1.0, 1.0, 8.0, None, (0.0, 0.0, 0.0))
    mapping = SonarMapping()
    assert mapping.process(laser) is None
    assert mapping.process(TruthRecord(0.0, (1.0, 1.0, 1.0))) is None
    assert len(mapping.trajectory()[0]) == 0


def test_nothing_is_heard_in_a_turn() -> None:
    mapping = SonarMapping()
    for tick in range(10):
        mapping.process(odometry(0.1 * tick, np.array([0.0, 0.0, 0.1 * tick])))
    assert mapping.process(sonar(0.9, np.ones(8))) is None
    mapping.process(odometry(1.0, np.array([0.0, 0.0, 0.9])))
    assert mapping.process(sonar(1.0, np.ones(8))) is not None


def test_odometry_that_says_its_rate_is_believed() -> None:
    mapping = SonarMapping()
    mapping.process(odometry(0.0, np.zeros(3), angular=0.0))
    mapping.process(odometry(0.1, np.zeros(3), angular=1.0))
    assert mapping.process(sonar(0.1, np.ones(8))) is None


def test_a_turn_between_two_stops_does_not_silence_the_second() -> None:
    mapping = SonarMapping()
    mapping.process(odometry(0.0, np.zeros(3)))
    mapping.process(odometry(10.0, np.array([0.0, 0.0, 1.5])))
    assert mapping.process(sonar(10.0, np.ones(8))) is not None


def test_the_map_begins_where_odometry_begins() -> None:
    mapping, start = SonarMapping(), np.array([5.0, -3.0, 1.0])
    mapping.process(odometry(0.0, start))
    assert mapping.trajectory()[1] == pytest.approx(start[None])


def test_orders_correct_what_odometry_counted() -> None:
    def way(records: list[Record]) -> float:
        mapping = mapped(records)
        for tick in range(101):
            mapping.process(odometry(0.1 * tick, np.array([0.0206 * tick, 0.0, 0.0])))
        return float(mapping.trajectory()[1][-1, 0])

    assert way([]) == pytest.approx(2.06)
    assert 2.0 <= way([CommandRecord(0.0, 0.2, 0.0)]) < 2.02


def test_a_compass_corrects_the_heading() -> None:
    mapping = SonarMapping()
    for tick in range(200):
        mapping.process(HeadingRecord(0.1 * tick, 0.3, 0.01))
        mapping.process(odometry(0.1 * tick, np.array([0.02 * tick, 0.0, 0.0008 * tick])))
    drift = mapping.trajectory()[1][-1, 2]
    assert abs(drift) < 0.5 * 0.0008 * 199


def test_the_pose_moves_on_with_odometry() -> None:
    mapping = mapped(drive())
    ahead = se2.compose(WAY[-1], [0.1, 0.02, 0.3])
    assert mapping.pose_at(ahead) == pytest.approx(ahead)


def test_keyframes_stand_for_the_way() -> None:
    graph = mapped(drive()).pose_graph()
    assert graph.edges.shape == (0, 2)
    assert graph.relative.shape == (0, 3)
    assert graph.information.shape == (0, 3, 3)
    assert len(graph.poses) == len(graph.stamps) == 7
    assert graph.poses[0] == pytest.approx(WAY[0])
    assert np.diff(graph.poses[:, 0]).min() >= 0.25


def test_turning_on_the_spot_makes_keyframes_too() -> None:
    mapping = SonarMapping()
    for tick in range(100):
        mapping.process(odometry(0.1 * tick, np.array([0.0, 0.0, math.radians(3.6 * tick)])))
    assert 20 <= len(mapping.pose_graph().poses) <= 26


def test_a_run_goes_on_after_a_crash() -> None:
    records = drive()
    whole, before, after = mapped(records), mapped(records[:61]), SonarMapping()
    after.resume(before.remember())
    for record in records[61:]:
        after.process(record)
    assert np.abs(whole.map().cells.astype(int) - after.map().cells).max() <= 1
    assert after.trajectory()[1] == pytest.approx(whole.trajectory()[1])
    assert after.pose_graph().poses == pytest.approx(whole.pose_graph().poses)
    assert after.pose_at(WAY[-1]) == pytest.approx(WAY[-1])


def test_a_run_that_heard_nothing_goes_on_too() -> None:
    after = SonarMapping()
    after.resume(SonarMapping().remember())
    assert after.map().cells.tolist() == [[-1]]


def test_memory_of_another_method_is_refused() -> None:
    with pytest.raises(ValueError, match="sonar"):
        SonarMapping().resume({"scans": np.zeros(3)})


def test_a_remembered_map_does_not_change_with_the_robot() -> None:
    mapping = mapped(drive()[:60])
    memory = mapping.remember()
    kept = {name: array.copy() for name, array in memory.items()}
    for record in drive()[60:]:
        mapping.process(record)
    assert all(np.array_equal(memory[name], kept[name]) for name in kept)


def test_another_ring_may_take_over() -> None:
    mapping = mapped(drive())
    mounts = np.array([[0.1, 0.0, 0.0]])
    ranges = np.array([1.0], np.float32)
    assert mapping.process(SonarRecord(6.0, ranges, mounts, 0.3, 3.0)) is not None


def test_a_cone_of_more_than_half_a_turn_hears_half_a_turn() -> None:
    mapping = SonarMapping()
    mapping.process(odometry(0.0, np.zeros(3)))
    ranges, mounts = np.array([1.0], np.float32), np.zeros((1, 3))
    assert mapping.process(SonarRecord(0.0, ranges, mounts, 3.2, 4.0)) is not None
    world = mapping.map()
    known = world.geometry.centres_of(np.argwhere(world.cells >= 0))
    assert known[:, 0].min() > -0.1


def test_a_trajectory_grows_beyond_its_first_size() -> None:
    trajectory = Trajectory()
    for number in range(3000):
        trajectory.add(float(number), [number, 0.0, 0.0])
    assert len(trajectory) == 3000
    assert trajectory.stamps == pytest.approx(np.arange(3000.0))
    assert trajectory.poses[:, 0] == pytest.approx(np.arange(3000.0))
    assert trajectory.pose(2999) == pytest.approx([2999.0, 0.0, 0.0])


def test_a_trajectory_that_does_not_fit_is_refused() -> None:
    with pytest.raises(ValueError, match="do not fit"):
        Trajectory().restore(np.zeros(3), np.zeros((2, 3)))
