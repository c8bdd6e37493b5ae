"""The claims of the sonar experiments (Li 2008, chapter 5), on two runs each."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.experiments import narrow_opening, sonar_complex, sonar_simple
from pilotage.experiments.arc_twin import place_echoes_plainly
from pilotage.experiments.opening import place_by_kernel, share_blocked, width_of_opening
from pilotage.experiments.outcome import Outcome, Request
from pilotage.experiments.sonar_halls import MIDDLE, UPPER
from pilotage.experiments.sonar_maps import CROSSINGS, noise_of
from pilotage.experiments.sonar_report import with_spread

Conduct = Callable[[Request, Callable[[float], None]], Outcome]


def figures_of(conduct: Conduct, seed: int = 0) -> tuple[dict[str, Any], dict[str, Figure]]:
    shares: list[float] = []
    outcome = conduct(Request(runs=2, seed=seed), shares.append)
    assert sum(shares) == pytest.approx(1.0)
    return dict(outcome.report), dict(outcome.plots)


@pytest.fixture(scope="module")
def complex_runs() -> dict[str, Any]:
    return figures_of(sonar_complex.conduct)[0]


@pytest.fixture(scope="module")
def opening_runs() -> dict[str, Any]:
    return figures_of(narrow_opening.conduct)[0]


def test_in_the_simple_hall_correction_quarters_the_error_and_noise_falls() -> None:
    report, plots = figures_of(sonar_simple.conduct)
    assert report["pose_error_m"]["corrected"] <= report["pose_error_m"]["plain"] / 4.0
    assert report["noise_ratio"]["improved_atm"] <= report["noise_ratio"]["plain"] / 3.3
    assert set(plots) == {"sonar-simple", "sonar-simple-errors", "sonar-simple-noise"}
    assert report["way_m"] == pytest.approx(5 * 3.64, abs=0.5)


def test_with_turns_correction_quarters_the_error(complex_runs: dict[str, Any]) -> None:
    pose, rotation = complex_runs["pose_error_m"], complex_runs["rotation_error_rad"]
    assert pose["corrected"] <= pose["plain"] / 4.0
    assert rotation["corrected"] <= rotation["plain"] / 4.0


def test_odometry_alone_is_off_by_as_much_as_in_the_thesis(complex_runs: dict[str, Any]) -> None:
    assert complex_runs["pose_error_m"]["plain"] == pytest.approx(0.45, abs=0.12)
    assert np.rad2deg(complex_runs["left_turn_error_rad"]["plain"]) == pytest.approx(5.25, abs=2.0)
    assert np.rad2deg(complex_runs["right_turn_error_rad"]["plain"]) == pytest.approx(7.67, abs=2.0)


def test_noise_falls_to_less_than_a_third(complex_runs: dict[str, Any]) -> None:
    ratio = complex_runs["noise_ratio"]
    assert set(ratio) == {"plain", "centre_line", "bayes", "atm", "improved_atm"}
    for model in ("bayes", "atm", "improved_atm"):
        assert ratio[model] <= ratio["plain"] / 3.3


def test_every_mean_has_its_spread(complex_runs: dict[str, Any]) -> None:
    for name in ("pose_error_m", "rotation_error_rad", "noise_ratio"):
        assert complex_runs[f"{name}_std"].keys() == complex_runs[name].keys()


def test_the_centre_line_closes_the_opening_and_atm_leaves_it_open(
    opening_runs: dict[str, Any],
) -> None:
    width, blocked = opening_runs["width_m"], opening_runs["blocked"]
    assert width["centre_line"] < 0.2
    assert width["atm"] > 0.25
    assert width["improved_atm"] >= width["atm"]
    assert blocked["improved_atm"] <= blocked["atm"] < blocked["centre_line"]
    assert opening_runs["open"]["centre_line"] == 0.0


def test_most_crossings_lie_on_surfaces_and_more_of_those_that_the_improved_method_uses(
    opening_runs: dict[str, Any],
) -> None:
    valid, used = opening_runs["valid_ratio"], opening_runs["crossings"]
    assert valid["improved_atm"] >= 0.863
    assert valid["improved_atm"] > valid["atm"]
    assert used["improved_atm"] < used["atm"]


def test_times_stand_beside_those_of_the_twin(opening_runs: dict[str, Any]) -> None:
    assert set(opening_runs["placing_ms_per_scan"]) == {
        *("atm", "atm_twin", "improved_atm", "improved_atm_twin")
    }
    assert min(opening_runs["ms_per_scan"].values()) > 0.0


@pytest.mark.parametrize("improved", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_the_twin_places_echoes_where_the_kernel_does(seed: int, improved: bool) -> None:  # noqa: FBT001  - a case of the table
    rng = np.random.default_rng(seed)
    sonars, directions = rng.uniform(0.0, 1.0, (120, 2)), rng.uniform(0.5, 2.6, 120)
    arcs = np.column_stack([sonars, directions, rng.uniform(0.8, 1.2, 120)])
    twin = place_echoes_plainly(arcs, 0.44, CROSSINGS, improved=improved)
    assert place_by_kernel(arcs, 0.44, improved=improved) == pytest.approx(twin, abs=1e-9)
    assert np.count_nonzero(twin) > 30


def test_an_arc_without_crossings_keeps_its_middle() -> None:
    arcs = np.array([[0.0, 0.0, 0.0, 1.0], [5.0, 5.0, 0.0, 1.0]])
    assert place_echoes_plainly(arcs, 0.44, CROSSINGS, improved=True).tolist() == [0.0, 0.0]


def wall_with_gap(drawing: str) -> OccupancyMap:
    """A wall of 0.1 m cells about the opening's middle, free cells in front of it and behind."""
    cells = np.zeros((9, len(drawing)), np.int8)
    row = [{"#": 100, ".": 0, "?": -1}[mark] for mark in drawing]
    cells[4] = row
    cells[3] = np.where(np.array(row) < 0, -1, 0)
    cells[5] = cells[3]
    corner = (MIDDLE - len(drawing) * 0.05, UPPER - 0.45, 0.0)
    return OccupancyMap(GridGeometry(9, len(drawing), 0.1, corner), cells)


@pytest.mark.parametrize(
    ("drawing", "width", "blocked"),
    [
        ("####....####", 0.4, 0.0),
        ("####.#..####", 0.2, 0.25),
        ("############", 0.0, 1.0),
        ("####????####", 0.0, 0.0),
        ("............", 0.8, 0.0),
    ],
)
def test_an_opening_is_as_wide_as_its_widest_known_gap(
    drawing: str, width: float, blocked: float
) -> None:
    world = wall_with_gap(drawing)
    assert width_of_opening(world) == pytest.approx(width)
    assert share_blocked(world) == pytest.approx(blocked)


def test_cells_far_from_every_wall_are_noise() -> None:
    cells = np.zeros((10, 10), np.int8)
    cells[0] = 100
    cells[1, 3], cells[6, 5] = 100, 100
    world = OccupancyMap(GridGeometry(10, 10, 0.05), cells)
    walls = np.array([[0.0, 0.025, 0.5, 0.025]])
    assert noise_of(world, walls) == (1, 11)


def test_means_and_spreads_stand_side_by_side() -> None:
    report = with_spread("error", [{"a": 1.0}, {"a": 3.0}])
    assert report == {"error": {"a": 2.0}, "error_std": {"a": 1.0}}
