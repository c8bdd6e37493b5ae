"""The parts of the particle filter: where particles start, move, stay and are drawn anew."""

import numpy as np
import pytest

from drawing import draw
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.motion import OdometryNoise
from pilotage.localizer.markov_grid import MotionSpread
from pilotage.localizer.particle_belief import particle_belief
from pilotage.localizer.particle_field import BeamModel, particle_field
from pilotage.localizer.particle_filter import ParticleFilter
from pilotage.localizer.particle_motion import predict, standard_deviations
from pilotage.localizer.particle_recovery import FitMemory, RecoveryParams, share_after
from pilotage.localizer.particle_resampling import (
    KldParams,
    bins_of,
    effective_number,
    needed_particles,
)
from pilotage.localizer.particle_start import free_space

ROOMS = draw(
    """
    #########
    #...#...#
    #...#???#
    #########
    """,
    resolution=0.5,
    origin=(2.0, -1.0, 0.6),
)
KLD = KldParams(least=100, most=1000)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1)


def particles() -> ParticleFilter:
    return ParticleFilter(free_space(ROOMS), MotionSpread(), KLD)


def test_an_unknown_start_covers_free_space_evenly(rng: np.random.Generator) -> None:
    poses = free_space(ROOMS).draw(90_000, rng)
    cells = ROOMS.geometry.cells_of(poses[:, :2])
    counts = np.zeros(ROOMS.geometry.shape)
    np.add.at(counts, tuple(cells.T), 1)
    assert (counts[~ROOMS.is_free] == 0).all()
    assert counts[ROOMS.is_free] == pytest.approx(10_000, rel=0.05)
    quarters, _ = np.histogram(poses[:, 2], 4, (-np.pi, np.pi))
    assert quarters == pytest.approx(22_500, rel=0.05)


def test_a_known_start_stays_in_its_free_surroundings(rng: np.random.Generator) -> None:
    pose = se2.compose(ROOMS.geometry.origin, [1.2, 1.2, -2.0])
    poses = free_space(ROOMS).draw_around(pose, np.diag([0.04, 0.04, 0.01]), 2000, rng)
    assert free_space(ROOMS).holds(poses).all()
    assert poses.shape == (2000, 3)
    off = se2.between(pose, poses)
    assert np.abs(off.mean(axis=0)).max() < 0.15
    assert off[:, 2].std() == pytest.approx(0.1, rel=0.1)


def test_a_start_in_a_wall_or_without_a_covariance_is_refused(rng: np.random.Generator) -> None:
    space, narrow = free_space(ROOMS), np.diag([1e-4, 1e-4, 1e-4])
    with pytest.raises(ValueError, match="not in the map's free space"):
        space.draw_around([-50.0, 0.0, 0.0], narrow, 10, rng)
    with pytest.raises(ValueError, match="symmetric"):
        space.draw_around([3.0, 0.0, 0.0], -narrow, 10, rng)


def test_a_map_without_free_space_is_refused() -> None:
    solid = draw("##")
    with pytest.raises(ValueError, match="no free cell"):
        free_space(solid)
    with pytest.raises(ValueError, match="no free cell"):
        particle_field(solid, BeamModel())


@pytest.mark.parametrize("increment", [(1.0, 0.2, 0.5), (0.0, 0.0, -2.0), (-0.5, 0.0, 0.0)])
def test_particles_spread_as_the_markov_grid_does(
    increment: tuple[float, float, float], rng: np.random.Generator
) -> None:
    spread, step = MotionSpread(0.1, 0.05, 0.02, 0.03), np.array(increment)
    start = np.tile([1.0, 2.0, 3.0], (40_000, 1))
    off = se2.between(start, predict(start, step, spread, rng))
    assert off.mean(axis=0) == pytest.approx(step, abs=3e-3)
    assert off.std(axis=0) == pytest.approx(standard_deviations(step, spread), rel=0.03)


def test_two_short_ways_spread_as_one_long_way() -> None:
    spread = MotionSpread()
    short, long = np.array([0.5, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])
    twice = standard_deviations(short, spread) * np.sqrt(2.0)
    assert twice == pytest.approx(standard_deviations(long, spread))


def test_standing_still_moves_nothing(rng: np.random.Generator) -> None:
    poses = free_space(ROOMS).draw(50, rng)
    for model in (MotionSpread(), OdometryNoise()):
        assert predict(poses, np.zeros(3), model, rng) == pytest.approx(poses)


def test_weights_sum_to_one_however_unlikely_everything_is(rng: np.random.Generator) -> None:
    some = particles()
    some.set_uniform(500, rng)
    for logs in (rng.uniform(-1e4, 0.0, 500), np.full(500, -1e6), np.zeros(500)):
        some.weigh(logs)
        assert some.weights.sum() == pytest.approx(1.0)
        assert (some.weights >= 0.0).all()


