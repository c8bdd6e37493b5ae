"""The robot service on a fake bus."""

import numpy as np
import pytest

from pilotage.bus.deployment import ConfigError, Deployment, service_settings
from pilotage.bus.fabric import RefusedError
from pilotage.robot.config import RobotSettings
from pilotage.robot.driver import Measurement
from pilotage_schemas import commands as c
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.message import Part
from pilotage_schemas.planning import VelocityCommand
from pilotage_schemas.topics import TOPICS
from robot_world import Bench, bump, toy_bench
from sample_messages import odometry, scan


def ahead(speed: float) -> c.Velocity:
    return c.Velocity(twist=Twist2(vx=speed, vy=0.0, omega=0.0))


def test_what_the_driver_senses_goes_out_by_its_topic() -> None:
    bench, _ = toy_bench()
    scans, poses = bench.listen("scan"), bench.listen("odometry")
    bench.advance(0.2)
    assert len(scans) == len(poses) == 10


def test_the_description_is_there_for_whoever_comes_late() -> None:
    bench, _ = toy_bench()
    bench.advance(5.0)
    (description,) = bench.listen("description")
    assert description.name == "Toy"
    assert description.stamp_ns > 0


def test_status_comes_twice_a_second_and_at_each_change() -> None:
    bench, _ = toy_bench()
    heard = bench.listen("status")
    bench.advance(2.0)
    assert [status.mode for status in heard] == ["stopped"] * 4
    bench.ask("forward", c.Drive(distance=1.0))
    bench.advance(0.02)
    assert heard[-1].mode == "commanded"
    assert heard[-1].reason == "forward 1.00 m"
    assert heard[-1].source == "live"


def test_forward_drives_that_far_and_says_so() -> None:
    bench, robot = toy_bench()
    heard = bench.listen("status")
    reply = bench.ask("forward", c.Drive(distance=1.0, speed=0.5))
    assert reply == c.Done(detail="forward 1.00 m")
    bench.advance(5.0)
    assert robot.pose[0] == pytest.approx(1.0, abs=0.03)
    assert heard[-1].reason == "forward 1.00 m: done"


def test_backward_and_turn_do_as_they_say() -> None:
    bench, robot = toy_bench()
    bench.ask("backward", c.Drive(distance=0.5))
    bench.advance(4.0)
    bench.ask("turn", c.Turn(angle=-1.0))
    bench.advance(4.0)
    assert robot.pose == pytest.approx([-0.5, 0.0, -1.0], abs=0.03)


def test_a_velocity_holds_for_half_a_second() -> None:
    bench, robot = toy_bench()
    heard = bench.listen("status")
    bench.ask("velocity", ahead(0.3))
    bench.advance(0.48)
    assert robot.twist.vx == pytest.approx(0.3)
    bench.advance(0.04)
    assert robot.twist.vx == 0.0
    assert heard[-1].reason == "no velocity command for 0.5 s"


def test_velocities_that_keep_coming_keep_the_robot_going() -> None:
    bench, robot = toy_bench()
    for _ in range(10):
        bench.ask("velocity", ahead(0.3))
        bench.advance(0.3)
    assert robot.pose[0] > 0.8


def test_the_planners_velocities_come_by_topic() -> None:
    bench, robot = toy_bench()
    bench.publish_velocity(
        VelocityCommand(
            stamp_ns=bench.clock.now_ns(),
            frame_id="base_link",
            twist=Twist2(vx=0.2, vy=0.0, omega=0.5),
        )
    )
    bench.advance(0.3)
    assert (robot.twist.vx, robot.twist.omega) == pytest.approx((0.2, 0.5))
    bench.advance(0.4)
    assert robot.twist.vx == 0.0


def by_program(bench: Bench, orders: int | None, then: str = "more") -> None:
    """A planner's velocity, sent by one who knows of so many orders of people."""
    command = VelocityCommand.model_validate(
        {
            "stamp_ns": bench.clock.now_ns(),
            "frame_id": "base_link",
            "twist": ahead(0.2).twist,
            "orders": orders,
            "then": then,
        }
    )
    bench.publish_velocity(command)


def test_what_a_planner_sent_before_it_knew_of_a_stop_does_not_undo_it() -> None:
    bench, robot = toy_bench()
    heard = bench.listen("status")
    by_program(bench, orders=0)
    bench.advance(0.2)
    assert robot.twist.vx > 0.0
    bench.ask("stop", c.Nothing())
    bench.asker.step()
    assert (heard[-1].orders, heard[-1].is_held) == (1, True), "said before the stop is answered"
    by_program(bench, orders=0)
    bench.advance(0.2)
    assert robot.twist.vx == 0.0
    by_program(bench, orders=1)
    bench.advance(0.6)
    assert robot.pose[0] > 0.07
    assert not heard[-1].is_held


