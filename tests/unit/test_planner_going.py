"""Going to places of small simulated worlds, and of the office."""

from dataclasses import replace

import numpy as np
import pytest

from pilotage.core.angles import wrap
from pilotage.core.grid import OCCUPIED, GridGeometry, OccupancyMap
from pilotage.planner.going import Going
from pilotage.planner.ground import Ground
from pilotage.planner.mission import Target
from pilotage.planner.path_finding import NoPathError
from pilotage.planner.path_params import FollowerParams
from pilotage.robot.simulator.floor_canvas import Box
from pilotage.robot.simulator.floor_plans import office_floor
from pilotage.robot.simulator.simulation import RobotParams, Simulation
from pilotage.robot.simulator.walls import Walls
from planner_ride import Ride, echoes_of, situation_of

Pose = tuple[float, float, float]
LEFT_DOOR: Box = (2.9, 0.9, 3.2, 2.1)
RIGHT_DOOR: Box = (2.9, 3.9, 3.2, 5.1)


def two_doors(width: float = 0.8) -> OccupancyMap:
    """Two rooms, 6 m x 6 m together, and doors at (3, 1.5) and (3, 4.5); cells of 5 cm."""
    cells = np.zeros((120, 120), np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    cells[:, 59:61] = OCCUPIED
    half = round(width / 0.1)
    for row in (30, 90):
        cells[row - half : row + half, 59:61] = 0
    return OccupancyMap(GridGeometry(120, 120, 0.05), cells)


class Errand:
    """A robot sent somewhere in a world that may differ from its map."""

    def __init__(
        self, world: OccupancyMap, start: Pose, goal: Pose, unmapped: tuple[Box, ...] = ()
    ) -> None:
        walls = Walls.of(world, unmapped)
        simulation = Simulation(walls, RobotParams(), 0, np.random.default_rng(7))
        simulation.put(np.array(start))
        self.ride = Ride(simulation)
        self.goal = np.array(goal)
        self.going = Going(Ground.of(world), Target(self.goal), situation_of(self.ride))

    def step(self) -> None:
        self.ride.drive(self.going.step(situation_of(self.ride)))

    def run(self, seconds: float = 120.0) -> None:
        end = self.ride.seconds + seconds
        while self.ride.seconds < end and self.going.state in ("going", "waiting"):
            self.step()

    @property
    def is_there(self) -> bool:
        """Whether it truly stands at its goal, 0.10 m and 5 degrees."""
        x, y, theta = self.ride.simulation.pose - self.goal
        return bool(np.hypot(x, y) < 0.10 and abs(wrap(float(theta))) < np.deg2rad(5.0))


def test_it_arrives_through_a_narrow_door() -> None:
    errand = Errand(two_doors(), (1.0, 1.0, 3.0), (5.0, 2.0, 1.0))
    assert errand.going.distance_left == pytest.approx(4.3, abs=0.5)
    errand.run()
    assert errand.going.has_arrived
    assert errand.going.failure is None
    assert errand.is_there
    assert not errand.ride.touched
    assert errand.going.step(situation_of(errand.ride)) == (0.0, 0.0)


def test_the_path_left_becomes_shorter() -> None:
    errand = Errand(two_doors(), (1.0, 1.0, 0.0), (5.0, 2.0, 0.0))
    before = errand.going.distance_left
    errand.run(seconds=5.0)
    assert errand.going.distance_left < before - 1.0
    assert errand.going.path[-1] == pytest.approx([5.0, 2.0])


@pytest.mark.parametrize(
    ("goal", "reason"),
    [((9.0, 1.0, 0.0), "off the map"), ((3.0, 3.0, 0.0), "wall"), ((5.0, 0.2, 0.0), "too close")],
)
def test_it_does_not_set_out_for_what_is_no_place_to_be(goal: Pose, reason: str) -> None:
    with pytest.raises(NoPathError, match=reason):
        Errand(two_doors(), (1.0, 1.0, 0.0), goal)


def test_a_door_that_something_unmapped_closes_is_gone_round() -> None:
    errand = Errand(two_doors(), (1.0, 1.5, 0.0), (5.0, 1.5, 0.0), (LEFT_DOOR,))
    errand.run()
    assert errand.going.has_arrived
    assert errand.is_there
    assert not errand.ride.touched
    assert max(pose[1] for pose in errand.ride.way) > 4.2


def test_with_both_doors_closed_it_waits_and_then_gives_up_and_says_why() -> None:
    errand = Errand(two_doors(), (1.0, 1.5, 0.0), (5.0, 1.5, 0.0), (LEFT_DOOR, RIGHT_DOOR))
    errand.run(seconds=200.0)
    assert errand.going.state == "failed"
    assert "the map lacks" in str(errand.going.failure)
    assert "no other way" in str(errand.going.failure)
    assert not errand.ride.touched


def test_a_door_that_opens_while_it_waits_is_gone_through() -> None:
    errand = Errand(two_doors(), (1.0, 1.5, 0.0), (5.0, 1.5, 0.0), (LEFT_DOOR, RIGHT_DOOR))
    while errand.going.state == "going":
        errand.step()
    assert errand.going.state == "waiting"
    errand.ride.simulation.walls = Walls.of(two_doors())
    errand.run()
    assert errand.is_there
    assert not errand.ride.touched


def test_a_box_in_the_room_is_gone_round() -> None:
    errand = Errand(two_doors(), (1.0, 4.5, 0.0), (5.0, 4.5, 3.0), ((1.6, 4.2, 2.0, 4.9),))
    errand.run()
    assert errand.is_there
    assert not errand.ride.touched


def test_a_goal_on_which_something_stands_is_given_up() -> None:
    errand = Errand(two_doors(), (4.0, 4.5, 0.0), (5.0, 2.0, 0.0), ((4.7, 1.7, 5.3, 2.3),))
    errand.run()
    assert errand.going.state == "failed"
    assert not errand.ride.touched


def test_a_pose_that_jumps_makes_it_find_another_path() -> None:
    errand = Errand(two_doors(), (1.0, 1.5, 0.0), (5.0, 1.5, 0.0))
    errand.run(seconds=2.0)
    errand.going.obstacles.look(
        np.zeros(3), situation_of(errand.ride).view, errand.ride.seconds, 0.0
    )
    errand.ride.simulation.put(np.array([1.0, 4.5, 0.0]))
    errand.step()
    assert errand.going.path[0] == pytest.approx([1.0, 4.5], abs=0.1)
    errand.run()
    assert errand.is_there
    assert not errand.ride.touched


def test_a_pose_that_jumps_to_where_no_way_leads_on_ends_it() -> None:
    errand = Errand(two_doors(), (1.0, 1.5, 0.0), (5.0, 1.5, 0.0))
    belief = situation_of(errand.ride)
    lost = belief.belief.moved((99.0, 0.0, 0.0))
    errand.going.step(replace(belief, belief=lost))
    assert "off the map" in str(errand.going.failure)


def test_unknown_ground_is_minded_though_no_laser_shows_it() -> None:
    world = two_doors()
    world.cells[40:80, 20:40] = -1
    errand = Errand(world, (1.5, 1.0, 0.0), (1.5, 5.0, 0.0))
    errand.run()
    assert errand.is_there
    assert not errand.ride.touched


def test_a_robot_against_a_wall_leaves_it_and_one_is_not_sent_there() -> None:
    errand = Errand(two_doors(), (0.25, 1.0, np.pi), (2.0, 5.0, 0.0))
    errand.run()
    assert errand.is_there
    assert not errand.ride.touched


def test_a_robot_that_has_only_sonars_gets_round_a_box_as_well() -> None:
    errand = Errand(two_doors(), (1.0, 4.5, 0.0), (5.0, 4.5, 3.0), ((1.6, 4.2, 2.0, 4.9),))
    while errand.going.state == "going" and errand.ride.seconds < 120.0:
        seen = replace(situation_of(errand.ride), view=echoes_of(errand.ride.simulation))
        errand.ride.drive(errand.going.step(seen))
    assert errand.is_there
    assert not errand.ride.touched


def test_a_wide_robot_does_not_try_a_narrow_door() -> None:
    situation = situation_of(Errand(two_doors(), (1.0, 1.0, 0.0), (2.0, 1.0, 0.0)).ride)
    with pytest.raises(NoPathError, match="no way that the robot fits through"):
        Going(
            Ground.of(two_doors()),
            Target(np.array([5.0, 2.0, 0.0])),
            situation,
            FollowerParams(radius=0.4),
        )


@pytest.mark.parametrize("goal", [(16.4, 2.6, 2.0), (30.9, 5.6, -1.2)])
def test_in_the_office_it_gets_where_it_is_sent(goal: Pose) -> None:
    errand = Errand(office_floor(), (26.0, 7.1, 0.5), goal)
    errand.run(seconds=300.0)
    assert errand.is_there
    assert not errand.ride.touched
