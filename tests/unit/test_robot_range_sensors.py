"""The simulated laser, sonar ring, compass, and the people they see."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from drawing import draw
from pilotage.core import se2
from pilotage.robot.simulator.people import People, ranges_to_discs
from pilotage.robot.simulator.range_sensors import (
    CompassParams,
    LaserParams,
    SonarParams,
    Surroundings,
    compass_yaw,
    scan,
    sonar_round,
)
from pilotage.robot.simulator.walls import Walls
from robot_world import EXACT, ROOM

WALLS = Walls.of(ROOM)
NOBODY = Surroundings(WALLS, np.empty((0, 3)))
CENTRE = (3.0, 1.75, 0.0)
FOUR_WAYS = replace(EXACT.laser, beams=4, field_of_view=1.5 * np.pi)
RNG = np.random.default_rng(3)


def test_laser_measures_the_room_from_right_behind_to_left_behind() -> None:
    ranges = scan(NOBODY, (3.0, 1.75, np.pi / 4.0), FOUR_WAYS, RNG)
    assert ranges == pytest.approx([1.25, 2.5, 1.25, 2.5])
    assert FOUR_WAYS.bearings == pytest.approx(np.deg2rad([-135, -45, 45, 135]))


def test_laser_sits_ahead_of_the_centre() -> None:
    ahead = replace(FOUR_WAYS, beams=3, field_of_view=np.pi, mount_x=0.5)
    assert scan(NOBODY, CENTRE, ahead, RNG) == pytest.approx([1.25, 2.0, 1.25])


def test_what_is_beyond_its_reach_returns_nothing() -> None:
    short_sighted = replace(FOUR_WAYS, beams=3, field_of_view=np.pi, range_max=2.0)
    assert scan(NOBODY, CENTRE, short_sighted, RNG).tolist() == [1.25, np.inf, 1.25]


def test_laser_noise_has_the_stated_deviation() -> None:
    noisy = replace(EXACT.laser, sigma=0.02)
    errors = np.concatenate(
        [scan(NOBODY, CENTRE, noisy, RNG) - scan(NOBODY, CENTRE, EXACT.laser, RNG)] * 20
    )
    assert errors.std() == pytest.approx(0.02, rel=0.15)


def test_shares_of_lost_and_of_short_beams_are_as_stated() -> None:
    dusty = replace(EXACT.laser, beams=10_000, share_without_return=0.1, share_too_short=0.2)
    true = scan(NOBODY, CENTRE, replace(EXACT.laser, beams=10_000), RNG)
    ranges = scan(NOBODY, CENTRE, dusty, RNG)
    assert np.isinf(ranges).mean() == pytest.approx(0.1, abs=0.02)
    assert (ranges < true - 0.001).mean() == pytest.approx(0.2, abs=0.02)
    assert not (np.isfinite(ranges) & (ranges > true + 0.001)).any()


def test_no_range_is_below_the_sensors_least() -> None:
    close = scan(NOBODY, (0.52, 1.75, np.pi), replace(EXACT.laser, range_min=0.05), RNG)
    assert close.min() == pytest.approx(0.05)


def test_a_person_hides_the_wall_behind() -> None:
    around = Surroundings(WALLS, np.array([[4.0, 1.75, 0.2]]))
    assert around.ranges(CENTRE, [0.0, np.pi], 10.0) == pytest.approx([0.8, 2.5])


def test_a_beam_that_just_misses_a_person_goes_on() -> None:
    disc = np.array([[2.0, 0.0, 0.5]])
    grazing = np.arcsin(0.25)
    origin = np.zeros(3)
    assert np.isfinite(ranges_to_discs(origin, np.array([grazing - 1e-6]), disc)).all()
    assert np.isinf(ranges_to_discs(origin, np.array([grazing + 1e-6, np.pi]), disc)).all()


def test_sonars_are_numbered_and_mounted_as_on_morcs_2() -> None:
    mounts = SonarParams().mounts(0.165)
    directions = [90, 44, 12, -12, -44, -90, -144, 144]
    assert np.rad2deg(mounts[:, 2]) == pytest.approx(directions)
    assert np.hypot(mounts[:, 0], mounts[:, 1]) == pytest.approx(np.full(8, 0.165))
    assert mounts[0, :2] == pytest.approx([0.0, 0.165])


def test_a_sonar_answers_with_the_nearest_thing_in_its_cone() -> None:
    world = draw("""
        ......
        ......
        ....#.
        ......
    """)
    around = Surroundings(Walls.of(world), np.empty((0, 3)))
    aside = se2.compose((0.5, 1.5, np.deg2rad(-12.0)), np.zeros(3))
    (reading,) = sonar_round(around, aside[None], EXACT.sonar, RNG)
    assert reading == pytest.approx(3.5, abs=0.05)


def test_a_wall_out_of_reach_gives_no_echo() -> None:
    (reading,) = sonar_round(NOBODY, [[0.6, 1.75, 0.0]], EXACT.sonar, RNG)
    assert reading == np.inf


def test_echoes_get_lost_as_often_as_stated() -> None:
    deaf = replace(EXACT.sonar, share_without_echo=0.25)
    rounds = sonar_round(NOBODY, np.tile(CENTRE, (2000, 1)), deaf, RNG)
    assert np.isinf(rounds).mean() == pytest.approx(0.25, abs=0.04)


def test_compass_is_wrong_by_two_degrees_and_wraps() -> None:
    yaws = np.array([compass_yaw(np.pi - 0.001, CompassParams(), RNG) for _ in range(2000)])
    errors = np.angle(np.exp(1j * (yaws - np.pi)))
    assert np.rad2deg(errors.std()) == pytest.approx(2.0, rel=0.1)
    assert (np.abs(yaws) <= np.pi).all()


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"beams": 1}, "beams must be 2 to"),
        ({"sigma": -0.1}, "sigma must not be negative"),
        ({"range_max": 0.0}, "range_max must be more than 0"),
        ({"share_too_short": 0.7, "share_without_return": 0.6}, "must be 1 at most"),
    ],
)
def test_a_laser_that_cannot_be_is_refused(wrong: dict[str, Any], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        LaserParams(**wrong)


def test_a_sonar_ring_without_sonars_and_a_perfect_compass_are_refused() -> None:
    with pytest.raises(ValueError, match="directions_deg"):
        SonarParams(directions_deg=())
    with pytest.raises(ValueError, match="sigma"):
        CompassParams(sigma=0.0)


def test_people_walk_about_and_never_through_walls() -> None:
    people = People(WALLS, 3, np.random.default_rng(5))
    begun = people.discs
    for _ in range(600):
        people.walk(np.array([0.8, 0.8, 0.0]), 0.1, RNG)
        assert not any(WALLS.overlaps(x, y, radius) for x, y, radius in people.discs)
    assert (np.hypot(*(people.discs - begun)[:, :2].T) > 0.2).any()


def test_people_let_the_robot_pass() -> None:
    people = People(WALLS, 2, np.random.default_rng(6))
    robot = np.array([3.0, 1.75, 0.0])
    people._poses[:] = [[1.5, 1.75, 0.0], [4.5, 1.75, np.pi]]
    nearest = np.inf
    for _ in range(600):
        people.walk(robot, 0.1, RNG)
        nearest = min(nearest, np.hypot(*(people.discs[:, :2] - robot[:2]).T).min())
    assert nearest > 0.6
