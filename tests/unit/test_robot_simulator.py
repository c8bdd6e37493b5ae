"""The simulator as a driver, and behind the robot service."""

from collections import Counter
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from pilotage.bus.fabric import RefusedError
from pilotage.core.landmark_map import NO_LANDMARKS, LandmarkMap, landmarks_of
from pilotage.robot.config import RobotSettings
from pilotage.robot.driver import DriverError, Gazeable, Kidnappable, Measurement, Playback
from pilotage.robot.simulator.camera import CameraParams
from pilotage.robot.simulator.simulator import Simulator
from pilotage_schemas import commands as c
from pilotage_schemas.codec import decode, encode
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.sensors import Bumper, GroundTruth, LandmarkSightings, LaserScan, Odometry
from pilotage_schemas.topics import TOPICS
from robot_world import EXACT, Bench, simulation_in

POSTS = landmarks_of(
    [
        {"class": "post", "x": 4.0, "y": 1.75, "id": "ahead"},
        {"class": "line", "x": 1.5, "y": 2.75},
    ]
)
"""One 2.5 m ahead of where the robot starts, one a metre to its left."""

START_NS = 1_000_000_000_000
STEP_NS = 20_000_000


class Run:
    """A simulator that is looked at every 20 ms."""

    def __init__(self, seed: int = 1, landmarks: LandmarkMap = NO_LANDMARKS) -> None:
        self.driver = Simulator(simulation_in(seed=seed, landmarks=landmarks))
        self.now_ns = START_NS
        self.driver.sense(self.now_ns)

    def sense(self, seconds: float) -> list[Measurement]:
        measured: list[Measurement] = []
        for _ in range(round(seconds / 0.02)):
            self.now_ns += STEP_NS
            measured.extend(self.driver.sense(self.now_ns))
        return measured

    def go(self, vx: float, omega: float = 0.0) -> None:
        self.driver.drive(Twist2(vx=vx, vy=0.0, omega=omega))


def test_sensors_come_at_their_rates() -> None:
    counts = Counter(measurement.topic for measurement in Run().sense(5.0))
    assert counts == {
        "odometry": 100,
        "ground_truth": 100,
        "scan": 50,
        "sonar": 50,
        "heading": 50,
        "bumper": 1,
    }


def test_rates_are_those_of_the_registry() -> None:
    for topic, count in Counter(m.topic for m in Run().sense(5.0)).items():
        rate = TOPICS[topic].rate_hz
        assert rate is None or count == 5.0 * rate


def test_a_camera_takes_a_picture_five_times_a_second_whether_it_shows_anything_or_not() -> None:
    counts = Counter(measurement.topic for measurement in Run(landmarks=POSTS).sense(5.0))
    assert counts["landmarks"] == 25
    assert TOPICS["landmarks"].rate_hz == 5


def pictures(measured: list[Measurement]) -> list[LandmarkSightings]:
    return [m.message for m in measured if isinstance(m.message, LandmarkSightings)]


def test_sightings_say_class_identity_place_and_how_exactly() -> None:
    shown = [one for p in pictures(Run(landmarks=POSTS).sense(20.0)) for one in p.sightings]
    assert len(shown) > 80
    assert {(one.kind, one.identity) for one in shown} == {("post", "ahead")}
    assert np.mean([one.range for one in shown]) == pytest.approx(2.45, abs=0.15)
    assert np.mean([one.bearing for one in shown]) == pytest.approx(0.0, abs=0.1)
    assert all(one.range_sigma == pytest.approx(0.1 * one.range) for one in shown)
    assert np.rad2deg(shown[0].bearing_sigma) == pytest.approx(10.0)


def test_a_camera_that_looks_aside_tells_bearings_that_its_constant_mount_explains() -> None:
    run = Run(landmarks=POSTS)
    run.driver.look(np.pi / 2.0)
    run.sense(2.0)
    taken = pictures(run.sense(20.0))
    shown = [one for picture in taken for one in picture.sightings]
    assert {(one.kind, one.identity) for one in shown} == {("line", None)}
    assert np.mean([one.bearing for one in shown]) == pytest.approx(np.pi / 2.0, abs=0.1)
    (mount,) = (m for m in run.driver.describe().mounts if m.kind == "camera")
    assert {picture.frame_id for picture in taken} == {mount.frame_id}
    assert (mount.pose.x, mount.pose.theta) == (0.05, 0.0)


