"""The plain twin expects of looks what the product expects."""

import itertools

import numpy as np
import pytest

from pilotage.bench import planner_cases
from pilotage.bench.buildings import office_block
from pilotage.bench.entry import Size, Stopwatch
from pilotage.bench.reference_active import PlainLooks, plain_merged
from pilotage.core.grid import OccupancyMap
from pilotage.localizer.particle_start import free_space
from pilotage.planner.active_localization import ActiveLocalization, ActiveParams
from pilotage.planner.hypotheses import merged
from pilotage.planner.situation import Hypotheses

PARAMS = ActiveParams(candidates=12, observations=8)


def small_office() -> OccupancyMap:
    return office_block(9.0)


def anywhere(world: OccupancyMap, count: int) -> Hypotheses:
    rng = np.random.default_rng(count)
    weights = rng.random(count)
    return Hypotheses(free_space(world).draw(count, rng), weights / weights.sum())


@pytest.mark.parametrize("count", [1, 2, 60])
def test_both_expect_the_same_of_a_look(count: int) -> None:
    world = small_office()
    active, plain = ActiveLocalization(world, PARAMS), PlainLooks(world, PARAMS.sight, 8)
    belief = anywhere(world, count)
    points = np.random.default_rng(1).uniform(-4.0, 4.0, (6, 2))
    expected = [plain.gain(belief, point) for point in points]
    assert active.gains(belief, points) == pytest.approx(expected, abs=1e-3)
    assert max(expected) == pytest.approx(0.0, abs=1e-9) if count == 1 else max(expected) > 0.0


@pytest.mark.parametrize("most", [5, 400])
def test_both_tell_the_same_places_apart(most: int) -> None:
    belief = anywhere(small_office(), 300)
    ours, plain = merged(belief, most), plain_merged(belief, most)
    assert np.sort(plain.weights)[::-1] == pytest.approx(ours.weights)


def test_the_entries_tell_how_much_was_weighed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planner_cases, "office_floor", small_office)
    monkeypatch.setattr(planner_cases, "OFFICE_CORRIDOR", (1.5, 7.0, 5.0))
    monkeypatch.setattr(planner_cases, "SAMPLES", 40)
    ticks = itertools.count(0.0, 0.001)
    gains, decision = planner_cases.planner_cases(Stopwatch(lambda: next(ticks)))
    assert gains.size == decision.size == Size(40, 36, "particles")
    assert gains.extra == {"candidates": 30.0, "observations": 32.0}
    assert gains.cpu_ms == pytest.approx(1.0)
    assert gains.reference_fraction == decision.reference_fraction == 0.1
    assert gains.reference_cpu_ms == pytest.approx(10.0)
    # Merging is measured as a whole, weighing in part.
    assert decision.reference_cpu_ms == pytest.approx(11.0)