@pytest.mark.parametrize(
    ("order", "is_held", "reason"),
    [
        (("stop", c.Nothing()), True, "stopped by command"),
        (("forward", c.Drive(distance=1.0)), True, "forward 1.00 m"),
        (("turn", c.Turn(angle=1.0)), True, "turn 57 degrees"),
        (("wander", c.Wander(enabled=False)), True, "velocity command"),
        (("wander", c.Wander(enabled=True)), False, "going about by itself"),
    ],
)
def test_every_word_of_a_person_is_counted_and_said_with_what_it_led_to(
    order: tuple[str, Part],
    is_held: bool,  # noqa: FBT001 - a parameter of the test
    reason: str,
) -> None:
    bench, _ = toy_bench()
    by_program(bench, orders=0)
    bench.advance(0.1)
    heard = bench.listen("status")
    bench.ask(*order)
    bench.advance(0.1)
    first = next(status for status in heard if status.orders == 1)
    assert (first.is_held, first.reason) == (is_held, reason)


def test_the_planner_lets_go_of_a_robot_that_wandered_before() -> None:
    bench, _ = toy_bench()
    heard = bench.listen("status")
    bench.ask("wander", c.Wander(enabled=True))
    by_program(bench, orders=1)
    bench.advance(0.2)
    assert heard[-1].mode == "commanded"
    by_program(bench, orders=1, then="resume")
    bench.advance(0.2)
    assert heard[-1].mode == "wandering"


def test_speed_and_acceleration_are_limited_before_the_driver() -> None:
    bench, robot = toy_bench(max_linear=0.4, acceleration=1.0)
    bench.ask("velocity", ahead(5.0))
    assert robot.twist.vx == pytest.approx(0.02)
    bench.advance(0.44)
    assert robot.twist.vx == pytest.approx(0.4)


def test_stop_is_answered_when_the_robot_stands() -> None:
    bench, robot = toy_bench()
    bench.ask("velocity", ahead(0.3))
    bench.advance(0.1)
    reply = bench.ask("stop", c.Nothing())
    assert isinstance(reply, c.Stopped)
    assert 0.0 <= reply.after < 0.1
    assert robot.twist.vx == 0.0


def test_stop_says_so_when_the_robot_does_not_stand() -> None:
    bench, robot = toy_bench()
    bench.ask("velocity", ahead(0.3))
    bench.advance(0.3)
    robot.coasts = True
    with pytest.raises(RefusedError, match="still moves"):
        bench.ask("stop", c.Nothing())
    assert robot.stops > 0


def test_sideways_is_refused() -> None:
    bench, robot = toy_bench()
    with pytest.raises(RefusedError, match="sideways"):
        bench.ask("velocity", c.Velocity(twist=Twist2(vx=0.0, vy=0.1, omega=0.0)))
    assert robot.twist.vy == 0.0


def test_a_command_that_the_robot_does_not_have_is_refused() -> None:
    bench, robot = toy_bench()
    robot.commands = ("stop",)
    bench.service.description = robot.describe()
    with pytest.raises(RefusedError, match="Toy has no command forward"):
        bench.ask("forward", c.Drive(distance=1.0))


def test_what_the_driver_refuses_is_refused_with_its_reason() -> None:
    bench, robot = toy_bench()
    robot.refuses = "the emergency button is pressed"
    with pytest.raises(RefusedError, match="the emergency button is pressed"):
        bench.ask("forward", c.Drive(distance=1.0))
    assert bench.service.pilot.mode == "stopped"


def test_only_a_simulated_robot_can_be_kidnapped() -> None:
    bench, _ = toy_bench()
    with pytest.raises(RefusedError, match="only a simulated robot"):
        bench.ask("kidnap", c.Kidnap(pose=Pose2(x=0.0, y=0.0, theta=0.0)))


def test_a_silent_laser_stops_the_robot_and_is_named() -> None:
    bench, robot = toy_bench()
    bench.ask("forward", c.Drive(distance=50.0))
    bench.advance(0.5)
    robot.silent = {"scan"}
    bench.advance(0.9)
    assert robot.twist.vx > 0.0
    bench.advance(0.2)
    assert robot.twist.vx == 0.0
    assert bench.service.pilot.reason == "no scan for 1 s"


