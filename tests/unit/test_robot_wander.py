"""Wandering on drawn floors."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from drawing import draw
from pilotage.core.grid import OccupancyMap
from pilotage.core.laser_view import View
from pilotage.robot.simulator.floor_plans import office_floor, office_rooms, square_hall
from pilotage.robot.simulator.range_sensors import scan
from pilotage.robot.simulator.simulation import RobotParams, Simulation
from pilotage.robot.simulator.walls import Walls
from pilotage.robot.wander import Wanderer, WanderParams
from pilotage.robot.watchdog import Limits
from robot_world import EXACT, ROOM, simulation_in

DEG = np.pi / 180.0


def view_of(simulation: Simulation) -> View:
    laser = simulation.params.laser
    ranges = scan(simulation.surroundings, simulation.pose, laser, simulation.rng)
    return View.of(ranges, laser.bearings, (laser.mount_x, 0.0, 0.0))


class Walk:
    """What came of wandering for some time: the way (n, 2), bumps, longest stay at a place."""

    def __init__(self, simulation: Simulation, seconds: float, seed: int) -> None:
        wanderer = Wanderer(WanderParams(), np.random.default_rng(seed))
        self.bumps, self.longest_stay = 0, 0.0
        way, speeds, limits = [simulation.pose[:2]], (0.0, 0.0), Limits()
        anchor, since = simulation.pose[:2], 0
        for step in range(round(seconds * 10)):
            wanted = wanderer.step(view_of(simulation), simulation.odometry.pose, 0.1)
            for tick in range(10):
                if tick % 2 == 0:
                    speeds = limits.applied(wanted, speeds, 0.02)
                    simulation.want(*speeds)
                simulation.tick()
                self.bumps += simulation.contact is not None
            simulation.count_wheels()
            way.append(simulation.pose[:2])
            if np.hypot(*(simulation.pose[:2] - anchor)) > 0.3:
                anchor, since = simulation.pose[:2], step
            self.longest_stay = max(self.longest_stay, (step - since) / 10.0)
        self.way = np.array(way)

    @property
    def square_metres(self) -> int:
        """How many squares of 1 m x 1 m it came through."""
        return len({(int(x), int(y)) for x, y in self.way})

    @property
    def rooms(self) -> int:
        """How many rooms of the office it went into."""
        x, y = self.way.T
        boxes = [room.box for room in office_rooms()]
        return sum(
            bool(((x > a + 0.3) & (x < c - 0.3) & (y > b + 0.3) & (y < d - 0.3)).any())
            for a, b, c, d in boxes
        )


def test_a_strip_is_free_up_to_the_first_point_in_it() -> None:
    view = View(np.array([[2.0, 0.1], [1.0, 0.5], [-1.0, 0.0]]), np.zeros(1))
    assert view.reach(0.0, 0.2) == pytest.approx([2.0])
    assert view.reach(0.0, 0.6) == pytest.approx([1.0])
    assert view.reach(90.0 * DEG, 0.2) == pytest.approx([np.inf])
    assert view.reach([0.0, np.pi], 0.2) == pytest.approx([2.0, 1.0])


def test_an_empty_view_is_free_everywhere() -> None:
    view = View.of(np.full(3, np.inf), [-1.0, 0.0, 1.0], (0.0, 0.0, 0.0))
    assert np.isinf(view.reach(0.0, 1.0)).all()
    assert view.gap == np.inf


def test_points_are_seen_from_the_robot_and_not_from_the_laser() -> None:
    view = View.of([1.0, 1.0], [0.0, 0.01], (0.2, 0.0, 90.0 * DEG))
    assert view.points[0] == pytest.approx([0.2, 1.0])


def test_dust_is_overlooked_and_a_table_leg_is_not() -> None:
    bearings = np.linspace(-0.1, 0.1, 11)
    dust = np.full(11, 3.0)
    dust[5] = 0.5
    leg = np.full(11, 3.0)
    leg[5:7] = 0.5
    assert View.of(dust, bearings, np.zeros(3)).gap > 2.9
    assert View.of(leg, bearings, np.zeros(3)).gap == pytest.approx(0.5)


def test_ways_are_not_looked_for_along_the_edge_of_the_view() -> None:
    bearings = np.linspace(-135.0 * DEG, 135.0 * DEG, 271)
    seen = View.of(np.ones(271), bearings, np.zeros(3)).bearings
    assert seen.min() > -115.0 * DEG
    assert seen.max() < 115.0 * DEG
    all_round = View.of(np.ones(360), np.linspace(-np.pi, np.pi, 360), np.zeros(3)).bearings
    assert seen.max() < all_round.max()


def test_a_door_is_seen_from_abreast() -> None:
    world = draw(
        """
        ##########
        #........#
        #........#
        #........#
        ###..#####
        #........#
        #........#
        ##########
        """,
        resolution=0.5,
    )
    view = view_of(simulation_in(world, pose=(2.0, 1.0, 90.0 * DEG)))
    assert view.is_door(0.0, 0.25).all()
    assert not view.is_door(40.0 * DEG, 0.25).any()


def test_an_open_hall_has_no_doors() -> None:
    view = view_of(simulation_in())
    assert not view.is_door(view.bearings, 0.25).any()


def test_the_robot_turns_first_when_the_way_is_behind() -> None:
    simulation = simulation_in(ROOM, pose=(5.0, 1.75, 0.0))
    wanderer = Wanderer(WanderParams(), np.random.default_rng(0))
    linear, angular = wanderer.step(view_of(simulation), np.zeros(3), 0.1)
    assert linear < 0.05
    assert abs(angular) > 0.5


def test_where_it_was_lately_it_does_not_go_again() -> None:
    simulation = simulation_in(ROOM, pose=(3.0, 1.75, 0.0))
    wanderer = Wanderer(WanderParams(), np.random.default_rng(0))
    visited = itertools.product(np.arange(3.2, 5.5, 0.4), np.arange(0.8, 3.0, 0.4))
    wanderer.state.visits = np.array([[x, y, 0.0] for x, y in visited])
    wanderer.step(view_of(simulation), simulation.pose, 0.1)
    assert wanderer.state.aim is not None
    assert wanderer.state.aim[0] < 3.0


def test_it_leaves_a_dead_end() -> None:
    world = draw(
        """
        ##################
        #................#
        #................#
        #.########.......#
        #.########.......#
        #.########.......#
        #.########.......#
        #.################
        #.################
        ##################
        """,
        resolution=0.8,
    )
    simulation = simulation_in(world, pose=(1.2, 1.3, -90.0 * DEG))
    walk = Walk(simulation, 60.0, seed=1)
    assert walk.bumps == 0
    assert walk.way[:, 1].max() > 5.6


@pytest.mark.parametrize(
    ("floor", "start", "squares", "rooms"),
    [(square_hall, (4.0, 5.0, 0.0), 50, 0), (office_floor, (20.0, 7.1, 0.0), 30, 2)],
)
def test_it_gets_about_without_touching_anything(
    floor: Callable[[], OccupancyMap], start: tuple[float, float, float], squares: int, rooms: int
) -> None:
    simulation = Simulation(Walls.of(floor()), RobotParams(), 0, np.random.default_rng(4))
    simulation.put(np.array(start))
    walk = Walk(simulation, 150.0, seed=4)
    assert walk.bumps == 0
    assert walk.longest_stay < 15.0
    assert walk.square_metres >= squares
    assert walk.rooms >= rooms


def test_in_the_open_it_keeps_a_quarter_metre_clear() -> None:
    simulation = simulation_in(square_hall(), pose=(4.0, 5.0, 0.0), params=EXACT)
    walk = Walk(simulation, 60.0, seed=2)
    gaps = [simulation.walls.nearest(x, y, 1.0)[0] - 0.165 for x, y in walk.way]
    assert min(gaps) > 0.2
