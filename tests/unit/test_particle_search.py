"""The search for particles that a measurement speaks for, from coarse to fine."""

from dataclasses import replace

import numpy as np
import pytest

from localizer_world import START, error, flat, look
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.localizer.last_measurement import Novelty
from pilotage.localizer.measurement import Measurement, scan_measurement
from pilotage.localizer.modes import is_within
from pilotage.localizer.particle_belief import particle_belief
from pilotage.localizer.particle_evidence import EvidenceParams, ParticleEvidence
from pilotage.localizer.particle_search import ParticleSearch, SearchParams
from pilotage.localizer.particle_start import free_space
from pilotage.localizer.pose_grid import PoseGridParams

WORLD = flat()
PLAIN = EvidenceParams(visibility=None, tables=PoseGridParams(0.1, 36))
FEW = SearchParams(candidates=60_000, kept=20_000)


def search(world: OccupancyMap, params: EvidenceParams = PLAIN) -> ParticleSearch:
    return ParticleSearch(free_space(world), ParticleEvidence(world, params), FEW)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(3)


def test_finds_lie_where_the_robot_is(rng: np.random.Generator) -> None:
    finds = search(WORLD).anywhere(look(WORLD, START), Novelty(), rng)
    assert finds.weights.sum() == pytest.approx(1.0)
    assert finds.poses.shape == (FEW.kept, 3)
    # Of one tempered scan; the flat has 1,500 places as small as that.
    assert finds.weights[is_within(finds.poses, np.array(START))].sum() > 0.15
    (best,), _ = particle_belief(finds.poses, finds.weights, WORLD.geometry).heaviest(1)
    assert error(best, START)[0] < 0.15


def test_finds_are_free_places(rng: np.random.Generator) -> None:
    finds = search(WORLD).anywhere(look(WORLD, START), Novelty(), rng)
    assert free_space(WORLD).holds(finds.poses).all()


def test_a_share_of_the_effort_finds_a_share_of_the_poses(rng: np.random.Generator) -> None:
    finds = search(WORLD).anywhere(look(WORLD, START), Novelty(), rng, share=0.1)
    assert len(finds.poses) == FEW.kept // 10
    assert finds.drawn(7, rng).shape == (7, 3)


def test_the_mean_likelihood_is_that_of_all_free_space(rng: np.random.Generator) -> None:
    """The steps from blurred to sharp must cancel out, or kidnappings are judged wrongly."""
    weak = Novelty(0.2, 1.0)
    seen = look(WORLD, START)
    evidence = ParticleEvidence(WORLD, PLAIN)
    logs = evidence.weigh(free_space(WORLD).draw(1_000_000, rng), seen, weak).logs
    expected = np.log(np.exp(logs - logs.max()).mean()) + logs.max()
    means = [search(WORLD).anywhere(seen, weak, rng).log_mean for _ in range(4)]
    assert np.mean(means) == pytest.approx(expected, abs=0.15)


def test_like_rooms_are_found_alike(rng: np.random.Generator) -> None:
    """Four rooms that nothing tells apart: a sharp look alone would favour some by chance."""
    room = np.zeros((60, 40), np.int8)
    room[[0, -1]], room[:, [0, -1]] = 100, 100
    room[20:26, 30:], room[50:, 1:8] = 100, 100
    rooms = np.concatenate([room] * 4, axis=1)
    world = OccupancyMap(GridGeometry(60, 160, 0.1), rooms)
    bearings = np.linspace(-np.pi, np.pi, 90, endpoint=False)
    ranges = cast_scan(world, [1.5, 3.7, 0.8], bearings, 12.0).astype(np.float32)
    angles = float(bearings[0]), float(bearings[1] - bearings[0])
    seen = scan_measurement(ranges, angles, np.zeros(3), 60, 12.0)
    finds = search(world).anywhere(seen, Novelty(), rng)
    masses = [
        finds.weights[is_within(finds.poses, np.array([1.5 + 4.0 * n, 3.7, 0.8]))].sum()
        for n in range(4)
    ]
    assert sum(masses) > 0.8
    assert masses == pytest.approx([sum(masses) / 4.0] * 4, rel=0.6)


def test_without_a_scan_there_is_nothing_to_blur(rng: np.random.Generator) -> None:
    seen = replace(Measurement(), compass=(1.0, 0.3))
    finds = search(WORLD).anywhere(seen, Novelty(), rng)
    headings = finds.poses[:, 2]
    assert finds.weights @ np.cos(headings - 1.0) > 0.8
