"""Following paths in small simulated rooms."""

import numpy as np
import pytest

from pilotage.core.angles import wrap
from pilotage.core.grid import OCCUPIED, GridGeometry, OccupancyMap
from pilotage.core.laser_view import View
from pilotage.planner.path_follower import FollowerStep, PathFollower
from pilotage.planner.path_params import FollowerParams, Tolerances
from pilotage.planner.path_steering import Aim, aim_on, steered_past
from pilotage.planner.path_track import Track
from pilotage.robot.simulator.floor_canvas import Box
from pilotage.robot.simulator.simulation import RobotParams, Simulation
from pilotage.robot.simulator.walls import Walls
from planner_ride import Ride, view_of

OPEN = View(np.zeros((0, 2)), np.zeros(1))
DEG = np.pi / 180.0


def hall() -> OccupancyMap:
    """6 m x 4 m in cells of 5 cm."""
    cells = np.zeros((80, 120), np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    return OccupancyMap(GridGeometry(80, 120, 0.05), cells)


def ride_in(*boxes: Box, start: tuple[float, float, float] = (1.0, 2.0, 0.0)) -> Ride:
    walls = Walls.of(hall(), boxes)
    simulation = Simulation(walls, RobotParams(), 0, np.random.default_rng(2))
    simulation.put(np.array(start))
    return Ride(simulation)


def follow(ride: Ride, follower: PathFollower, seconds: float = 60.0) -> FollowerStep:
    end = ride.seconds + seconds
    step = FollowerStep((0.0, 0.0), "following")
    while ride.seconds < end and step.state == "following":
        step = follower.step(ride.pose(), view_of(ride.simulation), 0.1)
        ride.drive(step.speeds)
    return step


def distance_to(ride: Ride, goal: tuple[float, float]) -> float:
    return float(np.hypot(*(ride.simulation.pose[:2] - np.array(goal))))


def test_a_follower_without_a_path_has_arrived() -> None:
    assert PathFollower().step(np.zeros(3), OPEN, 0.1) == FollowerStep((0.0, 0.0), "arrived")


def test_it_drives_straight_to_a_goal_ahead_and_gains_speed_slowly() -> None:
    follower = PathFollower()
    follower.begin([[0.0, 0.0], [3.0, 0.0]])
    first = follower.step(np.zeros(3), OPEN, 0.1)
    assert first.state == "following"
    assert first.speeds == pytest.approx((0.08, 0.0))
    for _ in range(10):
        last = follower.step(np.zeros(3), OPEN, 0.1)
    assert last.speeds == pytest.approx((0.5, 0.0))


def test_it_turns_on_the_spot_to_a_path_that_leads_back() -> None:
    follower = PathFollower()
    follower.begin([[0.0, 0.0], [-3.0, 0.5]])
    linear, angular = follower.step(np.zeros(3), OPEN, 0.1).speeds
    assert linear == 0.0
    assert angular == pytest.approx(follower.params.max_angular)


def test_it_goes_slower_near_things_in_bends_and_at_its_goal() -> None:
    def speed_after(path: list[list[float]], view: View) -> float:
        follower = PathFollower()
        follower.begin(path)
        return max(follower.step(np.zeros(3), view, 0.1).speeds[0] for _ in range(20))

    straight = [[0.0, 0.0], [3.0, 0.0]]
    beside = View(np.array([[0.0, 0.25]]), np.zeros(1))
    assert speed_after(straight, OPEN) == pytest.approx(0.5)
    assert speed_after(straight, beside) < 0.3
    assert speed_after([[0.0, 0.0], [0.2, 0.1], [0.3, 0.9]], OPEN) < 0.4
    assert speed_after([[0.0, 0.0], [0.1, 0.0]], OPEN) < 0.35


@pytest.mark.parametrize("heading", [0.0, 120.0 * DEG, -170.0 * DEG])
def test_it_arrives_within_its_tolerances(heading: float) -> None:
    ride, follower = ride_in(), PathFollower()
    follower.begin([[1.0, 2.0], [3.0, 3.0], [5.0, 1.0]], heading)
    assert follow(ride, follower).state == "arrived"
    assert distance_to(ride, (5.0, 1.0)) < 0.10
    assert abs(wrap(float(ride.simulation.pose[2]) - heading)) < 5.0 * DEG
    assert not ride.touched
    assert ride.seconds < 25.0


def test_a_goal_so_near_needs_only_a_turn() -> None:
    ride, follower = ride_in(), PathFollower()
    follower.begin([[1.0, 2.0], [1.01, 2.0]], 90.0 * DEG, Tolerances(0.1, 3.0 * DEG))
    assert follow(ride, follower).state == "arrived"
    assert ride.metres < 0.1
    assert abs(float(ride.simulation.pose[2]) - 90.0 * DEG) < 4.0 * DEG


def test_it_keeps_to_its_path_in_bends() -> None:
    ride, follower = ride_in(), PathFollower()
    follower.begin([[1.0, 2.0], [3.0, 2.0], [3.0, 3.3], [5.0, 3.3]])
    follow(ride, follower)
    track = Track(np.array([[1.0, 2.0], [3.0, 2.0], [3.0, 3.3], [5.0, 3.3]]))
    off = [track.nearest(pose[:2], 0.0, 9.0)[1] for pose in ride.way]
    assert max(off) < 0.15


def test_it_stops_before_what_stands_in_its_way_and_says_so() -> None:
    ride, follower = ride_in((3.0, 0.0, 3.2, 4.0)), PathFollower()
    follower.begin([[1.0, 2.0], [5.0, 2.0]])
    step = follow(ride, follower)
    assert step.state == "blocked"
    assert "in its way" in step.reason
    assert step.speeds == (0.0, 0.0)
    assert not ride.touched
    assert 2.5 < ride.simulation.pose[0] < 3.0 - 0.165


def test_it_goes_on_when_the_way_is_free_again() -> None:
    ride, follower = ride_in((3.0, 0.0, 3.2, 4.0)), PathFollower()
    follower.begin([[1.0, 2.0], [5.0, 2.0]])
    waiting = FollowerStep((0.0, 0.0), "following")
    while not waiting.reason:
        waiting = follower.step(ride.pose(), view_of(ride.simulation), 0.1)
        ride.drive(waiting.speeds)
    assert waiting.state == "following"
    ride.simulation.walls = Walls.of(hall())
    assert follow(ride, follower).state == "arrived"
    assert distance_to(ride, (5.0, 2.0)) < 0.10


def test_it_steers_past_a_thing_beside_its_path() -> None:
    ride, follower = ride_in((2.9, 2.05, 3.1, 2.25)), PathFollower()
    follower.begin([[1.0, 2.0], [5.0, 2.0]])
    assert follow(ride, follower).state == "arrived"
    assert not ride.touched


def test_it_does_not_go_far_from_its_path_to_get_past_a_thing() -> None:
    ride, follower = ride_in((3.0, 1.0, 3.2, 3.0)), PathFollower()
    follower.begin([[1.0, 2.0], [5.0, 2.0]])
    assert follow(ride, follower).state == "blocked"
    assert max(abs(pose[1] - 2.0) for pose in ride.way) < 0.5
    assert not ride.touched


def test_a_robot_that_does_not_get_on_gives_up() -> None:
    follower = PathFollower()
    follower.begin([[0.0, 0.0], [5.0, 0.0]])
    steps = [follower.step(np.zeros(3), OPEN, 0.1) for _ in range(100)]
    assert steps[10].state == "following"
    assert steps[-1].state == "blocked"
    assert "get on" in steps[-1].reason


def test_a_pose_that_shifts_at_the_end_makes_it_approach_again() -> None:
    follower = PathFollower()
    follower.begin([[0.0, 0.0], [1.0, 0.0]], 90.0 * DEG)
    assert follower.step([0.99, 0.0, 0.0], OPEN, 0.1).speeds[0] == 0.0
    assert follower.step([0.8, 0.0, 0.0], OPEN, 0.1).speeds[0] > 0.0


def test_the_farthest_point_steered_for_is_one_that_cuts_no_bend() -> None:
    straight = Track(np.array([[0.0, 0.0], [5.0, 0.0]]))
    aim = aim_on(straight, 1.0, (1.0, 0.0, 0.0))
    assert (aim.bearing, aim.distance) == pytest.approx((0.0, 1.0))
    bend = Track(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 3.0]]))
    assert aim_on(bend, 0.7, (0.7, 0.0, 0.0)).distance < 0.5


def test_what_blocks_every_bearing_leaves_the_aim_alone() -> None:
    wall = np.stack([np.full(81, 0.4), np.linspace(-2.0, 2.0, 81)], axis=1)
    aim = Aim(0.0, 1.0)
    assert steered_past(View(wall, np.zeros(1)), aim, 0.0, FollowerParams()) == aim


def test_it_does_not_change_its_mind_about_the_side_to_pass_on() -> None:
    post, aim = View(np.array([[0.6, 0.0]]), np.zeros(1)), Aim(0.0, 0.6)
    left = steered_past(post, aim, 0.5, FollowerParams())
    right = steered_past(post, aim, -0.5, FollowerParams())
    assert left.bearing > 0.2
    assert right.bearing < -0.2
