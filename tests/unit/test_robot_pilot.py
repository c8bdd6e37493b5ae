"""Who drives."""

import numpy as np
import pytest

from pilotage.core.laser_view import View
from pilotage.core.motion import arc
from pilotage.robot.motion_command import Straight
from pilotage.robot.pilot import Pilot
from pilotage.robot.wander import Wanderer, WanderParams
from pilotage.robot.watchdog import Limits, SensorWatch

OPEN = View(np.empty((0, 2)), np.linspace(-2.0, 2.0, 61))
WALL_AHEAD = View(np.array([[0.4, y] for y in np.linspace(-0.5, 0.5, 11)]), OPEN.bearings)
DT = 0.02


class Seat:
    """A pilot whose sensors are alive as long as a test wants."""

    def __init__(self, *, relied_on: tuple[str, ...] = ("odometry", "scan")) -> None:
        wanderer = Wanderer(WanderParams(), np.random.default_rng(0))
        watch = SensorWatch({"odometry": 0.5, "scan": 1.0})
        self.pilot = Pilot(Limits(), watch, relied_on, wanderer)
        self.now = 100.0
        self.pose = np.zeros(3)
        self.view = OPEN
        self.alive = {"odometry", "scan"}
        self.hear()

    @property
    def mode(self) -> str:
        """Who drives."""
        return self.pilot.mode

    def hear(self) -> None:
        if "odometry" in self.alive:
            self.pilot.hear_odometry(self.pose, self.now)
        if "scan" in self.alive:
            self.pilot.hear_scan(self.view, self.now)

    def run(self, seconds: float) -> tuple[float, float] | None:
        speeds = None
        for _ in range(round(seconds / DT)):
            self.now += DT
            self.hear()
            speeds = self.pilot.step(self.now, DT)
            self.pose = arc(self.pose, *(speeds or (0.0, 0.0)), DT)
        return speeds


def test_nobody_drives_at_first() -> None:
    seat = Seat()
    assert seat.run(1.0) is None
    assert (seat.pilot.mode, seat.pilot.reason) == ("stopped", "waiting for a command")


def test_the_latest_command_counts() -> None:
    seat = Seat()
    seat.pilot.move(Straight(5.0, 0.3))
    seat.run(1.0)
    seat.pilot.obey((-0.2, 0.0), seat.now, by_itself=False)
    assert seat.run(0.3) == pytest.approx((-0.2, 0.0))
    seat.pilot.move(Straight(5.0, 0.3))
    assert seat.run(1.0) == pytest.approx((0.3, 0.0))


def test_after_a_stop_the_next_motion_begins_at_rest() -> None:
    seat = Seat()
    seat.pilot.obey((0.6, 0.0), seat.now, by_itself=False)
    seat.run(0.4)
    seat.pilot.stop("enough")
    assert seat.run(0.02) is None
    seat.pilot.obey((0.6, 0.0), seat.now, by_itself=False)
    assert seat.run(0.02) == pytest.approx((0.8 * DT, 0.0))


def test_the_wanderer_drives_into_the_open() -> None:
    seat = Seat()
    seat.pilot.wander()
    speeds = seat.run(3.0)
    assert speeds is not None
    assert speeds[0] > 0.2


def test_a_wanderer_pauses_while_its_laser_is_silent_and_then_goes_on() -> None:
    seat = Seat()
    seat.pilot.wander()
    seat.run(1.0)
    seat.alive = {"odometry"}
    assert seat.run(1.2) is None
    assert (seat.pilot.mode, seat.pilot.reason) == ("stopped", "no scan for 1 s")
    seat.alive = {"odometry", "scan"}
    seat.run(1.0)
    assert seat.pilot.mode == "wandering"


def test_a_pause_ends_with_a_stop_command() -> None:
    seat = Seat()
    seat.pilot.wander()
    seat.alive = set()
    seat.run(1.5)
    seat.pilot.stop("stopped by command")
    seat.alive = {"odometry", "scan"}
    seat.run(1.0)
    assert (seat.pilot.mode, seat.pilot.reason) == ("stopped", "stopped by command")


def test_a_commanded_motion_does_not_go_on_after_a_silence() -> None:
    seat = Seat()
    seat.pilot.move(Straight(50.0, 0.3))
    seat.run(0.5)
    seat.alive = set()
    seat.run(1.0)
    seat.alive = {"odometry", "scan"}
    assert seat.run(1.0) is None
    assert seat.pilot.reason == "no odometry for 0.5 s"