def test_a_camera_that_cannot_read_tells_no_identity() -> None:
    simulation = simulation_in(
        landmarks=POSTS, params=replace(EXACT, camera=CameraParams(reads_identities=False))
    )
    run = Run()
    run.driver = Simulator(simulation)
    shown = [one for picture in pictures(run.sense(5.0)) for one in picture.sightings]
    assert {(one.kind, one.identity) for one in shown} == {("post", None)}


def test_without_landmarks_there_is_no_camera_to_look_with() -> None:
    driver = Run().driver
    assert "look" not in driver.describe().commands
    assert all(mount.kind != "camera" for mount in driver.describe().mounts)
    with pytest.raises(DriverError, match="this robot has no camera"):
        driver.look(0.1)


def test_a_robot_with_a_camera_can_look() -> None:
    driver = Run(landmarks=POSTS).driver
    assert isinstance(driver, Gazeable)
    assert "look" in driver.describe().commands


def test_stamps_increase_and_lie_in_the_past() -> None:
    run = Run()
    measured = run.sense(2.0)
    for topic in ("odometry", "scan", "sonar"):
        stamps = [m.message.stamp_ns for m in measured if m.topic == topic]
        assert all(later > earlier for earlier, later in pairwise(stamps))
        assert stamps[0] > START_NS
        assert stamps[-1] <= run.now_ns


def test_how_often_it_is_looked_at_does_not_matter() -> None:
    often, seldom = Run(seed=3), Run(seed=3)
    for run in (often, seldom):
        run.go(0.3, 0.2)
    many = often.sense(0.4)
    few = list(seldom.driver.sense(START_NS + 400_000_000))
    assert [m.message.stamp_ns for m in many] == [m.message.stamp_ns for m in few]
    assert often.driver._simulation.pose == pytest.approx(seldom.driver._simulation.pose)


def test_every_message_survives_the_wire() -> None:
    for measurement in Run(landmarks=POSTS).sense(0.5):
        message = measurement.message
        assert encode(decode(type(message), encode(message))) == encode(message)


def test_the_world_stands_still_while_the_process_is_stopped() -> None:
    run = Run()
    run.go(0.5)
    run.sense(1.0)
    before = run.driver._simulation.pose.copy()
    run.now_ns += 60_000_000_000
    assert run.sense(0.02) == []
    assert run.driver._simulation.pose == pytest.approx(before, abs=0.02)


def test_odometry_and_truth_agree_on_a_robot_without_errors() -> None:
    run = Run()
    run.go(0.3, 0.4)
    measured = [m.message for m in run.sense(3.0)]
    odometry = next(m for m in reversed(measured) if isinstance(m, Odometry))
    truth = next(m for m in reversed(measured) if isinstance(m, GroundTruth))
    assert odometry.pose.x == pytest.approx(truth.pose.x - 1.5, abs=1e-6)
    assert odometry.pose.theta == pytest.approx(truth.pose.theta, abs=1e-6)


def test_the_scan_says_where_its_beams_point() -> None:
    scan = next(m.message for m in Run().sense(0.2) if isinstance(m.message, LaserScan))
    assert len(scan.ranges) == 271
    assert scan.angle_min == pytest.approx(-0.75 * np.pi)
    assert scan.angle_min + 270 * scan.angle_increment == pytest.approx(0.75 * np.pi)
    assert scan.ranges[135] == pytest.approx(4.0)


def test_the_bumper_speaks_when_something_changes() -> None:
    run = Run()
    run.go(0.6)
    bumps = [m.message for m in run.sense(10.0) if isinstance(m.message, Bumper)]
    assert [bump.pressed for bump in bumps] == [False, True]
    run.go(-0.6)
    bumps = [m.message for m in run.sense(1.0) if isinstance(m.message, Bumper)]
    assert [bump.pressed for bump in bumps] == [False]


