"""Laws of the simulated world that hold whatever one does."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.laser_view import View
from pilotage.robot.motion_command import Straight, Turn
from pilotage.robot.simulator.drive import DriveParams, Wheels, accelerated
from pilotage.robot.simulator.range_sensors import LaserParams, Surroundings, scan
from pilotage.robot.simulator.simulation import RobotParams
from pilotage.robot.simulator.walls import Walls
from pilotage.robot.wander import Wanderer, WanderParams
from pilotage.robot.watchdog import Limits
from robot_world import ROOM, simulation_in

speeds = st.tuples(st.floats(-2.0, 2.0), st.floats(-5.0, 5.0))
seeds = st.integers(0, 2**32 - 1)
RADIUS = RobotParams().drive.radius


def random_walls(rng: np.random.Generator) -> Walls:
    cells = np.where(rng.random((12, 15)) < 0.15, 100, 0).astype(np.int8)
    return Walls.of(OccupancyMap(GridGeometry(12, 15, 0.4, (-1.0, 2.0, 0.3)), cells))


@given(st.lists(speeds, min_size=1, max_size=8), seeds)
def test_the_body_is_never_in_a_wall(commands: list[tuple[float, float]], seed: int) -> None:
    simulation = simulation_in(ROOM, params=RobotParams(), seed=seed)
    for linear, angular in commands:
        simulation.want(linear, angular)
        for _ in range(60):
            simulation.tick()
            x, y, theta = simulation.pose
            assert simulation.walls.nearest(x, y, 1.0)[0] >= RADIUS
            assert -np.pi <= theta < np.pi


@given(st.lists(speeds, min_size=1, max_size=5), seeds)
def test_nothing_moves_faster_than_it_can(commands: list[tuple[float, float]], seed: int) -> None:
    simulation = simulation_in(ROOM, params=RobotParams(), seed=seed)
    drive = simulation.params.drive
    for linear, angular in commands:
        simulation.want(linear, angular)
        for _ in range(20):
            before = simulation.pose
            simulation.tick()
            moved = se2.between(before, simulation.pose)
            assert np.hypot(*moved[:2]) <= drive.max_linear * 0.01 + 1e-9
            assert abs(simulation.wheels.angular) <= drive.max_angular


@given(speeds, speeds, st.floats(0.001, 0.2))
def test_speeds_change_no_more_than_the_drive_allows(
    present: tuple[float, float], wanted: tuple[float, float], dt: float
) -> None:
    drive = DriveParams(max_linear=2.0, max_angular=5.0)
    wheels = accelerated(Wheels(*present), wanted, drive, dt)
    assert abs(wheels.linear - present[0]) <= drive.braking * dt + 1e-9
    assert abs(wheels.angular - present[1]) <= 4.0 * drive.braking * dt + 1e-9


@given(speeds, speeds, st.floats(0.001, 0.2))
def test_limits_let_no_speed_pass_that_is_too_high(
    present: tuple[float, float], wanted: tuple[float, float], dt: float
) -> None:
    limits = Limits(linear=0.5, angular=1.0, acceleration=1.0, angular_acceleration=2.0)
    for given_speed, limit in zip(limits.applied(wanted, present, dt), (0.5, 1.0), strict=True):
        assert abs(given_speed) <= limit + 1e-9
    again = limits.applied(wanted, limits.applied(wanted, present, dt), dt)
    assert abs(again[0]) >= abs(limits.applied(wanted, present, dt)[0]) - 1e-9 or (
        wanted[0] * present[0] < 0.0
    )


@given(seeds)
def test_distance_to_the_walls_agrees_with_the_beams(seed: int) -> None:
    rng = np.random.default_rng(seed)
    walls = random_walls(rng)
    x, y = walls.geometry.centres_of([[rng.integers(1, 11), rng.integers(1, 14)]])[0]
    distance, direction = walls.nearest(x, y, 10.0)
    beams = walls.ranges((x, y, 0.0), np.linspace(-np.pi, np.pi, 90), 10.0)
    assert distance <= beams.min() + 1e-9
    if 0.0 < distance < np.inf:
        (hit,) = walls.ranges((x, y, direction), [0.0], 10.0)
        assert hit >= distance - 1e-9


@given(seeds, st.floats(0.01, 1.0))
def test_a_disc_overlaps_exactly_when_the_nearest_wall_is_nearer_than_its_rim(
    seed: int, radius: float
) -> None:
    rng = np.random.default_rng(seed)
    walls = random_walls(rng)
    x, y = rng.uniform((-1.5, 2.0), (5.0, 7.0))
    assert walls.overlaps(x, y, radius) == (walls.nearest(x, y, 2.0)[0] < radius)


@given(seeds)
def test_places_are_connected_free_ground(seed: int) -> None:
    walls = random_walls(np.random.default_rng(seed))
    for x, y in walls.places(0.15):
        assert not walls.overlaps(x, y, 0.15)


@given(seeds)
def test_a_scan_is_never_longer_than_the_laser_reaches(seed: int) -> None:
    rng = np.random.default_rng(seed)
    around = Surroundings(random_walls(rng), np.array([[1.0, 3.0, 0.2]]))
    laser = LaserParams(share_too_short=0.1, share_without_return=0.1)
    ranges = scan(around, rng.uniform((-1.0, 2.0, -3.0), (5.0, 7.0, 3.0)), laser, rng)
    finite = ranges[np.isfinite(ranges)]
    assert not np.isnan(ranges).any()
    assert ((finite >= np.float32(laser.range_min)) & (finite <= laser.range_max)).all()


@given(st.floats(-100.0, 100.0), st.floats(0.01, 10.0), seeds)
def test_motions_never_ask_for_more_than_their_speed(
    amount: float, speed: float, seed: int
) -> None:
    pose = np.random.default_rng(seed).uniform(-3.0, 3.0, 3)
    for motion in (Straight(amount, speed), Turn(amount, speed)):
        linear, angular = motion.advance(pose, 0.0).speeds
        assert abs(linear) <= max(speed, 0.02)
        assert abs(angular) <= max(speed, 0.02)


@given(seeds, st.floats(0.3, 6.0))
def test_wandering_drives_nowhere_that_is_not_free(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    bearings = np.linspace(-2.3, 2.3, 91)
    ranges = np.repeat(scale * rng.uniform(0.1, 1.0, 13), 7)
    view = View.of(ranges, bearings, np.zeros(3))
    wanderer = Wanderer(WanderParams(), rng)
    for _ in range(10):
        linear, angular = wanderer.step(view, np.zeros(3), 0.1)
        assert 0.0 <= linear <= WanderParams().speed
        assert abs(angular) <= WanderParams().turn_rate
        if linear > 0.0:
            assert view.reach(0.0, RADIUS)[0] > RADIUS
