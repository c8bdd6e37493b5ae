"""The filter of lines against its plain twin, and what must hold whatever is seen."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from ekf_world import MAPPED, NICHED, ROOM, erring, lines_between, seen_from, walls_around
from pilotage.bench.reference_line_ekf import plain_match
from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry
from pilotage.core.lines import Lines
from pilotage.localizer.ekf_belief import GaussianBelief
from pilotage.localizer.ekf_walls import Walls
from pilotage.localizer.line_ekf import GATE, GaussianPose, LineEkfParams, track
from pilotage.localizer.line_ekf_kernels import Pieces, match_in_turn
from pilotage.localizer.line_ekf_update import Pairs, corrected

Array = NDArray[np.float64]
PARAMS = LineEkfParams()
seeds = st.integers(0, 2**31)


def pieces(lines: Lines) -> Pieces:
    return Pieces(lines.ends, lines.polar, lines.covariances)


def random_covariance(rng: np.random.Generator, scale: float = 0.2) -> Array:
    root = rng.normal(size=(3, 3)) * np.array([scale, scale, scale / 3.0])[:, None]
    return np.asarray(root @ root.T + np.diag([1e-4, 1e-4, 1e-5]))


def random_lines(rng: np.random.Generator, count: int) -> Lines:
    """Walls anywhere, some of them in line with each other."""
    begin = rng.uniform(-5.0, 5.0, (count, 2))
    turn = rng.choice([0.0, 0.5, 1.0, 1.5], count) * np.pi + rng.normal(0.0, 0.05, count)
    along = rng.uniform(0.5, 4.0, count)[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return lines_between(np.stack([begin, begin + along], axis=1), MAPPED)


def random_pose(rng: np.random.Generator) -> Array:
    return np.array([*rng.uniform(-3.0, 3.0, 2), rng.uniform(-np.pi, np.pi)])


@given(seeds, st.integers(0, 8), st.integers(0, 15))
@settings(max_examples=60, deadline=None)
def test_kernel_and_twin_match_the_same_walls(seed: int, few: int, many: int) -> None:
    rng = np.random.default_rng(seed)
    pose, covariance = random_pose(rng), random_covariance(rng)
    known = random_lines(rng, many)
    chosen = rng.integers(0, many, few) if many else np.empty(0, np.int64)
    seen = erring(known.chosen(chosen).moved(se2.inverse(pose)), np.diag([1e-3, 1e-2]), rng)
    what = pieces(seen), pieces(known), GATE
    partners, likelihood, at, spread = match_in_turn(pose, covariance, *what)
    plain = plain_match(pose, covariance, *what)
    assert partners.tolist() == plain[0]
    assert likelihood == pytest.approx(plain[1], abs=1e-6)
    assert at == pytest.approx(plain[2], abs=1e-8)
    assert spread == pytest.approx(plain[3], abs=1e-9)


@given(seeds)
@settings(max_examples=40, deadline=None)
def test_what_is_seen_never_makes_a_pose_less_certain(seed: int) -> None:
    rng = np.random.default_rng(seed)
    known = walls_around(NICHED)
    pose = np.array([*rng.uniform(1.0, 3.0, 2), rng.uniform(-np.pi, np.pi)])
    before = GaussianPose(rng.multivariate_normal(pose, np.eye(3) * 1e-2), random_covariance(rng))
    step = track(before, np.zeros(3), seen_from(pose, known, rng), known, PARAMS)
    after, predicted = step.belief.covariance, step.predicted.covariance
    assert after == pytest.approx(after.T, abs=0.0)
    assert np.linalg.eigvalsh(after)[0] > 0.0
    assert np.linalg.eigvalsh(predicted - after)[0] > -1e-9
    assert -np.pi <= step.belief.mean[2] < np.pi


@given(seeds, st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(-np.pi, np.pi)))
@settings(max_examples=40, deadline=None)
def test_where_the_map_lies_makes_no_difference(
    seed: int, where: tuple[float, float, float]
) -> None:
    """Also with the wrap of angles somewhere else, and the origin far from the walls."""
    rng = np.random.default_rng(seed)
    known, shift = walls_around(ROOM), np.array(where)
    pose = np.array([*rng.uniform(1.0, 4.0, 2), rng.uniform(-np.pi, np.pi)])
    seen = seen_from(pose, known, rng)
    there = Walls.of(known.lines.moved(shift))
    covariance = np.diag([0.01, 0.01, 0.003])
    here_after = track(GaussianPose(pose, covariance), np.zeros(3), seen, known, PARAMS)
    moved = GaussianPose(se2.compose(shift, pose), covariance)
    there_after = track(moved, np.zeros(3), seen, there, PARAMS)
    off = there_after.belief.mean - se2.compose(shift, here_after.belief.mean)
    off[2] = wrap(float(off[2]))
    assert off == pytest.approx(np.zeros(3), abs=1e-6)
    assert (there_after.pairs.lines == here_after.pairs.lines).all()


@given(seeds, st.integers(1, 6))
@settings(max_examples=30, deadline=None)
def test_pieces_of_one_wall_do_not_sharpen_the_wall(seed: int, count: int) -> None:
    """However many there are, the pose across it is no surer than the wall's place."""
    rng = np.random.default_rng(seed)
    wall = Walls.of(lines_between([[[-20.0, 0.0], [20.0, 0.0]]], MAPPED))
    begins = np.linspace(-6.0, 6.0, count)
    exact = lines_between([[[x, -1.0], [x + 1.5, -1.0]] for x in begins], np.eye(2) * 1e-12)
    seen = Walls.of(erring(exact, np.eye(2) * 1e-12, rng))
    pairs = Pairs(np.stack([np.arange(count), np.zeros(count, np.int64)], axis=1))
    _, after = corrected(np.array([0.0, 1.0, 0.0]), np.eye(3), (seen, wall), pairs)
    assert after[1, 1] > 0.9 * MAPPED[1, 1]
    assert after[2, 2] > 0.9 * MAPPED[0, 0]


@given(seeds, st.sampled_from([27, 125, 729, 5000]))
@settings(max_examples=30, deadline=None)
def test_samples_of_a_gaussian_have_its_mean_and_covariance(seed: int, most: int) -> None:
    rng = np.random.default_rng(seed)
    pose = GaussianPose(random_pose(rng), random_covariance(rng, 0.1))
    belief = GaussianBelief(pose, GridGeometry(100, 100, 0.1, (-5.0, -5.0, 0.0)))
    poses, weights = belief.heaviest(most)
    assert len(poses) <= most
    assert weights.sum() == pytest.approx(1.0)
    off = poses - pose.mean
    off[:, 2] = wrap(off[:, 2])
    assert weights @ off == pytest.approx(np.zeros(3), abs=1e-9)
    assert (off * weights[:, None]).T @ off == pytest.approx(pose.covariance, abs=1e-9)
