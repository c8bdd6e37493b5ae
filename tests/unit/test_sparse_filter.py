"""Particles: the way that a corridor with doors allows is the one that they keep to."""

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.mapper.odometry_sense import OdometryStep
from pilotage.mapper.particle_filter import ParticleFilter, ParticleParams
from slam_world import ROUND, building, points_at, way_along

BEARINGS = np.linspace(-np.pi, np.pi, 11, endpoint=False)
WAY = way_along(ROUND)[:40]
PARAMS = ParticleParams(particles=150, scans=50)


def seen(pose: np.ndarray) -> np.ndarray:
    return points_at(building(), pose, bearings=BEARINGS)


def followed(odom: np.ndarray, back: float = 0.0, seed: int = 0) -> ParticleFilter:
    """Drive WAY; odometry (n, 3) says something else."""
    filtered = ParticleFilter(PARAMS, np.random.default_rng(seed))
    filtered.begin(seen(WAY[0]), np.zeros(3))
    for before, after, pose in zip(odom[:-1], odom[1:], WAY[1:], strict=True):
        step = OdometryStep(se2.between(before, after), back, 0.5)
        filtered.take(step, seen(pose))
    return filtered


def way_errors(filtered: ParticleFilter) -> np.ndarray:
    way, _ = filtered.way(len(WAY))
    off = se2.between(way[0], way)[:, :2] - se2.between(WAY[0], WAY)[:, :2]
    distances: np.ndarray = np.hypot(off[:, 0], off[:, 1])
    return distances


def erring(turn: float, seed: int = 3) -> np.ndarray:
    """Odometry of WAY whose heading errs by `turn` rad a step."""
    steps = se2.between(WAY[:-1], WAY[1:])
    steps[:, 2] += turn * np.random.default_rng(seed).standard_normal(len(steps))
    poses = [WAY[0]]
    for step in steps:
        poses.append(se2.compose(poses[-1], step))
    return np.array(poses)


def test_a_way_that_odometry_knows_is_kept_to() -> None:
    assert way_errors(followed(WAY)).max() < 0.15


def test_odometry_that_errs_is_corrected() -> None:
    odom = erring(0.05)
    off = np.hypot(*(odom[:, :2] - WAY[:, :2]).T)
    assert way_errors(followed(odom)).max() < 0.5 * off.max()


def test_it_is_learnt_what_odometry_is_worth() -> None:
    assert followed(WAY).scale[1] < followed(erring(0.08)).scale[1]


def test_a_way_back_told_as_one_ahead_is_seen_through() -> None:
    """Scans show the robot go back the last steps, odometry counts them as ahead."""
    truth = np.vstack([WAY[:21], WAY[12:20][::-1]])
    steps = se2.between(truth[:-1], truth[1:])
    steps[20:, 0] *= -1.0
    filtered = ParticleFilter(PARAMS, np.random.default_rng(0))
    filtered.begin(seen(truth[0]), np.zeros(3))
    for number, (step, pose) in enumerate(zip(steps, truth[1:], strict=True)):
        filtered.take(OdometryStep(step, 0.2 if number == 20 else 0.01, 0.02), seen(pose))
    _, senses = filtered.way(len(truth))
    assert np.all(senses[10:20] == 1.0)
    assert np.all(senses[-6:] == -1.0)


def test_the_same_dice_give_the_same_way() -> None:
    one, _ = followed(erring(0.05), seed=7).way(10)
    two, _ = followed(erring(0.05), seed=7).way(10)
    assert np.array_equal(one, two)


def test_only_so_many_points_of_a_scan_are_weighed() -> None:
    filtered = ParticleFilter(PARAMS, np.random.default_rng(0))
    many = points_at(building(), WAY[0])
    filtered.begin(many, np.zeros(3))
    filtered.take(OdometryStep(np.array([0.1, 0.0, 0.0]), 0.0, 1.0), many)
    assert len(many) > PARAMS.points
    way, _ = filtered.way(2)
    assert way[1] == pytest.approx([0.1, 0.0, 0.0], abs=0.1)


def test_scans_longer_ago_are_forgotten() -> None:
    filtered = ParticleFilter(ParticleParams(particles=5, scans=4), np.random.default_rng(0))
    for number in range(9):
        filtered.begin(np.ones((2, 2)), np.array([float(number), 0.0, 0.0]))
    way, _ = filtered.way(4)
    assert way[:, 0].tolist() == [5.0, 6.0, 7.0, 8.0]


def test_a_scan_of_nothing_is_odometrys() -> None:
    filtered = ParticleFilter(PARAMS, np.random.default_rng(0))
    nothing = np.empty((0, 2))
    filtered.begin(nothing, np.zeros(3))
    filtered.take(OdometryStep(np.array([0.2, 0.0, 0.1]), 0.0, 1.0), nothing)
    before, now = filtered.spread(2)
    assert se2.between(before, now).mean(axis=0) == pytest.approx([0.2, 0.0, 0.1], abs=0.02)