def test_a_person_may_drive_with_a_silent_laser() -> None:
    bench, robot = toy_bench()
    robot.silent = {"scan"}
    for _ in range(10):
        bench.ask("velocity", ahead(0.3))
        bench.advance(0.2)
    assert robot.twist.vx > 0.0


def test_a_robot_without_laser_relies_on_its_odometry_alone() -> None:
    bench, robot = toy_bench(has_laser=False)
    bench.ask("forward", c.Drive(distance=50.0))
    bench.advance(3.0)
    assert robot.twist.vx > 0.0
    robot.silent = {"odometry"}
    bench.advance(0.6)
    assert robot.twist.vx == 0.0


def test_wandering_needs_a_laser() -> None:
    bench, _ = toy_bench(has_laser=False)
    with pytest.raises(RefusedError, match="needs a laser"):
        bench.ask("wander", c.Wander(enabled=True))


def test_a_real_robot_wanders_only_when_told_to() -> None:
    bench, robot = toy_bench()
    bench.advance(1.0)
    assert bench.service.pilot.mode == "stopped"
    bench.ask("wander", c.Wander(enabled=True))
    bench.advance(5.0)
    assert np.hypot(*robot.pose[:2]) > 0.5
    bench.ask("wander", c.Wander(enabled=False))
    assert bench.service.pilot.reason == "told to wander no longer"
    assert robot.twist.vx == 0.0


def test_a_setting_lets_it_wander_from_the_start() -> None:
    bench, _ = toy_bench(wander=True)
    assert bench.service.pilot.mode == "wandering"


def test_any_drive_command_ends_wandering() -> None:
    for name, request in (
        ("forward", c.Drive(distance=0.1)),
        ("velocity", ahead(0.1)),
        ("stop", c.Nothing()),
    ):
        bench, _ = toy_bench(wander=True)
        bench.advance(0.5)
        bench.ask(name, request)
        bench.advance(3.0)
        assert bench.service.pilot.mode == "stopped", name


def test_running_into_something_ends_a_motion() -> None:
    bench, robot = toy_bench()
    bench.ask("forward", c.Drive(distance=5.0))
    bench.advance(0.5)
    robot.extra = [bump(bench.clock.now_ns())]
    bench.advance(0.1)
    assert robot.twist.vx == 0.0
    assert bench.service.pilot.reason == "forward 5.00 m: ran into something"


def test_backing_away_from_what_one_touches_is_allowed() -> None:
    bench, robot = toy_bench()
    robot.extra = [bump(bench.clock.now_ns())]
    bench.advance(0.1)
    bench.ask("backward", c.Drive(distance=0.5))
    bench.advance(4.0)
    assert robot.pose[0] == pytest.approx(-0.5, abs=0.03)


def test_a_lost_connection_stops_the_robot_and_is_told() -> None:
    bench, robot = toy_bench()
    bench.ask("forward", c.Drive(distance=5.0))
    bench.advance(0.2)
    robot.broken = "the cable is out"
    bench.advance(0.1)
    assert bench.service.pilot.reason == "driver: the cable is out"
    assert "the cable is out" in bench.node.vitals.last_error
    robot.broken = None
    bench.advance(0.1)
    bench.ask("forward", c.Drive(distance=0.1))


@pytest.mark.parametrize("topic", ["scan", "pose", "nonsense"])
def test_a_measurement_by_the_wrong_topic_is_dropped_and_told(topic: str) -> None:
    bench, robot = toy_bench()
    robot.extra = [Measurement(topic, odometry(bench.clock.now_ns()))]
    bench.advance(0.1)
    assert f"does not go out by topic '{topic}'" in bench.node.vitals.last_error


def test_a_scan_without_a_mount_goes_out_and_steers_nothing() -> None:
    bench, robot = toy_bench(has_laser=False)
    scans = bench.listen("scan")
    robot.extra = [Measurement("scan", scan(bench.clock.now_ns()))]
    bench.advance(0.1)
    assert len(scans) == 1


def test_every_topic_of_the_robot_has_a_publisher() -> None:
    bench, _ = toy_bench()
    owned = {topic.name for topic in TOPICS.values() if topic.owner == "robot"}
    assert set(bench.service._out) == owned


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"driver": "simulater"}, "driver"),
        ({"speed": 0.5}, "speed"),
        ({"speed": "fast"}, "speed"),
        ({"max_linear": 0.0}, "max_linear"),
        ({"command_timeout": 2.0}, "command_timeout"),
        ({"velocity": 1}, "velocity"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings: dict[str, object], reason: str) -> None:
    deployment = Deployment(services={"robot": settings})
    with pytest.raises(ConfigError, match=reason):
        service_settings(deployment, "robot", RobotSettings)