def test_resampling_keeps_the_belief_and_evens_the_weights(rng: np.random.Generator) -> None:
    some = particles()
    some.set_uniform(1000, rng)
    some.weigh(-5.0 * np.abs(some.poses[:, 2]))
    expected, effective = some.weights @ some.poses[:, :2], effective_number(some.weights)
    assert some.is_depleted
    some.resample(rng)
    assert some.weights.sum() == pytest.approx(1.0)
    assert some.weights @ some.poses[:, :2] == pytest.approx(expected, abs=0.05)
    assert effective_number(some.weights) > 1.5 * effective


def test_a_place_of_little_mass_does_not_die_out_by_chance(rng: np.random.Generator) -> None:
    some = particles()
    some.poses = np.concatenate([np.zeros((500, 3)), np.full((500, 3), 2.0)])
    some.weights = np.concatenate([np.full(500, 0.99 / 500), np.full(500, 0.01 / 500)])
    masses = []
    for _ in range(200):
        some.resample(rng)
        masses.append(float(some.weights[some.poses[:, 0] == 2.0].sum()))
    assert min(masses) > 0.0
    assert np.mean(masses) == pytest.approx(0.01, rel=0.5)


def test_even_particles_are_not_drawn_anew(rng: np.random.Generator) -> None:
    some = particles()
    some.set_uniform(1000, rng)
    assert not some.is_depleted
    some.set_uniform(1001, rng)
    assert some.is_depleted, "more than are to be kept"


def test_a_sharp_belief_needs_few_particles_and_a_wide_one_many(rng: np.random.Generator) -> None:
    params = KldParams(least=50, most=100_000, epsilon=0.05, quantile=2.33)
    sharp = rng.normal(0.0, 0.02, (5000, 3))
    wide = rng.uniform(-3.0, 3.0, (5000, 3))
    even = np.full(5000, 1.0 / 5000)
    few = needed_particles(sharp, even, params, rng)
    many = needed_particles(wide, even, params, rng)
    assert 50 <= few < 400
    # 5,000 poses meet 3,200 of 12 x 12 x 36 bins; Fox's bound for so many is 33,600.
    assert 31_000 < many < 36_000
    assert needed_particles(wide, even, KLD, rng) == KLD.most


@pytest.mark.parametrize(
    "limits", [{"least": 0}, {"least": 5, "most": 4}, {"epsilon": 0.0}, {"bin_turn": -1.0}]
)
def test_impossible_limits_are_refused(limits: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=r"range|positive"):
        KldParams(**limits)  # type: ignore[arg-type]  # wrong on purpose


def test_the_effective_number_is_that_of_even_weights() -> None:
    assert effective_number(np.full(40, 1 / 40)) == pytest.approx(40.0)
    assert effective_number(np.array([1.0, 0.0, 0.0])) == pytest.approx(1.0)


def test_bins_wrap_where_the_heading_does() -> None:
    poses = np.array([[0.1, 0.1, np.pi - 0.01], [0.1, 0.1, -np.pi], [0.1, 0.6, -np.pi]])
    one, other, elsewhere = bins_of(poses, 0.5, np.deg2rad(10.0))
    turned = bins_of(se2.compose(poses, [0.0, 0.0, np.deg2rad(10.0)]), 0.5, np.deg2rad(10.0))
    assert one != other
    assert turned[0] == bins_of(np.vstack([poses[1], poses]), 0.5, np.deg2rad(10.0))[0]
    assert other != elsewhere
    assert min(one, other, elsewhere) >= 0


def test_what_is_remembered_comes_back_with_the_rest_anywhere(rng: np.random.Generator) -> None:
    some = particles()
    pose = se2.compose(ROOMS.geometry.origin, [1.25, 1.25, 1.0])
    some.set_states(pose[None], np.array([0.7]), rng)
    share = np.mean(np.all(np.isclose(some.poses, pose), axis=1))
    assert share == pytest.approx(0.7, abs=0.01)
    assert free_space(ROOMS).holds(some.poses).all()
    some.set_states(np.array([[99.0, 0.0, 0.0]]), np.array([1.0]), rng)
    assert free_space(ROOMS).holds(some.poses).all(), "nothing of it lies on this map"


def test_newcomers_get_their_share(rng: np.random.Generator) -> None:
    some = particles()
    some.set_uniform(100, rng)
    some.admit(np.zeros((30, 3)), 0.25)
    assert some.weights.sum() == pytest.approx(1.0)
    assert some.weights[100:].sum() == pytest.approx(0.25)


