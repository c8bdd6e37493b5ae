"""The potential field of landmarks: the paper's rule, walls, maxima, and candidate targets."""

import numpy as np
import pytest

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.planner.landmark_targets import TargetParams, local_maxima, survey
from pilotage.planner.potential_field import (
    Recognition,
    environment_potential,
    sources_of,
    window_potential,
)

REACH = Recognition(2.0, 0.2)


def landmarks(*places: tuple[float, float], names: tuple[str | None, ...] = ()) -> LandmarkMap:
    count = len(places)
    return LandmarkMap(np.array(places, float), ("post",) * count, names or (None,) * count)


def room(*rows: str, cell: float = 0.5) -> OccupancyMap:
    """A map drawn as text, `#` for walls; its lower left corner is the origin."""
    cells = np.array([[100 if mark == "#" else 0 for mark in row] for row in rows[::-1]], np.int8)
    return OccupancyMap(GridGeometry(len(rows), len(rows[0]), cell), cells)


def test_by_the_papers_rule_half_are_recognised_at_d_low_and_a_tenth_at_d_high() -> None:
    world = landmarks((0.0, 0.0))
    sources = sources_of(world, {"post": Recognition.measured(4.0, 5.5)})
    half, tenth = environment_potential(sources, [[4.0, 0.0], [0.0, 5.5]])
    assert half == pytest.approx(0.5)
    assert tenth == pytest.approx(0.1)


def test_the_more_landmarks_are_alike_the_less_each_is_worth() -> None:
    far = [(100.0 * i, 0.0) for i in range(4)]
    alike = sources_of(landmarks(*far), {"post": REACH})
    assert environment_potential(alike, [far[0]])[0] == pytest.approx(0.25, abs=1e-4)
    named = sources_of(landmarks(*far, names=("a", "b", "c", "d")), {"post": REACH})
    assert environment_potential(named, [far[0]])[0] == pytest.approx(1.0, abs=1e-4)


def test_only_those_without_a_name_are_each_others_likes() -> None:
    sources = sources_of(
        landmarks((0, 0), (1, 0), (2, 0), names=("a", None, None)), {"post": REACH}
    )
    assert sorted(sources.strengths) == [0.5, 0.5, 1.0]


def test_a_class_of_unknown_reach_is_refused() -> None:
    with pytest.raises(KeyError, match="post"):
        sources_of(landmarks((0.0, 0.0)), {"goal": REACH})


def test_a_landmark_outside_the_field_of_view_adds_nothing() -> None:
    sources = sources_of(landmarks((1.0, 0.0)), {"post": REACH})
    ahead, aside = window_potential(sources, [[0.0, 0.0]], [0.3, 0.6], 0.5)[0]
    assert ahead > 0.9
    assert aside == 0.0


def test_the_view_reaches_over_the_seam_at_half_a_turn() -> None:
    sources = sources_of(landmarks((-1.0, 0.1)), {"post": REACH})
    assert window_potential(sources, [[0.0, 0.0]], [-3.1], 0.5)[0, 0] > 0.9


def test_a_wall_hides_what_is_behind_it_and_not_what_hangs_on_it() -> None:
    world = room(
        "#######",
        "#..#..#",
        "#..#..#",
        "#######",
    )
    behind, on_it = landmarks((2.75, 1.0)), landmarks((1.5, 1.0))
    place = [[0.75, 1.0]]
    assert environment_potential(sources_of(behind, {"post": REACH}, world), place)[0] == 0.0
    assert environment_potential(sources_of(behind, {"post": REACH}), place)[0] > 0.4
    assert environment_potential(sources_of(on_it, {"post": REACH}, world), place)[0] > 0.9


def test_a_summit_is_above_all_its_neighbours() -> None:
    heights = """
        0 0 0 0 0 0
        0 3 0 0 0 0
        0 0 0 5 5 0
        0 1 0 0 0 0
        2 0 0 0 0 0
    """
    values = np.array([[float(v) for v in row.split()] for row in heights.strip().splitlines()])
    tops = local_maxima(values[:, :, None], is_cyclic=False)
    assert tops[:, :2].tolist() == [[2, 3], [1, 1], [4, 0]]


def test_the_last_heading_is_next_to_the_first() -> None:
    values = np.array([[[2.0, 1.0, 0.0, 1.5]]])
    assert local_maxima(values, is_cyclic=True).tolist() == [[0, 0, 0]]


def test_a_field_of_nothing_has_no_summit() -> None:
    assert len(local_maxima(np.zeros((3, 3, 4)), is_cyclic=True)) == 0


def test_candidates_are_the_summits_places_by_chance_and_where_one_is() -> None:
    world = room(*["........"] * 8, "####....", "####....")
    sources = sources_of(landmarks((1.25, 1.25), (3.25, 3.25)), {"post": Recognition(0.6, 0.1)})
    field = survey(sources, world, TargetParams(half_view=0.5, clear=0.0))
    here = np.array([0.6, 0.4])
    candidates = field.around(here, 5, np.random.default_rng(1))
    summits = len(field.window_maxima) + len(field.environment_maxima)
    assert len(candidates) == summits + 5 + 1
    assert candidates[-1] == pytest.approx(here)
    by_chance = world.geometry.cells_of(candidates[summits:-1])
    assert world.is_free[tuple(by_chance.T)].all()
    assert field.environment_maxima.tolist() == [[1.25, 1.25], [3.25, 3.25]]


def test_the_sensor_points_to_the_landmark_where_the_window_potential_is_highest() -> None:
    world = room(*["........"] * 8)
    sources = sources_of(landmarks((2.0, 2.0)), {"post": Recognition(1.0, 0.1)})
    best = survey(sources, world, TargetParams(half_view=0.3)).window_maxima[0]
    toward = np.arctan2(2.0 - best[1], 2.0 - best[0])
    assert abs((best[2] - toward + np.pi) % (2.0 * np.pi) - np.pi) <= 0.3 + 1e-9


def test_no_summit_lies_in_a_wall_or_close_to_a_higher_one() -> None:
    world = room(*["........"] * 5, "########", "........")
    sources = sources_of(landmarks((2.0, 0.75)), {"post": Recognition(1.0, 0.1)})
    field = survey(sources, world, TargetParams(half_view=0.5, apart=1.0))
    places = field.window_maxima[:, :2]
    assert world.is_free[tuple(world.geometry.cells_of(places).T)].all()
    apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    assert (apart[~np.eye(len(places), dtype=bool)] >= 1.0).all()


def test_nobody_is_sent_onto_a_landmark() -> None:
    world = room(*["........"] * 8, cell=0.1)
    sources = sources_of(landmarks((0.4, 0.4)), {"post": Recognition(1.0, 0.1)})
    field = survey(sources, world, TargetParams(half_view=0.5, clear=0.3))
    candidates = field.around(np.array([0.7, 0.7]), 50, np.random.default_rng(0))
    assert (np.hypot(*(candidates - (0.4, 0.4)).T) >= 0.3).all()
