"""MORCS-2 goes straight or turns, and errs as the thesis says that it did."""

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.experiments.sonar_drive import (
    MOUNTS,
    PAUSE,
    RIM,
    TICK,
    Morcs2,
    Order,
    SonarDrive,
    drive,
)
from pilotage.experiments.sonar_errors import pose_errors, turn_errors
from pilotage.experiments.sonar_halls import complex_hall, narrow_opening, simple_hall
from pilotage.experiments.sonar_maps import reckon
from pilotage.experiments.wall_segments import distance_to_walls

BOX = np.array(
    [[-2.0, -2.0, 6.0, -2.0], [6.0, -2.0, 6.0, 2.0], [6.0, 2.0, -2.0, 2.0], [-2.0, 2.0, -2.0, -2.0]]
)
HALLS = [simple_hall(), complex_hall(), narrow_opening()]


def driven(*orders: Order, seed: int = 0) -> SonarDrive:
    return drive(BOX, np.zeros(3), orders, Morcs2(), np.random.default_rng(seed))


def test_the_ring_sits_on_the_rim_and_looks_outwards() -> None:
    assert np.hypot(MOUNTS[:, 0], MOUNTS[:, 1]) == pytest.approx(np.full(8, RIM))
    assert np.arctan2(MOUNTS[:, 1], MOUNTS[:, 0]) == pytest.approx(MOUNTS[:, 2])
    assert MOUNTS[0] == pytest.approx([0.0, RIM, np.pi / 2.0])


def test_an_order_takes_its_time_and_then_the_robot_rests() -> None:
    run = driven(Order(way=1.0))
    assert len(run.orders) == pytest.approx((1.0 / 0.2 + PAUSE) / TICK, abs=1)
    assert (run.orders * TICK).sum(axis=0) == pytest.approx([1.0, 0.0])
    assert run.orders[-1].tolist() == [0.0, 0.0]


def test_backwards_is_a_negative_way() -> None:
    run = driven(Order(way=-1.0))
    assert run.truth[-1, 0] == pytest.approx(-1.0, abs=0.06)


def test_it_goes_straight_or_turns_and_never_both() -> None:
    run = driven(Order(way=0.5), Order(turn=1.0), Order(way=0.5))
    assert not np.any((run.orders[:, 0] != 0.0) & (run.orders[:, 1] != 0.0))
    steps = np.hypot(*np.diff(run.truth[:, :2], axis=0).T)
    assert np.all(steps[run.is_turning] < 0.003)
    assert steps[~run.is_turning].sum() == pytest.approx(1.0, abs=0.05)


def test_odometry_counts_ways_too_long_by_as_much_as_in_the_thesis() -> None:
    counted = [driven(Order(way=3.64), seed=seed) for seed in range(10)]
    off = [run.counted[:, 0].sum() - run.truth[-1, 0] for run in counted]
    assert np.mean(off) == pytest.approx(0.176, abs=0.03)


def test_odometry_counts_turns_off_by_as_much_as_in_the_thesis() -> None:
    quarters = (Order(turn=np.pi / 2.0), Order(way=0.2), Order(turn=-np.pi / 2.0))
    runs = [driven(*quarters, seed=seed) for seed in range(10)]
    errors = [turn_errors(run, reckon(run, Morcs2()).plain) for run in runs]
    left, right = np.rad2deg(np.mean([np.concatenate(pair) for pair in errors], axis=0))
    assert left == pytest.approx(5.25, abs=1.0)
    assert right == pytest.approx(7.67, abs=1.0)


def test_the_compass_does_not_know_where_the_map_points() -> None:
    yaws = [driven(Order(way=0.2), seed=seed).yaws[0] for seed in range(5)]
    assert np.ptp(yaws) > 1.0


def test_every_round_has_eight_ranges_at_its_tick() -> None:
    run = driven(Order(way=1.0))
    assert run.ranges.shape == (len(run.rounds), 8)
    left = run.ranges[np.isfinite(run.ranges[:, 0]), 0]
    assert np.median(left) == pytest.approx(2.0 - RIM, abs=0.02)


def test_the_same_seed_drives_the_same_way() -> None:
    one, other = driven(Order(way=0.5), seed=3), driven(Order(way=0.5), seed=3)
    assert np.array_equal(one.truth, other.truth)
    assert np.array_equal(one.ranges, other.ranges)


def test_a_robot_without_errors_is_found_where_it_is() -> None:
    run = driven(Order(way=1.0), Order(turn=1.0), Order(turn=-0.5))
    assert pose_errors(run, run.truth)["pose_error_m"] == 0.0
    assert pose_errors(run, run.truth)["rotation_error_rad"] == 0.0
    shifted = se2.compose((0.3, 0.4, 0.0), run.truth)
    assert pose_errors(run, shifted)["pose_error_m"] == pytest.approx(0.5)
    assert pose_errors(run, shifted)["rotation_error_rad"] == pytest.approx(0.0, abs=1e-12)


def test_without_turns_the_rotation_is_that_of_the_heading() -> None:
    run = driven(Order(way=0.5))
    turned = run.truth + np.array([0.0, 0.0, 0.1])
    assert pose_errors(run, turned)["rotation_error_rad"] == pytest.approx(0.1)
    assert "left_turn_error_rad" not in pose_errors(run, turned)


@pytest.mark.parametrize("hall", HALLS, ids=["simple", "complex", "opening"])
@pytest.mark.parametrize("seed", range(3))
def test_the_robot_never_touches_a_wall(hall: object, seed: int) -> None:
    assert isinstance(hall, type(HALLS[0]))
    run = drive(hall.walls, hall.start, hall.orders, Morcs2(), np.random.default_rng(seed))
    assert distance_to_walls(hall.walls, run.truth[:, :2]).min() > RIM + 0.1


@pytest.mark.parametrize("hall", HALLS, ids=["simple", "complex", "opening"])
def test_walls_close_around_the_robot(hall: object) -> None:
    """Every end of a wall is shared by another wall, so that no sound escapes."""
    assert isinstance(hall, type(HALLS[0]))
    ends = hall.walls.reshape(-1, 2).round(6)
    _, counts = np.unique(ends, axis=0, return_counts=True)
    assert np.all(counts == 2)
