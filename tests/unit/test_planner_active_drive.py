"""Driving so as to find out: decide, follow, look, decide anew."""

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.laser_view import View
from pilotage.core.raycast import cast_scan
from pilotage.planner import active_drive
from pilotage.planner.active_drive import AS_LONG, NEWS, PERIOD, ActiveDrive
from pilotage.planner.active_localization import ActiveLocalization, ActiveParams
from pilotage.planner.situation import Hypotheses, Situation
from pilotage.robot.simulator.floor_plans import office_floor, office_rooms
from pilotage.robot.simulator.simulation import RobotParams, Simulation
from pilotage.robot.simulator.walls import Walls
from planner_ride import Ride, view_of
from planner_world import NOTHING, belief, hall, plan, seen

ROOMS = plan(
    """
    ##############################
    #........##........##........#
    #........##........##........#
    #........##........##........#
    #........##........##........#
    ####..########..########..####
    #............................#
    #............................#
    #............................#
    ##############################
    """
)
HERE, NEXT_ROOM = np.array([2.3, 3.75, 0.3]), np.array([5.0, 0.0, 0.0])
LATE = 123_456.0
"""s: the clock of a machine that has been on for a day."""


@lru_cache
def _rooms() -> ActiveLocalization:
    return ActiveLocalization(ROOMS, ActiveParams(candidates=20))


def drive() -> ActiveDrive:
    return ActiveDrive(_rooms(), np.random.default_rng(0))


def situation(
    now: float = LATE,
    odom: tuple[float, float, float] = (0.0, 0.0, 0.0),
    places: Hypotheses | None = None,
    view: View | None = None,
) -> Situation:
    """Return what is known in one of two rooms, odometry having begun at HERE."""
    moved = np.array(odom)
    both = belief(HERE, HERE + NEXT_ROOM).moved(moved) if places is None else places
    around = seen(ROOMS, both.poses[0]) if view is None else view
    return Situation(now, moved, around, both, "ambiguous")


def test_it_decides_at_once_and_goes() -> None:
    driver = drive()
    speeds = [driver.step(situation(LATE + 0.1 * step)) for step in range(5)]
    assert driver.decision is not None
    assert driver.decision.told_apart == (0, 1)
    assert speeds[-1] != (0.0, 0.0)
    assert len(driver._tried) == 0


def test_a_long_uptime_is_not_time_without_getting_on() -> None:
    driver = drive()
    driver.step(situation(now=LATE))
    decision = driver.decision
    driver.step(situation(now=LATE + 0.1))
    assert driver.decision is decision


def test_a_pause_is_not_time_without_getting_on() -> None:
    driver = drive()
    driver.step(situation())
    driver.step(situation(LATE + 3600.0))
    assert len(driver._tried) == 0


def test_no_news_is_no_reason_to_decide_anew() -> None:
    driver = drive()
    driver.step(situation())
    decision = driver.decision
    for step in range(1, 30):
        driver.step(situation(LATE + 0.1 * step))
    assert driver.decision is decision


def test_it_decides_anew_once_a_place_is_ruled_out_but_not_within_a_second() -> None:
    driver = drive()
    driver.step(situation())
    before, sure = driver.decision, belief(HERE)
    driver.step(situation(LATE + 0.5 * PERIOD, places=sure))
    assert driver.decision is before
    driver.step(situation(LATE + PERIOD, places=sure))
    assert driver.decision is not before
    assert driver.decision is not None
    assert driver.decision.uncertainty == 0.0


@pytest.mark.parametrize(("share", "is_news"), [(0.3, False), (0.05, True)])
def test_as_much_as_half_a_bit_is_news(share: float, *, is_news: bool) -> None:
    driver = drive()
    driver.step(situation())
    before = driver.decision
    shifted = belief(HERE, HERE + NEXT_ROOM, weights=(1.0 - share, share))
    driver.step(situation(LATE + 2.0 * PERIOD, places=shifted))
    assert (driver.decision is not before) == is_news


def test_it_thinks_again_after_two_metres_of_way() -> None:
    driver = drive()
    driver.step(situation())
    before = driver.decision
    driver.step(situation(LATE + 4.0, odom=(AS_LONG - 0.1, 0.0, 0.0)))
    assert driver.decision is before
    driver.step(situation(LATE + 4.1, odom=(AS_LONG + 0.1, 0.0, 0.0)))
    assert driver.decision is not before


