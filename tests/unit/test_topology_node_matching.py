"""The constellation of what is seen, laid over what a node is bound to."""

import time

import numpy as np
import pytest

from feature_scenes import (
    corner,
    door,
    even_corridor,
    feature,
    long_corridor,
    seen_from,
    uneven_corridor,
)
from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.topology.at_nodes.matching import (
    MatchParams,
    NodeMatch,
    expected_in_sight,
    match_features,
)
from pilotage.topology.features import Features

WINDOW = (0.7, 0.45)
START = np.array([0.8, 0.1, 0.1])


def error(match: NodeMatch, truth: np.ndarray) -> tuple[float, float]:
    off = match.pose - truth
    return float(np.hypot(off[0], off[1])), abs(wrap(float(off[2])))


def matched(seen: Features, bound: Features, prior: np.ndarray) -> NodeMatch:
    match = match_features(seen, bound, prior, WINDOW)
    assert match is not None
    return match


def test_everything_seen_where_it_ought_to_be_is_paired() -> None:
    world = uneven_corridor()
    match = matched(seen_from(START, world), world, START)
    # The two corners lie behind the robot.
    assert match.pairs.tolist() == [[0, 2], [1, 3], [2, 4], [3, 5], [4, 6]]
    assert error(match, START) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert match.is_clear


@pytest.mark.parametrize("bearing", np.linspace(-np.pi, np.pi, 7)[:-1].tolist())
@pytest.mark.parametrize("turn", [-20.0, 20.0])
def test_a_prior_wrong_by_half_a_metre_and_20_degrees_is_survived(
    bearing: float, turn: float
) -> None:
    world = uneven_corridor()
    seen = seen_from(START, world, np.random.default_rng(1))
    wrong = np.array([0.5 * np.cos(bearing), 0.5 * np.sin(bearing), np.deg2rad(turn)])
    match = matched(seen, world, START + wrong)
    assert match.is_clear
    far, turned = error(match, START)
    assert far < 0.1
    assert turned < 0.05


def test_in_a_corridor_nearly_all_wrong_priors_are_made_good_and_none_made_worse() -> None:
    rng, world = np.random.default_rng(5), long_corridor()
    found = wrong = tried = 0
    for _ in range(300):
        truth = np.array([rng.uniform(1.0, 24.0), rng.uniform(-0.4, 0.4), rng.uniform(-0.3, 0.3)])
        seen = seen_from(truth, world, rng, missed=0.2, reach=6.0)
        near = world.chosen(np.abs(world.poses[:, 0] - truth[0] - 2.0) < 5.0)
        bearing = rng.uniform(-np.pi, np.pi)
        off = [0.5 * np.cos(bearing), 0.5 * np.sin(bearing), rng.choice([-0.349, 0.349])]
        match = match_features(seen, near, truth + off, WINDOW)
        if len(seen) < 3:
            continue
        tried += 1
        is_taken = match is not None and match.is_clear and len(match.pairs) >= 3
        if is_taken and match is not None:
            far, turned = error(match, truth)
            found += far < 0.2 and turned < 0.1
            wrong += far > 0.3 or turned > 0.2
    assert tried > 150
    assert found >= 0.8 * tried
    assert wrong == 0


def test_people_and_furniture_are_left_unpaired() -> None:
    world, rng = uneven_corridor(), np.random.default_rng(2)
    strange = [corner(*rng.uniform([0.5, -1.0, -3.0], [4.0, 1.0, 3.0])) for _ in range(6)]
    seen = Features.joined([seen_from(START, world, rng), *strange])
    match = matched(seen, world, START + np.array([0.3, -0.2, 0.2]))
    assert match.is_clear
    assert error(match, START)[0] < 0.1
    assert (match.pairs[:, 0] < len(world)).all()


def test_doors_exactly_alike_are_ambiguous() -> None:
    world = even_corridor(count=8, spacing=0.6)
    middle = np.array([1.5, 0.0, 0.0])
    seen = seen_from(middle, world.chosen(np.arange(4, 8)))
    match = matched(seen, world, middle)
    assert match.rival_score > 0.8 * match.score
    assert not match.is_clear


def test_the_prior_tells_doors_apart_that_lie_farther_from_each_other_than_it_errs() -> None:
    world = even_corridor(count=8, spacing=2.0)
    truth = np.array([3.0, 0.2, 0.1])
    match = matched(seen_from(truth, world), world, truth + np.array([0.4, 0.1, 0.2]))
    assert match.is_clear
    assert error(match, truth)[0] < 0.05


