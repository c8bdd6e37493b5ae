"""Where to go, how far, and where to look, when landmarks are all there is (Liu et al. 2008)."""

from dataclasses import replace

import numpy as np
import pytest

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.planner.landmark_localization import (
    ActiveParams,
    LandmarkLocalization,
    move_to,
    predicted,
    shortened,
)
from pilotage.planner.potential_field import Recognition, sources_of
from pilotage.planner.sample_spacing import sample_spacing
from pilotage.planner.situation import Hypotheses

RECOGNITIONS = {"post": Recognition(1.0, 0.1), "flag": Recognition(1.0, 0.1)}
PARAMS = ActiveParams()


def floor() -> OccupancyMap:
    """Ten metres by four, the middle at the origin."""
    return OccupancyMap(GridGeometry(20, 50, 0.2, (-5.0, -2.0, 0.0)), np.zeros((20, 50), np.int8))


def world(*, has_flag: bool = True) -> LandmarkMap:
    """A post on either side, alike, and a flag that one of the two has nearby."""
    flags = [(2.0, 1.5)] if has_flag else []
    places = [(-3.0, 0.0), (3.0, 0.0), *flags]
    classes = ("post", "post", *("flag" for _ in flags))
    return LandmarkMap(np.array(places), classes, (None,) * len(places))


def method(landmarks: LandmarkMap, params: ActiveParams = PARAMS) -> LandmarkLocalization:
    return LandmarkLocalization(sources_of(landmarks, RECOGNITIONS), floor(), params)


def around(*poses: tuple[float, float, float], spread: float = 0.03) -> Hypotheses:
    """Samples around some poses, half of them each."""
    rng = np.random.default_rng(0)
    each = [np.array(pose) + spread * rng.standard_normal((100, 3)) for pose in poses]
    samples = np.concatenate(each)
    return Hypotheses(samples, np.full(len(samples), 1.0 / len(samples)))


BESIDE_A_POST = around((2.6, 0.0, 0.0), (-3.4, 0.0, 0.0))
"""Beside the one or the other post: the same to see, until the flag comes into view."""


def test_of_two_places_that_look_alike_the_robot_goes_where_they_differ() -> None:
    decision = method(world()).decide(BESIDE_A_POST, np.random.default_rng(1))
    there = decision.candidates[decision.target] - decision.here[:2]
    toward_flag = np.array([2.0, 1.5]) - (2.6, 0.0)
    assert there @ toward_flag > 0.5 * np.hypot(*there) * np.hypot(*toward_flag)
    assert decision.gains[decision.target] > decision.gains[-1] + 0.3
    assert decision.travels[decision.target] > 0.3


def test_a_step_is_no_longer_than_the_robot_is_fast() -> None:
    decision = method(world()).decide(BESIDE_A_POST, np.random.default_rng(1))
    assert np.hypot(*decision.move) == pytest.approx(PARAMS.step)


def test_where_a_metre_costs_more_than_anything_tells_the_robot_stays() -> None:
    params = replace(PARAMS, alpha=1000.0)
    decision = method(world(), params).decide(BESIDE_A_POST, np.random.default_rng(1))
    assert decision.target == len(decision.candidates) - 1
    assert decision.move == pytest.approx([0.0, 0.0], abs=1e-9)


def test_the_camera_points_to_what_tells_places_apart() -> None:
    belief = around((2.0, 0.8, 0.0), (-4.0, 0.8, 0.0))
    decision = method(world(), replace(PARAMS, alpha=1000.0)).decide(
        belief, np.random.default_rng(1)
    )
    straight_up = np.pi / 2.0
    assert abs(decision.gaze - straight_up) <= PARAMS.camera.half_view + 0.2


def test_the_same_belief_and_the_same_chances_give_the_same_decision() -> None:
    one, other = (method(world()).decide(BESIDE_A_POST, np.random.default_rng(4)) for _ in range(2))
    assert one.target == other.target
    assert one.gaze == other.gaze
    assert one.gains == pytest.approx(other.gains)