def arrive(driver: ActiveDrive, now: float) -> tuple[float, float, float]:
    """Let a driver be at the end of its path, the way it wants to look; return where that is."""
    assert driver.decision is not None
    end = driver.decision.path[-1]
    along = driver.decision.path[-1] - driver.decision.path[-2]
    heading = driver.decision.heading
    turn = float(np.arctan2(along[1], along[0])) if heading is None else heading
    there = (float(end[0]), float(end[1]), turn)
    driver.step(situation(now, odom=there))
    return there


def test_where_it_has_arrived_is_tried_and_the_next_look_is_elsewhere() -> None:
    driver = drive()
    driver.step(situation())
    there = arrive(driver, LATE + PERIOD)
    assert driver._tried == pytest.approx(np.array([there[:2]]), abs=1e-9)
    first = driver.decision
    driver.step(situation(LATE + 2.0 * PERIOD, odom=there))
    assert driver.decision is not first
    assert driver.decision is not None
    assert np.hypot(*driver.decision.path[-1]) > 0.4


def test_it_does_not_decide_at_every_step_where_it_has_just_arrived() -> None:
    driver = drive()
    driver.step(situation())
    there = arrive(driver, LATE + 0.1)
    first = driver.decision
    speeds = driver.step(situation(LATE + 0.2, odom=there))
    assert driver.decision is first
    assert speeds == (0.0, 0.0)


def test_what_is_blocked_for_good_is_tried() -> None:
    driver = drive()
    driver.step(situation())
    # Something stands all round the robot, where it was free when the way was chosen.
    angles = np.linspace(-np.pi, np.pi, 90)
    ring = View(0.21 * np.column_stack([np.cos(angles), np.sin(angles)]), angles)
    steps = 0
    while len(driver._tried) == 0 and steps < 150:
        steps += 1
        driver.step(situation(LATE + 0.1 * steps, view=ring))
    assert len(driver._tried) == 1
    assert 1.0 < 0.1 * steps < 12.0


@pytest.mark.parametrize(
    "places",
    [
        belief(HERE),
        belief(HERE, [np.nextafter(0.0, -1.0), -30.0, 1.0]),
        belief([500.0, 500.0, 0.0]),
        Hypotheses(np.tile(HERE, (2000, 1)), np.full(2000, 1.0 / 2000)),
        belief(HERE, HERE + NEXT_ROOM, weights=(1.0, 1e-300)),
        belief(HERE, HERE + NEXT_ROOM, weights=(1.0, 0.0)),
    ],
    ids=["sure", "half outside", "outside", "the same 2000 times", "hardly doubted", "no weight"],
)
@pytest.mark.parametrize(
    "view",
    [NOTHING, View(np.zeros((0, 2)), np.zeros(0)), seen(ROOMS, HERE)],
    ids=["-", "0", "laser"],
)
def test_whatever_it_is_told_it_says_speeds_that_are_numbers(
    places: Hypotheses, view: View
) -> None:
    driver = drive()
    for step in range(4):
        speeds = driver.step(situation(LATE + step, places=places, view=view))
        assert np.isfinite(speeds).all()
        assert abs(speeds[0]) <= driver.limits.max_linear
        assert abs(speeds[1]) <= driver.limits.max_angular
    assert driver.decision is not None
    assert np.isfinite(driver.decision.path).all()
    assert np.isfinite([look.gain for look in driver.decision.looks]).all()


def test_what_counts_as_news_is_less_than_telling_two_places_apart() -> None:
    assert 0.0 < NEWS < 1.0
    assert active_drive.LONGEST_STEP < PERIOD


AROUND = np.linspace(-2.3, 2.3, 60)


