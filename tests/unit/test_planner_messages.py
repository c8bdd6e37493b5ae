"""Between messages and mathematics."""

from dataclasses import replace

import numpy as np
import pytest

from pilotage.core.grid import GridGeometry
from pilotage.planner.active_localization import Decision, Look
from pilotage.planner.map_potential import MapPotential
from pilotage.planner.messages import (
    belief_of,
    build_of,
    laser_view,
    path_message,
    plan_message,
    pose_of,
    potential_message,
    sentence,
    sonar_view,
    velocity_message,
)
from pilotage.planner.situation import Hypotheses
from pilotage_schemas.codec import decode, encode
from pilotage_schemas.localization import Belief
from pilotage_schemas.planning import ActivePlan
from pilotage_schemas.sensors import RobotDescription, SonarScan
from sample_messages import scan

HERE_OR_THERE = Hypotheses(
    np.array([[1.0, 2.0, np.pi / 2.0], [5.0, 2.0, np.pi / 2.0]]), np.array([0.7, 0.3])
)


def decision(gain: float = 1.2, heading: float | None = None) -> Decision:
    """To look from 3 m ahead, or from here."""
    looks = (
        Look(np.array([3.0, 0.0]), gain, 3.5, "potential"),
        Look(np.zeros(2), 0.1, 0.0, "here"),
    )
    path = np.array([[0.0, 0.0], [3.0, 0.0]])
    return Decision(looks, path, heading, HERE_OR_THERE, (0, 1), 0.9)


def test_candidates_are_where_the_belief_s_best_place_would_have_them() -> None:
    plan = plan_message(decision(heading=np.pi / 2.0), HERE_OR_THERE.poses[:, :2], 7)
    first, second = plan.candidates
    assert (first.pose.x, first.pose.y) == pytest.approx((1.0, 5.0))
    assert abs(first.pose.theta) == pytest.approx(np.pi)
    assert (first.expected_gain, first.travel, first.kind) == (1.2, 3.5, "potential")
    assert (second.pose.x, second.pose.y, second.kind) == (1.0, 2.0, "here")
    assert decode(ActivePlan, encode(plan)) == plan


def test_of_looks_side_by_side_only_the_best_is_shown() -> None:
    best, *_ = looks = decision().looks
    beside = [Look(best.point + off, 1.0, 3.6, "random") for off in ([0.3, 0.2], [-0.5, 0.0])]
    far = Look(np.array([3.0, 2.0]), 0.5, 4.0, "random")
    crowded = replace(decision(), looks=(best, *beside, looks[1], far))
    shown = plan_message(crowded, HERE_OR_THERE.poses[:, :2], 7).candidates
    assert [one.expected_gain for one in shown] == [1.2, 0.1, 0.5]


def test_places_have_the_numbers_that_the_belief_gives_them() -> None:
    places = np.array([[9.0, 9.0], [5.2, 2.1], [1.1, 2.0]])
    assert sentence(decision(), places) == "Would tell place 2 from place 3"


def test_places_that_the_belief_does_not_name_have_no_number() -> None:
    for places in (np.zeros((0, 2)), np.array([[1.0, 2.0]]), np.array([[50.0, 50.0]])):
        assert sentence(decision(), places) == "Would show more than is seen from here"


def test_a_look_that_tells_nothing_is_not_praised() -> None:
    places = HERE_OR_THERE.poses[:, :2]
    assert sentence(decision(gain=0.0), places).startswith("Nothing near tells")


def test_a_path_points_along_itself() -> None:
    path = path_message(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]), 1)
    assert path.poses[:, 2] == pytest.approx([0.0, np.pi / 2.0, np.pi / 2.0])
    assert len(path_message(np.zeros((0, 2)), 1).poses) == 0
    assert path_message(np.array([[2.0, 3.0]]), 1).poses.tolist() == [[2.0, 3.0, 0.0]]


def test_the_potential_lies_as_its_grid_does() -> None:
    geometry = GridGeometry(2, 3, 0.5, (1.0, 2.0, 0.3))
    field = potential_message(MapPotential(geometry, np.ones((2, 3), np.float32)), 1)
    assert (field.origin.x, field.origin.y, field.origin.theta) == (1.0, 2.0, 0.3)
    assert field.resolution == 0.5
    assert field.potential.shape == (2, 3)


