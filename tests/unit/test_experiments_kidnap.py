"""The kidnapping of the paper's example 1, in a small room."""

import json
from typing import Any

import numpy as np
import pytest

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.experiments import kidnapping
from pilotage.experiments.kidnap import recoveries, recovery_step
from pilotage.experiments.kidnap_plots import course_figure, event_figure
from pilotage.experiments.kidnapping import ALGORITHMS, STEPS_AFTER, STEPS_BEFORE, Kidnapping, Seen
from pilotage.experiments.ranger_localizer import Place, RangerModel, survey
from pilotage.experiments.ranger_robot import RobotParams

CELL, CELLS = 0.10, 40
MODEL = RangerModel(robot=RobotParams(range_max=6.0))


@pytest.fixture(scope="module")
def place() -> Place:
    """A square room of 4 m."""
    cells = np.full((CELLS + 2, CELLS + 2), 100, np.int8)
    cells[1:-1, 1:-1] = 0
    world = OccupancyMap(GridGeometry(*cells.shape, CELL, (-CELL, -CELL, 0.0)), cells)
    return survey(world, MODEL)


@pytest.fixture(scope="module")
def carried_off(place: Place) -> list[Kidnapping]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kidnapping, "CARRIED_AT_LEAST", 1.2)
        patch.setattr(kidnapping, "CLEAR", 0.6)
        return [kidnapping.kidnap(place, MODEL, np.random.default_rng(seed)) for seed in (1, 2)]


def figures(events: list[Kidnapping], algorithm: str) -> dict[str, Any]:
    return recoveries(events, algorithm)


def seen(*right: bool) -> Seen:
    """What an algorithm says that is right in some of the steps, all after the kidnapping."""
    steps = np.array([True] * STEPS_BEFORE + list(right))
    error = np.where(steps, 0.1, 3.0)
    return Seen(steps.astype(float), error, np.zeros(len(steps)), np.zeros((len(steps), 3)))


def test_the_robot_is_carried_and_does_not_walk_there(carried_off: list[Kidnapping]) -> None:
    for event in carried_off:
        jumps = np.hypot(*np.diff(event.path[:, :2], axis=0).T)
        assert jumps[STEPS_BEFORE - 1] > 1.0
        assert np.delete(jumps, STEPS_BEFORE - 1).max() < 0.2


def test_the_belief_is_certain_before(carried_off: list[Kidnapping]) -> None:
    for event in carried_off:
        for name in ALGORITHMS:
            assert event.seen[name].share[:STEPS_BEFORE].min() > 0.9


def test_m1_never_recovers_and_m2_does(carried_off: list[Kidnapping]) -> None:
    m1, m2 = (figures(carried_off, name) for name in ALGORITHMS)
    assert m1["recovered"] == 0.0
    assert m1["recovery_steps"] == [None, None]
    assert m2["recovered"] == 1.0
    assert m2["recovery_steps_median"] < 10


def test_the_figures_can_be_written_as_json(carried_off: list[Kidnapping]) -> None:
    for name in ALGORITHMS:
        json.dumps(recoveries(carried_off, name), allow_nan=False)


def test_a_belief_that_died_out_has_no_error() -> None:
    dead = seen(*[False] * STEPS_AFTER)
    dead.error_m[-1] = np.nan
    report = figures([Kidnapping(np.zeros((3, 3)), {"m1": dead})], "m1")
    assert report["error_at_the_end_m"] == [None]
    assert report["belief_died_out"] == 1.0
    assert report["recovered"] == 0.0


@pytest.mark.parametrize(
    ("right", "step"),
    [
        ((True, True, True), 1),
        ((False, True, True), 2),
        ((True, False, True), 3),
        ((False, False, False), None),
        ((True, True, False), None),
    ],
)
def test_recovery_counts_from_when_the_place_stays_right(
    monkeypatch: pytest.MonkeyPatch, right: tuple[bool, ...], step: int | None
) -> None:
    monkeypatch.setattr("pilotage.experiments.kidnap.STEPS_AFTER", len(right))
    assert recovery_step(seen(*right)) == step


def test_the_course_is_drawn_of_every_run_and_in_the_middle(
    carried_off: list[Kidnapping],
) -> None:
    figure = course_figure(carried_off)
    shares, _ = figure.axes
    assert shares.get_title() == "2 kidnappings: every run, and the median"
    assert len(shares.lines) == 2 * (len(carried_off) + 1) + 1


def test_the_course_of_a_belief_that_died_out_is_drawn_without_a_warning() -> None:
    event = Kidnapping(np.zeros((3, 3)), {name: seen(*[False] * 2) for name in ALGORITHMS})
    event.seen["m1"].error_m[-1] = np.nan
    course_figure([event])


def test_one_kidnapping_is_drawn_in_its_hall(place: Place, carried_off: list[Kidnapping]) -> None:
    figure = event_figure(place, carried_off[0])
    assert [axes.get_title() for axes in figure.axes] == ["M1 (eq. 3)", "M2 (eq. 8)"]