@dataclass
class Exact:
    """A localizer that knows all places the robot can be at, and weighs them by every scan.

    `begun` (n, 3): where it could have been put down; the first of them is true.
    """

    world: OccupancyMap
    begun: NDArray[np.float64]
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(8))

    def __post_init__(self) -> None:
        self.logs = np.zeros(len(self.begun))

    def look(self, moved: NDArray[np.float64]) -> Hypotheses:
        """Weigh them by a scan taken after a move (3,) from where it was put down."""
        poses = se2.compose(self.begun, moved)
        scans = np.array([np.minimum(cast_scan(self.world, p, AROUND, 12.0), 12.0) for p in poses])
        taken = scans[0] + self.rng.normal(0.0, 0.02, len(AROUND))
        costs = np.minimum(0.5 * ((scans - taken) / 0.2) ** 2, 3.0).sum(axis=1)
        # Little at a time: scans taken one after the other tell the same.
        self.logs -= 0.02 * costs
        weights = np.exp(self.logs - self.logs.max())
        return Hypotheses(poses, weights / weights.sum())


def single_offices() -> NDArray[np.float64]:
    """Return the same pose in each of the single offices whose door is to the north."""
    rooms = office_rooms()
    first = rooms[0].box
    alike = [
        room.box
        for room in rooms
        if room.door_side == rooms[0].door_side
        and np.allclose(np.subtract(room.box[2:], room.box[:2]), np.subtract(first[2:], first[:2]))
    ]
    return np.array([[x0 + 2.0, y0 + 3.6, 0.4] for x0, y0, _, _ in alike])


@lru_cache
def _office() -> tuple[OccupancyMap, ActiveLocalization]:
    world = office_floor()
    return world, ActiveLocalization(world, ActiveParams(candidates=30))


@pytest.mark.parametrize("room", [1, 5])
def test_it_finds_out_in_which_of_the_alike_offices_it_is(room: int) -> None:
    world, active = _office()
    places = single_offices()
    begun = np.roll(places, -room, axis=0)
    rng = np.random.default_rng(room)
    simulation = Simulation(Walls.of(world), RobotParams(), 0, rng)
    simulation.put(begun[0])
    ride, localizer = Ride(simulation), Exact(world, begun)
    driver, decisions = ActiveDrive(active, rng), set[int]()
    known = localizer.look(np.zeros(3))
    while known.weights.max() < 0.99 and ride.seconds < 120.0:
        moved = se2.between(begun[0], simulation.pose)
        known = localizer.look(moved)
        now = Situation(LATE + ride.seconds, moved, view_of(simulation), known, "ambiguous")
        ride.drive(driver.step(now))
        decisions.add(id(driver.decision))
    assert known.weights.argmax() == 0
    assert known.weights[0] > 0.99
    assert not ride.touched
    assert len(driver._tried) <= 4
    assert ride.metres < 25.0


def test_in_a_hall_that_looks_the_same_from_four_sides_it_admits_that_nothing_helps() -> None:
    """It has gone far to see whether anything does, and run into nothing."""
    world = hall(8.0)
    active = ActiveLocalization(world, ActiveParams(candidates=20))
    turned = np.column_stack([np.full((4, 2), 4.0), np.arange(4) * np.pi / 2.0])
    begun = se2.compose(turned, [-1.0, 0.5, 0.3])
    rng = np.random.default_rng(3)
    simulation = Simulation(Walls.of(world), RobotParams(), 0, rng)
    simulation.put(begun[0])
    ride, driver = Ride(simulation), ActiveDrive(active, rng)
    while ride.seconds < 200.0 and driver.failure is None:
        moved = se2.between(begun[0], simulation.pose)
        known = Hypotheses(se2.compose(begun, moved), np.full(4, 0.25))
        ride.drive(driver.step(Situation(ride.seconds, moved, view_of(simulation), known, "lost")))
    assert not ride.touched
    assert driver.failure == "nothing within reach tells the 4 places apart"
    assert len(driver._tried) >= 3
    assert np.hypot(*np.diff(driver._tried, axis=0).T).max() > 4.0
    assert driver.step(replace(situation(LATE), now=ride.seconds + 5.0)) == (0.0, 0.0)


def test_a_slow_body_is_driven_within_its_limits() -> None:
    driver = drive()
    driver = replace(driver, limits=replace(driver.limits, max_linear=0.1, max_angular=0.3))
    for step in range(20):
        linear, angular = driver.step(situation(LATE + 0.1 * step))
        assert 0.0 <= linear <= 0.1
        assert abs(angular) <= 0.3
