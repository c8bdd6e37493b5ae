"""The football field with its landmarks: where things stand, and what the camera makes of them."""

from pathlib import Path

import numpy as np
import pytest

from pilotage.core.landmark_map import LandmarkMap, landmarks_of, read_landmarks
from pilotage.core.map_files import load_map
from pilotage.robot.simulator.config import open_world
from pilotage.robot.simulator.draw_worlds import write_list
from pilotage.robot.simulator.football_field import football_field, football_landmarks

RENEW = "run `python -m pilotage.robot.simulator.draw_worlds deploy/worlds`"

FIELD = football_field()
LANDMARKS = landmarks_of(football_landmarks())


def places(kind: str) -> set[tuple[float, float]]:
    return {
        (float(x), float(y))
        for (x, y), own in zip(LANDMARKS.positions, LANDMARKS.classes, strict=True)
        if own == kind
    }


def mirrored(x: float, y: float) -> set[tuple[float, float]]:
    return {(sx * x, sy * y) for sx in (1, -1) for sy in (1, -1)}


def test_the_committed_field_is_what_the_code_draws(repository: Path) -> None:
    committed = load_map(repository / "deploy" / "worlds" / "robocup_map.yaml")
    assert committed.geometry == FIELD.geometry, RENEW
    assert np.array_equal(committed.cells, FIELD.cells), RENEW


def test_the_committed_landmarks_are_those_of_the_code(repository: Path) -> None:
    committed = read_landmarks(repository / "deploy" / "worlds" / "robocup_landmarks.yaml")
    assert_same(committed, LANDMARKS)


def test_landmarks_that_are_written_read_back_the_same(tmp_path: Path) -> None:
    write_list("landmarks", football_landmarks(), tmp_path / "field.yaml")
    assert_same(read_landmarks(tmp_path / "field.yaml"), LANDMARKS)


def assert_same(one: LandmarkMap, other: LandmarkMap) -> None:
    assert np.array_equal(one.positions, other.positions), RENEW
    assert (one.classes, one.identities) == (other.classes, other.identities), RENEW


def test_the_carpet_measures_6_by_4_metres_about_the_origin() -> None:
    free = FIELD.geometry.centres_of(np.argwhere(FIELD.is_free))
    assert free.min(axis=0) == pytest.approx([-2.975, -1.975])
    assert free.max(axis=0) == pytest.approx([2.975, 1.975])


def test_landmarks_stand_where_the_rules_put_them() -> None:
    assert places("goal") == {(2.7, 0.0), (-2.7, 0.0)}
    assert places("beacon") == mirrored(1.35, 1.95)
    assert places("l_crossing") == mirrored(2.7, 1.8) | mirrored(2.05, 0.65)
    assert places("t_crossing") == {(0.0, 1.8), (0.0, -1.8)} | mirrored(2.7, 0.65)
    assert places("centre_circle") == {(0.0, 0.0)}


def test_goals_and_beacons_have_colours_and_crossings_are_alike() -> None:
    named = [
        kind
        for kind, identity in zip(LANDMARKS.classes, LANDMARKS.identities, strict=True)
        if identity is not None
    ]
    assert sorted(named) == ["beacon"] * 4 + ["goal"] * 2


def test_beacons_stand_in_the_way_and_lines_do_not() -> None:
    cells = FIELD.geometry.cells_of(LANDMARKS.positions)
    is_wall = FIELD.is_wall[cells[:, 0], cells[:, 1]]
    assert {k for k, wall in zip(LANDMARKS.classes, is_wall, strict=True) if wall} == {"beacon"}


def test_the_robot_starts_before_the_yellow_goal_and_can_go_anywhere(repository: Path) -> None:
    simulation = open_world(repository / "deploy" / "worlds" / "robocup.yaml", seed=1)
    assert simulation.pose == pytest.approx([2.4, -0.1, np.pi / 2.0], abs=1e-4)
    reached = simulation.walls.places(0.165)
    for x, y in ((-2.7, 0.0), (2.7, 0.0), (0.0, 1.75), (-2.7, -1.75)):
        assert np.hypot(*(reached - (x, y)).T).min() < 0.1


def test_every_landmark_can_be_seen_from_a_metre_away(repository: Path) -> None:
    simulation = open_world(repository / "deploy" / "worlds" / "robocup.yaml", seed=2)
    camera = simulation.camera
    assert camera is not None
    for index, place in enumerate(LANDMARKS.positions):
        towards_middle = np.arctan2(*-place[::-1]) if place.any() else 0.0
        stand = place + 0.9 * np.array([np.cos(towards_middle), np.sin(towards_middle)])
        pose = np.array([*stand, towards_middle + np.pi])
        pictures = [
            camera.picture(simulation.surroundings, pose, simulation.rng) for _ in range(10)
        ]
        assert any(index in picture.landmarks for picture in pictures), football_landmarks()[index]