def test_a_belief_shows_where_particles_lie_densely() -> None:
    geometry = GridGeometry(40, 40, 0.05)
    poses = np.array([[0.52, 0.55, 3.13], [0.56, 0.57, 3.12], [1.5, 1.5, 0.0]])
    belief = particle_belief(poses, np.array([0.3, 0.4, 0.3]), geometry)
    place, mass = belief.heaviest(1)
    assert mass == pytest.approx([0.7])
    assert place[0] == pytest.approx(np.average(poses[:2], axis=0, weights=[3, 4]))
    assert belief.marginal().sum() == pytest.approx(1.0)
    assert belief.marginal()[5, 5] == pytest.approx(0.7)
    assert belief.entropy() == pytest.approx(-0.7 * np.log2(0.7) - 0.3 * np.log2(0.3))


def test_a_pose_in_a_wall_or_off_the_map_is_as_unlikely_as_can_be() -> None:
    field = particle_field(ROOMS, BeamModel(outlier=0.01))
    inside = se2.compose(ROOMS.geometry.origin, [[1.2, 1.2, 0.0], [0.1, 0.1, 0.0], [9.0, 9, 0]])
    ends = np.array([[-0.95, 0.0], [0.95, 0.0]])
    fits = field.mean_likelihoods(inside, ends)
    assert fits[0] > 0.1
    assert fits[1:] == pytest.approx(0.01, rel=1e-6)


def test_beams_beyond_reach_are_not_used() -> None:
    field = particle_field(ROOMS, BeamModel(reach=1.0))
    assert len(field.used(np.array([[0.5, 0.0], [3.0, 0.0], [0.0, -1.0]]))) == 2
    pose = se2.compose(ROOMS.geometry.origin, [1.2, 1.2, 0.0])[None]
    assert field.log_likelihoods(pose, np.array([[50.0, 0.0]])) == pytest.approx([0.0])


def test_particles_are_drawn_anew_when_measurements_stop_fitting() -> None:
    memory = FitMemory(RecoveryParams(slow=0.05, fast=0.5))
    assert memory.share == 0.0
    for _ in range(20):
        memory.note(0.8, 60)
    assert memory.share == pytest.approx(0.0, abs=1e-9)
    memory.note(0.2, 60)
    assert memory.share > 0.2
    memory.forget()
    assert memory.share == 0.0


def test_one_bad_sighting_is_no_reason_to_look_elsewhere() -> None:
    memory = FitMemory(RecoveryParams(slow=0.05, fast=0.5))
    for _ in range(20):
        memory.note(0.8, 1)
    memory.note(0.05, 1)
    assert memory.share < 0.06


def test_better_fits_than_usual_draw_nothing_anew() -> None:
    memory = FitMemory(RecoveryParams())
    memory.note(0.3, 60)
    memory.note(0.9, 60)
    assert memory.share == 0.0


def test_no_recovery_without_a_long_memory() -> None:
    memory = FitMemory(RecoveryParams(slow=0.0, fast=0.0))
    memory.note(0.9, 60)
    memory.note(0.1, 60)
    assert memory.share == 0.0
    with pytest.raises(ValueError, match="slow"):
        RecoveryParams(slow=0.5, fast=0.1)


def test_bayes_decides_whether_the_robot_is_elsewhere() -> None:
    assert share_after(0.5, -3.0, -3.0) == pytest.approx(0.5)
    assert share_after(0.5, -1.0, -3.0) == pytest.approx(1.0 / (1.0 + np.exp(-2.0)))
    assert share_after(0.1, -3.0, -3.0) == pytest.approx(0.1)
    assert share_after(0.5, -5000.0, 0.0) == 0.0
    assert share_after(0.5, 0.0, -5000.0) == pytest.approx(1.0)
    assert share_after(0.0, 0.0, -50.0) == 0.0
    assert share_after(1.0, -50.0, 0.0) == 1.0


def test_weighing_tells_how_well_the_belief_foretold_the_measurement(
    rng: np.random.Generator,
) -> None:
    some = particles()
    some.set_uniform(4, rng)
    assert some.weigh(np.full(4, -2.5)) == pytest.approx(-2.5)
    halves = np.log([1.0, 1.0, 1e-12, 1e-12])
    assert some.weigh(halves) == pytest.approx(np.log(0.5))
    assert some.weigh(halves[::-1].copy()) < -20.0


def test_a_symmetric_world_stays_symmetric() -> None:
    cells = np.zeros((42, 42), np.int8)
    cells[[0, -1]], cells[:, [0, -1]] = 100, 100
    hall = OccupancyMap(GridGeometry(42, 42, 0.1), cells)
    field = particle_field(hall, BeamModel())
    ends = np.array([[1.5, 0.0], [0.0, 0.7], [-2.7, 0.0]])
    pose = np.array([2.63, 1.31, 0.4])
    turns = [np.array([4.2 - pose[1], pose[0], 0.4 + np.pi / 2.0]), pose]
    both = field.log_likelihoods(np.array(turns), ends)
    assert both[0] == pytest.approx(both[1], abs=0.15)