def test_what_ought_to_be_seen_and_is_not_counts_against_a_pose() -> None:
    world = Features.joined([door(2.0, 1.0), door(3.5, -1.0), door(4.0, 1.0)])
    all_of_them = matched(seen_from(np.zeros(3), world), world, np.zeros(3))
    fewer = matched(seen_from(np.zeros(3), world.chosen(np.arange(2))), world, np.zeros(3))
    assert all_of_them.score == pytest.approx(3.0, abs=0.01)
    assert fewer.score == pytest.approx(2.0 - MatchParams().miss_cost, abs=0.01)


def test_an_opening_is_walked_through_either_way() -> None:
    world = Features.joined([door(2.0, 1.0, np.pi / 2.0), door(3.0, -1.0, -np.pi / 2.0)])
    turned = Features.joined([door(2.0, 1.0, -np.pi / 2.0), door(3.0, -1.0, np.pi / 2.0)])
    assert len(matched(turned, world, np.zeros(3)).pairs) == 2


def test_a_corner_that_opens_the_other_way_is_another() -> None:
    assert match_features(corner(2.0, 1.0, 0.0), corner(2.0, 1.0, 3.0), np.zeros(3), WINDOW) is None


def test_a_corner_is_no_door() -> None:
    assert match_features(corner(2.0, 1.0, 1.5), door(2.0, 1.0), np.zeros(3), WINDOW) is None


def test_an_open_door_is_a_passage() -> None:
    passage = feature("passage", (2.0, 1.0, np.pi / 2.0), 1.0)
    assert len(matched(passage, door(2.0, 1.0, width=0.9), np.zeros(3)).pairs) == 1


def test_a_double_door_is_no_single_one() -> None:
    single, double = door(2.0, 1.0, width=0.9), door(2.0, 1.0, width=1.8)
    assert match_features(single, double, np.zeros(3), WINDOW) is None


def test_a_width_that_nobody_knows_forbids_nothing() -> None:
    unknown = feature("door", (2.0, 1.0, np.pi / 2.0))
    assert len(matched(unknown, door(2.0, 1.0), np.zeros(3)).pairs) == 1


@pytest.mark.parametrize("nothing", ["seen", "bound"])
def test_nothing_matches_nothing(nothing: str) -> None:
    world = uneven_corridor()
    seen = Features.none() if nothing == "seen" else world
    bound = Features.none() if nothing == "bound" else world
    assert match_features(seen, bound, START, WINDOW) is None


def test_a_pose_outside_the_window_is_not_found() -> None:
    world = uneven_corridor()
    match = match_features(
        seen_from(START, world), world, START + np.array([3.0, 0.0, 0.0]), WINDOW
    )
    assert match is None or len(match.pairs) < 4


def test_a_wrapped_heading_is_no_obstacle() -> None:
    world = uneven_corridor().moved([0.0, 0.0, np.pi - 0.05])
    truth = se2.compose([0.0, 0.0, np.pi - 0.05], START)
    match = matched(seen_from(truth, world), world, truth + np.array([0.1, 0.1, 0.3]))
    assert error(match, truth)[0] < 1e-3


def test_more_pairs_and_longer_bases_say_more_exactly_where_the_robot_is() -> None:
    world = uneven_corridor()
    few = matched(seen_from(START, world.chosen(np.arange(3))), world, START)
    many = matched(seen_from(START, world), world, START)
    assert np.linalg.det(many.covariance) < 0.2 * np.linalg.det(few.covariance)


def test_features_behind_and_far_away_are_not_expected() -> None:
    world = Features.joined([door(2.0, 0.0), door(-2.0, 0.0), door(20.0, 0.0)])
    assert expected_in_sight(world, np.zeros(3), MatchParams()).tolist() == [True, False, False]


def test_a_corner_is_expected_only_by_those_before_it() -> None:
    world = Features.joined([corner(2.0, 0.0, np.pi), corner(2.0, 0.0, 0.0)])
    assert expected_in_sight(world, np.zeros(3), MatchParams()).tolist() == [True, False]


def test_a_match_takes_two_milliseconds_at_most() -> None:
    rng, world = np.random.default_rng(0), long_corridor()
    truth = np.array([8.0, 0.0, 0.0])
    near = world.chosen(np.abs(world.poses[:, 0] - 10.0) < 6.0)
    seen = seen_from(truth, world, rng, reach=8.0)
    spent = []
    for _ in range(20):
        began = time.process_time()
        match_features(seen, near, truth + np.array([0.4, 0.2, 0.3]), WINDOW)
        spent.append(time.process_time() - began)
    assert np.median(spent) < 2e-3
