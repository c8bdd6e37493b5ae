"""Going about at random and along walls."""

import numpy as np
import pytest
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.core.laser_view import View
from pilotage.experiments.trial_policies import FixedPolicy, RandomPolicy
from pilotage.experiments.trial_steering import Body, along, polar, towards
from pilotage.experiments.trial_world import TrialWorld
from pilotage.planner.situation import Policy
from trial_floors import DOORS, NOOK, ROOM_WITH_PILLAR, TWINS, Deaf, driven, trial_world

BEARINGS = np.linspace(-1.9, 1.9, 61)
START = (1.2, 2.8, 0.3)


def policy(name: str, seed: int = 0) -> Policy:
    return RandomPolicy(np.random.default_rng(seed)) if name == "random" else FixedPolicy()


def unheard(floor: OccupancyMap, sight: float = 12.0) -> TrialWorld:
    """A floor on which nobody tells the robot where it is."""
    return trial_world(floor, sight, Deaf)


def view_of(*points: tuple[float, float]) -> View:
    return View(np.array(points, float).reshape(-1, 2), BEARINGS)


def wall(x: float, half_width: float = 2.0) -> list[tuple[float, float]]:
    """A wall across the way, x m ahead."""
    return [(x, float(y)) for y in np.arange(-half_width, half_width, 0.02)]


def squares(poses: NDArray[np.float64]) -> int:
    """How many squares of 0.8 m x 0.8 m were come through."""
    return len({(int(x / 0.8), int(y / 0.8)) for x, y, _ in poses})


@pytest.mark.parametrize("name", ["random", "fixed"])
@pytest.mark.parametrize(("floor", "y"), [(TWINS, 3.6), (DOORS, 3.6), (ROOM_WITH_PILLAR, 1.2)])
def test_nothing_is_ever_touched(name: str, floor: OccupancyMap, y: float) -> None:
    ride, _ = driven(unheard(floor, sight=4.0), policy(name), (1.2, y, 0.3), 30.0)
    assert ride.contacts == 0
    assert ride.travel_m > 4.0


@pytest.mark.parametrize("name", ["random", "fixed"])
def test_a_nook_is_left(name: str) -> None:
    ride, poses = driven(unheard(NOOK), policy(name), (2.0, 0.62, -1.0), 25.0)
    assert ride.contacts == 0
    assert poses[:, 1].max() > 1.8


def test_the_same_seed_goes_the_same_way() -> None:
    world = unheard(DOORS)
    ways = [driven(world, policy("random", seed), START, 10.0)[1] for seed in (4, 4, 5)]
    assert np.array_equal(ways[0], ways[1])
    assert not np.array_equal(ways[0], ways[2])


def test_the_wall_follower_goes_the_same_way_every_time() -> None:
    world = unheard(DOORS)
    ways = [driven(world, policy("fixed"), START, 10.0)[1] for _ in range(2)]
    assert np.array_equal(ways[0], ways[1])


def test_the_wall_follower_goes_round_all_rooms() -> None:
    _, poses = driven(unheard(DOORS), policy("fixed"), START, 90.0)
    x, y = poses[:, :2].T
    assert ((x > 4.2) & (y > 2.4)).any()
    assert (y < 1.6).any()


def test_the_wall_follower_keeps_its_distance() -> None:
    world = unheard(ROOM_WITH_PILLAR)
    ride, poses = driven(world, policy("fixed"), (1.0, 0.75, 0.0), 8.0)
    gaps = [world.walls.nearest(x, y, 2.0)[0] for x, y, _ in poses]
    assert ride.travel_m > 2.0
    assert np.ptp(gaps[20:]) < 0.15


def test_the_wall_follower_does_not_go_round_a_pillar_for_ever() -> None:
    start = (3.0, 2.3, -np.pi / 2.0)
    _, poses = driven(unheard(ROOM_WITH_PILLAR), policy("fixed"), start, 40.0)
    away = np.hypot(poses[:, 0] - 3.0, poses[:, 1] - 1.8)
    assert away[:80].max() < 1.2
    assert away.max() > 1.5


def test_chance_gets_about() -> None:
    _, poses = driven(unheard(ROOM_WITH_PILLAR), policy("random"), START, 40.0)
    assert squares(poses) > 8


def test_what_is_aside_is_turned_to_on_the_spot() -> None:
    linear, angular = towards(view_of(), (2.0, 1.5), Body())
    assert linear == 0.0
    assert angular > 0.5


def test_it_slows_down_before_a_wall_and_stands_at_it() -> None:
    speeds = [along(view_of(*wall(x)), 0.0, Body())[0] for x in (3.0, 0.5, 0.24)]
    assert speeds[0] == pytest.approx(Body().speed)
    assert 0.0 < speeds[1] < speeds[0]
    assert speeds[2] == 0.0


def test_it_steers_past_what_stands_in_the_way() -> None:
    view = view_of(*[(0.6, float(y)) for y in np.arange(-0.3, 0.05, 0.02)])
    _, angular = towards(view, (2.0, 0.0), Body())
    assert angular > 0.2


def test_a_way_ends_short_of_the_wall() -> None:
    assert Body().way(view_of(*wall(2.0)), 0.0)[0] == pytest.approx(2.0 - Body().half_width)


def test_in_a_tight_place_the_gap_is_given_up() -> None:
    alley = [(float(x), side) for x in np.arange(-2.0, 2.0, 0.02) for side in (-0.23, 0.23)]
    assert Body().fitting(view_of(*alley), 0.5).gap < Body().gap
    assert Body().fitting(view_of(), 0.5) == Body()


def test_an_aim_is_seen_from_where_the_robot_stands() -> None:
    distance, bearing = polar(np.array([1.0, 3.0]), np.array([1.0, 1.0, 0.0]))
    assert distance == pytest.approx(2.0)
    assert bearing == pytest.approx(np.pi / 2.0)