def test_nothing_is_learnt_where_there_is_nothing_to_see() -> None:
    landmarks = LandmarkMap(np.array([[50.0, 50.0]]), ("post",), (None,))
    decision = method(landmarks).decide(BESIDE_A_POST, np.random.default_rng(1))
    assert decision.gains == pytest.approx(0.0, abs=1e-6)
    assert decision.travels[decision.target] == 0.0


def test_one_sample_alone_knows_all_there_is() -> None:
    certain = Hypotheses(np.array([[2.0, 0.0, 0.0]]), np.ones(1))
    decision = method(world()).decide(certain, np.random.default_rng(1))
    assert decision.gains == pytest.approx(0.0, abs=1e-6)


def test_the_way_to_a_place_is_said_in_the_robots_own_frame() -> None:
    here = np.array([1.0, 1.0, np.pi / 2.0])
    assert move_to(here, np.array([1.0, 3.0])) == pytest.approx([2.0, 0.0])
    assert move_to(here, np.array([0.0, 1.0])) == pytest.approx([0.0, 1.0])


@pytest.mark.parametrize(("way", "gone"), [((0.03, 0.04), 0.05), ((3.0, 4.0), 0.1), ((0, 0), 0)])
def test_the_robot_goes_all_the_way_if_it_can_and_else_along_it(
    way: tuple[float, float], gone: float
) -> None:
    step = shortened(np.array(way, float), 0.1)
    assert np.hypot(*step) == pytest.approx(gone)
    assert step[0] * way[1] == pytest.approx(step[1] * way[0])


def test_every_sample_makes_the_same_move_from_its_own_heading() -> None:
    belief = Hypotheses(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, np.pi / 2.0]]), np.full(2, 0.5))
    after = predicted(belief, np.array([0.1, 0.0]), np.zeros((2, 2)))
    assert after.poses == pytest.approx(np.array([[0.1, 0.0, 0.0], [1.0, 0.1, np.pi / 2.0]]))


def test_a_move_errs_by_a_share_of_its_length() -> None:
    rng = np.random.default_rng(2)
    belief = Hypotheses(np.zeros((20_000, 3)), np.full(20_000, 1.0 / 20_000))
    after = predicted(belief, np.array([0.3, 0.4]), 0.1 * rng.standard_normal((20_000, 2)))
    assert after.poses.mean(axis=0) == pytest.approx([0.3, 0.4, 0.0], abs=2e-3)
    assert after.poses[:, :2].std(axis=0) == pytest.approx([0.05, 0.05], rel=0.03)


def test_the_wider_a_belief_the_farther_apart_its_samples() -> None:
    assert sample_spacing(around((0.0, 0.0, 0.0))) == pytest.approx([0.0045] * 3, rel=0.2)
    wide = sample_spacing(BESIDE_A_POST)
    assert wide[0] > 0.2
    assert wide[1] < 0.01


def test_the_spacing_does_not_care_for_the_seam_at_half_a_turn() -> None:
    assert sample_spacing(around((0.0, 0.0, np.pi)))[2] < 0.01


def test_nothing_is_expected_to_be_seen_through_a_wall() -> None:
    walled = floor()
    walled.cells[:, 26:28] = 100
    behind = LandmarkMap(np.array([[1.5, 0.0]]), ("post",), (None,))
    belief = around((-0.2, 0.0, 0.0), (-0.2, 0.0, np.pi))
    open_view, hidden = (
        LandmarkLocalization(
            sources_of(behind, {"post": Recognition(3.0, 0.1)}, world), floor(), PARAMS
        ).decide(belief, np.random.default_rng(1))
        for world in (None, walled)
    )
    assert open_view.gains[-1] > 0.3
    assert hidden.gains[-1] == pytest.approx(0.0, abs=1e-6)
