"""The localizer on a fake fabric: a robot's messages in, poses and beliefs out."""

import logging
import math
from pathlib import Path

import numpy as np
import pytest

from localizer_bench import STANDING, WORLD, Bench, pose2
from localizer_world import ELSEWHERE, ROUND, flat
from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.measurement import Measurement
from pilotage.localizer.storage import MEMORY_FILE
from pilotage.mapper.messages import grid_message
from pilotage_schemas.commands import Done, Nothing, SetAlgorithm, SetPose
from pilotage_schemas.geometry import Pose2


def states_of(bench: Bench) -> int:
    """How many states the grid has."""
    method = bench.method
    assert isinstance(method, MarkovLocalizer)
    return method.grid.grid.admissible_states


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_without_a_map_nothing_is_said_and_commands_are_refused(bench: Bench) -> None:
    bench.describe()
    bench.clock.advance(1.0)
    bench.say_odometry()
    bench.put("scan", bench.scan())
    assert bench.poses == []
    for query, request in (
        ("set_pose", SetPose(pose=pose2(bench.pose))),
        ("relocalize", Nothing()),
        ("set_algorithm", SetAlgorithm(algorithm="m1")),
    ):
        with pytest.raises(RefusedError, match="no map"):
            bench.ask(query, request)


def test_a_map_gives_an_even_belief_at_once(bench: Bench) -> None:
    bench.put_map()
    (belief,) = bench.beliefs
    states = states_of(bench)
    assert belief.entropy == pytest.approx(math.log2(states), abs=2e-3)
    assert belief.map_id == grid_message(WORLD, "flat", 0).map_id


def test_a_driven_robot_is_localized_where_it_is(bench: Bench) -> None:
    bench.begin()
    states = [bench.go(step).state for step in [STANDING, *ROUND]]
    assert states[0] == "unknown"
    assert states[-8:] == ["localized"] * 8
    assert bench.is_right()
    assert bench.poses[-1].frame_id == "map"
    assert bench.poses[-1].confidence > 0.8