def test_it_stands_within_a_tenth_of_a_second() -> None:
    run = Run()
    run.go(0.6, 1.5)
    run.sense(1.0)
    run.driver.stop()
    run.sense(0.1)
    assert run.driver._simulation.twist == pytest.approx((0.0, 0.0))


def test_it_cannot_move_sideways() -> None:
    with pytest.raises(DriverError, match="sideways"):
        Run().driver.drive(Twist2(vx=0.0, vy=0.1, omega=0.0))


def test_it_is_kidnappable_and_no_playback() -> None:
    driver = Run().driver
    assert isinstance(driver, Kidnappable)
    assert not isinstance(driver, Playback)


def test_leaving_it_stops_it() -> None:
    run = Run()
    with run.driver:
        run.go(0.5)
        run.sense(1.0)
    run.sense(0.2)
    assert run.driver._simulation.twist == (0.0, 0.0)


@pytest.fixture
def bench(repository: Path) -> Bench:
    world = repository / "deploy" / "worlds" / "hall.yaml"
    return Bench(RobotSettings(driver="simulator", world=world, seed=1))


def test_a_simulated_robot_wanders_until_someone_drives_it(bench: Bench) -> None:
    status = bench.listen("status")
    truth = bench.listen("ground_truth")
    bench.advance(5.0)
    assert (status[-1].source, status[-1].mode) == ("simulation", "wandering")
    assert np.hypot(truth[-1].pose.x - 4.0, truth[-1].pose.y - 5.0) > 0.5
    bench.ask("turn", c.Turn(angle=0.5))
    bench.advance(3.0)
    assert status[-1].reason == "turn 29 degrees: done"


def test_kidnapping_goes_where_it_is_told(bench: Bench) -> None:
    truth = bench.listen("ground_truth")
    there = Pose2(x=10.0, y=11.0, theta=1.0)
    assert bench.ask("kidnap", c.Kidnap(pose=there)) == c.Kidnapped(pose=there)
    bench.advance(0.1)
    assert truth[-1].pose.x == pytest.approx(10.0, abs=0.1)


def test_kidnapping_to_anywhere_says_where(bench: Bench) -> None:
    reply = bench.ask("kidnap", c.Kidnap())
    assert isinstance(reply, c.Kidnapped)
    assert np.hypot(reply.pose.x - 4.0, reply.pose.y - 5.0) >= 2.0


def test_kidnapping_into_a_wall_is_refused_with_the_reason(bench: Bench) -> None:
    with pytest.raises(RefusedError, match="lies outside of the map"):
        bench.ask("kidnap", c.Kidnap(pose=Pose2(x=40.0, y=5.0, theta=0.0)))


def test_a_kidnapped_robot_does_not_go_on_with_its_motion(bench: Bench) -> None:
    bench.ask("forward", c.Drive(distance=5.0))
    bench.advance(0.5)
    bench.ask("kidnap", c.Kidnap())
    bench.advance(0.1)
    assert bench.service.pilot.reason == "carried away"


def test_a_robot_that_wanders_stands_within_the_promised_time(bench: Bench) -> None:
    for _ in range(20):
        bench.ask("wander", c.Wander(enabled=True))
        bench.advance(1.0)
        reply = bench.ask("stop", c.Nothing())
        assert isinstance(reply, c.Stopped)
        assert reply.after < 0.15


def test_without_commands_it_stands_within_600_ms(bench: Bench) -> None:
    truth = bench.listen("ground_truth")
    for speed in (0.6, -0.6):
        for _ in range(5):
            bench.ask("velocity", c.Velocity(twist=Twist2(vx=speed, vy=0.0, omega=1.0)))
            bench.advance(0.4)
        last_ns = bench.clock.now_ns() - 400_000_000
        bench.advance(0.6)
        late = [m for m in truth if m.stamp_ns >= last_ns + 600_000_000]
        assert late
        assert all(m.twist.vx == 0.0 and m.twist.omega == 0.0 for m in late)