def test_a_heading_beyond_pi_is_wrapped_and_others_are_left_alone() -> None:
    assert pose_of([0.0, 0.0, 1.57]).theta == 1.57
    assert pose_of([0.0, 0.0, 3.5]).theta == pytest.approx(3.5 - 2.0 * np.pi)


def test_a_belief_sums_to_one_whatever_part_of_it_was_sent() -> None:
    samples = np.array([[0.0, 0.0, 4.0, 0.2], [1.0, 0.0, 0.0, 0.6]], np.float32)
    past = belief_of(belief(samples))
    assert past is not None
    assert past.hypotheses.weights == pytest.approx([0.25, 0.75])
    assert past.hypotheses.poses[0, 2] == pytest.approx(4.0 - 2.0 * np.pi)


@pytest.mark.parametrize("weights", [[], [0.0, 0.0], [-1.0]])
def test_a_belief_that_says_nothing_is_none(weights: list[float]) -> None:
    samples = np.zeros((len(weights), 4), np.float32)
    samples[:, 3] = weights
    assert belief_of(belief(samples)) is None


def belief(samples: np.ndarray) -> Belief:
    return Belief(
        stamp_ns=1,
        frame_id="map",
        map_id="m",
        method="markov",
        samples=samples,
        entropy=0.0,
        modes=(),
    )


def test_a_laser_sees_from_where_it_sits() -> None:
    view = laser_view(scan(1, beams=60), np.array([0.1, 0.0, 0.0]))
    assert view is not None
    assert len(view.points) == 59, "the first beam returns nothing"
    assert np.hypot(*(view.points - [0.1, 0.0]).T) == pytest.approx(np.ones(59))


def test_a_range_below_the_least_that_a_laser_measures_is_no_obstacle() -> None:
    near = scan(1, beams=60).model_copy(update={"range_min": 2.0})
    view = laser_view(near, np.zeros(3))
    assert view is not None
    assert len(view.points) == 0


@pytest.mark.parametrize("beams", [0, 1])
def test_a_scan_of_hardly_any_beams_shows_nothing(beams: int) -> None:
    assert laser_view(scan(1, beams=beams), np.zeros(3)) is None


def test_a_sonar_ring_minds_the_cones_of_near_echoes() -> None:
    mounts = np.array([[0.1, 0.0, 0.0], [0.0, 0.1, np.pi / 2.0], [0.0, -0.1, -np.pi / 2.0]])
    ring = SonarScan(
        stamp_ns=1,
        frame_id="base_link",
        mounts=mounts.astype(np.float32),
        ranges=np.array([0.5, 2.0, np.inf], np.float32),
        cone=0.3,
        range_min=0.1,
        range_max=4.0,
    )
    view = sonar_view(ring)
    assert view is not None
    assert np.hypot(*(view.points - [0.1, 0.0]).T) == pytest.approx(np.full(3, 0.5))
    assert np.abs(view.points[:, 1]).max() == pytest.approx(0.5 * np.sin(0.15))


def test_a_robot_is_as_wide_as_its_farthest_corner() -> None:
    corners = np.array([[0.3, 0.2], [-0.1, 0.2], [-0.1, -0.2]], np.float32)
    assert build_of(description(corners)).radius == pytest.approx(np.hypot(0.3, 0.2))
    assert build_of(description(np.zeros((0, 2), np.float32))).radius == 0.25


def description(footprint: np.ndarray) -> RobotDescription:
    return RobotDescription(
        stamp_ns=1,
        frame_id="base_link",
        name="Toy",
        driver="toy",
        footprint=footprint,
        mounts=(),
        max_linear=0.5,
        max_angular=1.0,
        commands=("velocity",),
    )


def test_a_velocity_says_what_its_sender_knew_and_what_follows() -> None:
    command = velocity_message((0.2, -0.1), 5, 3, "resume")
    assert (command.twist.vx, command.twist.vy, command.twist.omega) == (0.2, 0.0, -0.1)
    assert (command.orders, command.then) == (3, "resume")