def test_poses_carry_the_stamp_of_the_odometry_that_moved_them(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    before = bench.poses[-1].pose
    bench.clock.advance(0.1)
    bench.odom = se2.compose(bench.odom, [0.05, 0.0, 0.02])
    bench.say_odometry()
    now = bench.poses[-1]
    assert now.stamp_ns == bench.clock.now_ns()
    moved = se2.compose([before.x, before.y, before.theta], [0.05, 0.0, 0.02])
    assert [now.pose.x, now.pose.y, now.pose.theta] == pytest.approx(moved)


def test_poses_come_at_ten_hertz_however_fast_the_odometry_is(bench: Bench) -> None:
    bench.begin()
    for _ in range(100):
        bench.clock.advance(0.02)
        bench.say_odometry()
    assert 17 <= len(bench.poses) <= 21


def test_after_long_work_only_the_newest_pose_is_told(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.begin()
    bench.drive_round()
    method = bench.method
    update = method.update

    def slow(stamp_ns: int, odom_from_base: np.ndarray, measurement: Measurement) -> Estimate:
        """Meanwhile odometry goes on."""
        for _ in range(20):
            bench.clock.advance(0.02)
            bench.robot.publisher("odometry").publish(bench.odometry())
        return update(stamp_ns, odom_from_base, measurement)

    bench.clock.advance(1.0)
    bench.say_odometry()
    before_ns, before = bench.clock.now_ns(), len(bench.poses)
    monkeypatch.setattr(method, "update", slow)
    bench.put("scan", bench.scan())
    assert bench.poses[before - 1].stamp_ns == before_ns, "told before the work begins"
    assert [pose.stamp_ns for pose in bench.poses[before:]] == [bench.clock.now_ns()]


def test_a_kidnapped_robot_is_found_again_and_never_called_localized_elsewhere(
    bench: Bench,
) -> None:
    bench.begin()
    bench.drive_round()
    bench.pose = np.array(ELSEWHERE)
    states = []
    for _ in range(12):
        states.append(bench.go((0.1, 0.0, 0.1)).state)
        assert states[-1] != "localized" or bench.is_right()
    assert states[0] != "localized"
    assert states[-1] == "localized"


def test_a_set_pose_is_where_it_begins(bench: Bench) -> None:
    bench.begin()
    reply = bench.ask("set_pose", SetPose(pose=pose2(bench.pose)))
    assert isinstance(reply, Done)
    assert bench.latest().state == "unknown"
    assert bench.is_right(within=0.15)
    assert len(bench.beliefs[-1].modes) > 0
    assert bench.beliefs[-1].entropy < bench.beliefs[0].entropy - 3.0
    assert [bench.go(STANDING).state for _ in range(5)][-1] == "localized"


def test_a_set_pose_off_the_map_is_refused_and_changes_nothing(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    with pytest.raises(RefusedError, match="free space"):
        bench.ask("set_pose", SetPose(pose=Pose2(x=90.0, y=0.0, theta=0.0)))
    assert bench.latest().state == "localized"
    assert bench.is_right()


def test_a_covariance_that_is_none_is_refused(bench: Bench) -> None:
    bench.begin()
    bad = SetPose(pose=pose2(bench.pose), covariance=np.diag([-1.0, 1.0, 1.0]))
    with pytest.raises(RefusedError, match="covariance"):
        bench.ask("set_pose", bad)


def test_relocalize_forgets_everything_and_shows_it_at_once(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    assert isinstance(bench.ask("relocalize", Nothing()), Done)
    states = states_of(bench)
    assert bench.beliefs[-1].entropy == pytest.approx(math.log2(states), abs=2e-3)
    assert bench.latest().state == "unknown"
    circle = [bench.go((0.15, 0.0, 0.3)).state for _ in range(12)]
    assert circle[-1] == "localized"


def test_under_m1_a_kidnapped_robot_stays_lost_until_m2_is_chosen(bench: Bench) -> None:
    bench.begin()
    bench.ask("set_pose", SetPose(pose=pose2(bench.pose)))
    bench.ask("set_algorithm", SetAlgorithm(algorithm="m1"))
    for step in ROUND[:6]:
        bench.go(step)
    assert bench.poses[-1].state == "localized"
    bench.pose = np.array(ELSEWHERE)
    for _ in range(8):
        bench.go((0.1, 0.0, 0.1))
        assert not bench.is_right(within=0.5)
    bench.ask("set_algorithm", SetAlgorithm(algorithm="m2", recovery_weight=1e-3))
    for _ in range(12):
        bench.go((0.15, 0.0, -0.4))  # away from the wall
    assert bench.poses[-1].state == "localized"
    assert bench.is_right()


def test_a_scan_of_an_unknown_frame_is_ignored_and_said(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    bench.put_map()
    bench.describe(frame="front_laser")
    entropy = bench.beliefs[-1].entropy
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            bench.go(STANDING)
    assert [record.message for record in caplog.records] == [
        "scan: the robot's description has no mount 'laser'"
    ]
    assert bench.method.belief.entropy() == pytest.approx(entropy)


def test_a_scan_before_the_description_waits_for_it_silently(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    bench.put_map()
    bench.go(STANDING)
    assert caplog.records == []
    assert bench.poses[-1].state == "unknown"


def test_a_scan_ahead_of_its_odometry_waits_for_it(bench: Bench) -> None:
    bench.begin()
    bench.say_odometry()
    bench.clock.advance(1.0)
    bench.put("scan", bench.scan())
    entropy = bench.method.belief.entropy()
    bench.say_odometry()
    assert bench.method.belief.entropy() < entropy - 1.0


@pytest.mark.parametrize("anew", [(0.0, 0.0, 0.0), (40.0, 5.0, 1.0)], ids=["zero", "far"])
def test_odometry_that_is_counted_anew_is_noticed(
    bench: Bench, caplog: pytest.LogCaptureFixture, anew: tuple[float, float, float]
) -> None:
    """Within the time that a driver takes to come back, too short a way tells nothing."""
    bench.begin()
    bench.drive_round()
    bench.clock.advance(3.0)
    bench.robot = Node("robot", "demo", bench.fabric, bench.clock)
    bench.odom = np.array(anew)
    with caplog.at_level(logging.WARNING):
        states = [bench.go(STANDING).state for _ in range(4)]
    assert any("counting anew" in record.message for record in caplog.records)
    assert states == ["localized"] * 4
    assert bench.is_right()


def test_odometry_that_jumps_moves_nothing(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    bench.odom = bench.odom + np.array([9.0, 0.0, 0.0])
    assert bench.go(STANDING, seconds=0.1).state == "localized"
    assert bench.is_right()


def test_the_compass_helps_and_is_forgotten_with_the_odometry_it_was_heard_by(
    bench: Bench,
) -> None:
    bench.begin()
    bench.say_odometry()
    bench.put("heading", bench.heading())
    assert bench.service._compass.at(bench.clock.now_ns(), float(bench.odom[2])) is not None
    bench.clock.advance(0.2)
    bench.odom = np.array([60.0, 60.0, -1.0])
    bench.say_odometry()
    assert bench.service._compass.at(bench.clock.now_ns(), -1.0) is None


def test_a_crashed_localizer_is_back_after_one_scan(tmp_path: Path) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.drive_round()
    bench.go(STANDING, seconds=1.5)
    bench.crash_localizer()
    assert bench.method.estimate.state == "unknown"
    bench.describe()
    assert bench.go((0.15, 0.0, 0.1)).state == "localized"
    assert bench.is_right()


def test_the_memory_of_another_map_is_not_used(tmp_path: Path) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.drive_round()
    bench.put_map(flat((5.0, 5.0, 0.3)))
    states = states_of(bench)
    assert bench.beliefs[-1].entropy == pytest.approx(math.log2(states), abs=2e-3)


def test_a_damaged_memory_is_as_none(tmp_path: Path) -> None:
    (tmp_path / MEMORY_FILE).write_bytes(b"\x00" * 500)
    bench = Bench(folder=tmp_path)
    bench.begin()
    assert bench.beliefs[-1].entropy > 10.0


def test_a_full_disk_does_not_stop_the_localizer(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    bench = Bench(folder=tmp_path / "gone")
    bench.begin()
    with caplog.at_level(logging.WARNING):
        bench.drive_round()
    assert bench.is_right()
    assert any(record.message.startswith("memory: not kept") for record in caplog.records)


def test_another_map_is_begun_anew_and_the_same_one_goes_on(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    bench.put_map()
    assert bench.latest().state == "localized"
    bench.put_map(flat((1.0, 0.0, 0.0)))
    assert bench.latest().state == "unknown"


def test_a_map_that_cannot_be_used_leaves_the_old_one_in_use(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    bench.begin()
    bench.drive_round()
    map_id = bench.beliefs[-1].map_id
    full = OccupancyMap(GridGeometry(4, 4, 0.1), np.full((4, 4), 100, np.int8))
    with caplog.at_level(logging.WARNING):
        bench.put_map(full)
    assert any("no free cell" in record.message for record in caplog.records)
    assert bench.go(STANDING).state == "localized"
    assert bench.beliefs[-1].map_id == map_id


def test_sonar_alone_finds_the_robot_where_it_is_told_to_use_it() -> None:
    bench = Bench(settings=LocalizerSettings(headings=36, sensors=("sonar", "compass")))
    bench.put_map()
    for step in [STANDING, *ROUND]:
        bench.clock.advance(1.0)
        bench.pose, bench.odom = se2.compose(bench.pose, step), se2.compose(bench.odom, step)
        bench.say_odometry()
        bench.put("heading", bench.heading())
        bench.put("sonar", bench.sonar())
    bench.latest()
    assert bench.is_right(within=0.3)


def test_a_sensor_that_is_not_asked_for_is_not_heard() -> None:
    bench = Bench(settings=LocalizerSettings(headings=36, sensors=("sonar",)))
    bench.begin()
    entropy = bench.beliefs[-1].entropy
    bench.go(STANDING)
    assert bench.method.belief.entropy() == entropy


def test_beliefs_come_no_oftener_than_their_period(bench: Bench) -> None:
    bench.begin()
    bench.say_odometry()
    count = len(bench.beliefs)
    for step in ROUND[:6]:
        bench.go(step, seconds=0.1)
    assert len(bench.beliefs) - count <= 4


def test_settings_become_the_parameters_of_the_mathematics() -> None:
    settings = LocalizerSettings(
        resolution=0.05, headings=180, algorithm="m1", recovery_weight=0.5, tempering=0.3
    )
    params = settings.params()
    assert (params.grid.resolution, params.grid.headings) == (0.05, 180)
    assert (params.algorithm, params.recovery_weight, params.tempering) == ("m1", 0.5, 0.3)


def weighed(bench: Bench) -> int:
    """The stamp of the last measurement that was weighed."""
    return bench.service._weighed_ns


def dropped(bench: Bench) -> int:
    return bench.node.vitals.report().dropped


def test_a_scan_older_than_what_was_weighed_is_dropped_and_counted(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    bench.begin()
    bench.drive_round()
    bench.clock.advance(0.3)
    bench.say_odometry()
    late = bench.scan()
    bench.go((0.3, 0.0, 0.0))
    entropy, stamp_ns = bench.method.belief.entropy(), weighed(bench)
    assert late.stamp_ns < stamp_ns
    with caplog.at_level(logging.WARNING):
        bench.put("scan", late)
    assert dropped(bench) == 1
    assert [record.message for record in caplog.records] == [
        "scan: dropped: measured 1.000 s before what was weighed already"
    ]
    assert (bench.method.belief.entropy(), weighed(bench)) == (entropy, stamp_ns)
    assert bench.go((0.3, 0.0, 0.0)).state == "localized"


def test_a_slower_second_sensor_is_used_whenever_it_is_ahead() -> None:
    bench = Bench(settings=LocalizerSettings(headings=36, sensors=("laser", "sonar")))
    bench.begin()
    bench.drive_round()
    bench.clock.advance(0.1)
    bench.say_odometry()
    before = bench.sonar()
    bench.go((0.3, 0.0, 0.0))
    bench.put("sonar", before)
    assert dropped(bench) == 1
    bench.clock.advance(2.0)
    bench.say_odometry()
    bench.put("sonar", bench.sonar())
    assert weighed(bench) == bench.clock.now_ns()
    assert dropped(bench) == 1


def test_after_a_clock_was_set_back_measurements_are_weighed_again(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    bench.clock.advance(-2.0)
    for _ in range(3):
        assert bench.go(STANDING).state == "localized"
    assert dropped(bench) == 0
    assert bench.is_right()


def test_a_robot_that_drives_on_with_a_dead_laser_is_localized_no_longer(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    states, uncertain = [bench.poses[-1].state], [bench.poses[-1].covariance[2, 2]]
    for _ in range(60):
        step = np.array([0.2, 0.0, 0.4])
        bench.pose, bench.odom = se2.compose(bench.pose, step), se2.compose(bench.odom, step)
        bench.clock.advance(1.0)
        bench.say_odometry()
        states.append(bench.poses[-1].state)
        uncertain.append(bench.poses[-1].covariance[2, 2])
    assert (states[0], states[-1]) == ("localized", "unknown")
    assert bench.poses[-1].confidence < 0.7
    assert uncertain[-1] > uncertain[10] > uncertain[0]
    assert bench.is_right()