def test_a_program_relies_on_sensors_and_a_person_does_not() -> None:
    for by_itself, expected in ((True, "stopped"), (False, "commanded")):
        seat = Seat()
        seat.alive = set()
        seat.run(0.7)
        seat.pilot.obey((0.1, 0.0), seat.now, by_itself=by_itself)
        seat.run(0.1)
        assert seat.pilot.mode == expected


def test_what_the_bumper_feels_the_wanderer_turns_away_from() -> None:
    seat = Seat()
    seat.pilot.wander()
    seat.run(1.0)
    seat.pilot.hear_bumper(0.0, is_pressed=True)
    speeds = seat.run(1.0)
    assert speeds is not None
    assert speeds[0] == pytest.approx(0.0, abs=0.05)
    assert speeds[1] != 0.0


def test_a_wall_ahead_keeps_the_wanderer_from_driving() -> None:
    seat = Seat()
    seat.view = WALL_AHEAD
    seat.pilot.wander()
    for _ in range(20):
        speeds = seat.run(0.1)
        assert speeds is not None
        assert speeds[0] < 0.1


def test_a_bump_beside_does_not_end_a_motion_but_one_ahead_does() -> None:
    seat = Seat()
    seat.pilot.move(Straight(5.0, 0.3))
    seat.pilot.hear_bumper(np.pi / 2.0, is_pressed=True)
    seat.run(0.1)
    assert seat.pilot.mode == "commanded"
    seat.pilot.hear_bumper(None, is_pressed=True)
    seat.run(0.1)
    assert seat.pilot.reason == "forward 5.00 m: ran into something"


def test_a_robot_that_wandered_goes_on_with_it_when_it_is_released() -> None:
    seat = Seat()
    seat.pilot.wander()
    seat.pilot.obey((0.0, 0.0), seat.now, by_itself=True)
    assert seat.mode == "commanded"
    seat.pilot.release(resume=True)
    assert seat.mode == "wandering"


def test_a_robot_that_stood_stands_when_it_is_released() -> None:
    seat = Seat()
    seat.pilot.obey((0.2, 0.0), seat.now, by_itself=True)
    seat.pilot.release(resume=True)
    assert (seat.pilot.mode, seat.pilot.reason) == ("stopped", "at the end of its way")


def test_a_robot_that_wandered_stands_when_that_is_wanted_at_the_end() -> None:
    seat = Seat()
    seat.pilot.wander()
    seat.pilot.obey((0.2, 0.0), seat.now, by_itself=True)
    seat.pilot.release(resume=False)
    assert seat.mode == "stopped"
    seat.pilot.release(resume=True)
    assert seat.mode == "stopped"


def test_who_fell_silent_can_still_let_the_robot_wander_on() -> None:
    seat = Seat()
    seat.pilot.wander()
    seat.pilot.obey((0.0, 0.0), seat.now, by_itself=True)
    seat.run(1.0)
    assert seat.mode == "stopped"
    seat.pilot.obey((0.0, 0.0), seat.now, by_itself=True)
    seat.pilot.release(resume=True)
    assert seat.mode == "wandering"


def test_nothing_goes_on_behind_the_back_of_who_stopped_it() -> None:
    seat = Seat()
    seat.pilot.wander()
    seat.pilot.obey((0.2, 0.0), seat.now, by_itself=True)
    seat.pilot.take_order(is_held=True)
    seat.pilot.stop("stopped by command")
    seat.pilot.release(resume=True)
    assert (seat.pilot.mode, seat.pilot.reason) == ("stopped", "stopped by command")
    assert (seat.pilot.orders, seat.pilot.is_held) == (1, True)


def test_a_motion_of_a_person_is_not_ended_by_the_release_of_a_program() -> None:
    seat = Seat()
    seat.pilot.obey((0.2, 0.0), seat.now, by_itself=True)
    seat.pilot.take_order(is_held=True)
    seat.pilot.move(Straight(5.0, 0.3))
    seat.pilot.release(resume=False)
    assert seat.mode == "commanded"
    assert seat.run(1.0) == pytest.approx((0.3, 0.0))
