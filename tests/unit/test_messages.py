"""Rules that all messages keep."""

import inspect
from typing import get_args

import numpy as np
import pytest
from pydantic import ValidationError

from pilotage_schemas.codec import encode
from pilotage_schemas.commands import Drive, SetPose, Turn
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.health import Heartbeat
from pilotage_schemas.localization import Belief, Mode, PoseEstimate
from pilotage_schemas.mapping import OccupancyGrid
from pilotage_schemas.message import Message, Part
from pilotage_schemas.sensors import Heading
from pilotage_schemas.topics import QUERIES, TOPICS, Topic
from sample_messages import HERE, grid, odometry, scan

KINDS = sorted(
    {topic.message for topic in TOPICS.values()}
    | {kind for query in QUERIES.values() for kind in (query.request, query.reply)},
    key=lambda kind: kind.__name__,
)
every_kind = pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)


@every_kind
def test_every_message_says_what_it_is(kind: type[Part]) -> None:
    assert inspect.getdoc(kind) != inspect.getdoc(Part)
    assert inspect.getdoc(kind) != inspect.getdoc(Message)


@every_kind
def test_every_message_is_frozen_strict_and_closed(kind: type[Part]) -> None:
    config = kind.model_config
    assert (config["frozen"], config["strict"], config["extra"]) == (True, True, "forbid")


@every_kind
def test_every_field_has_a_name_in_snake_case(kind: type[Part]) -> None:
    assert all(name == name.lower() for name in kind.model_fields)


@pytest.mark.parametrize("topic", TOPICS.values(), ids=lambda topic: topic.name)
def test_every_streamed_message_is_stamped(topic: Topic) -> None:
    assert {"stamp_ns", "frame_id", "seq"} <= set(topic.message.model_fields)


def test_a_message_cannot_be_changed() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        odometry(1).__setattr__("stamp_ns", 2)


@pytest.mark.parametrize("stamp", [-1, 2**63, 1.0, "1", True, None])
def test_a_stamp_is_whole_nanoseconds_since_1970(stamp: object) -> None:
    with pytest.raises(ValidationError, match="stamp_ns"):
        Heartbeat.model_validate(
            {"stamp_ns": stamp, "frame_id": "", "service": "a", "state": "ready", "within": 1.0}
        )


def test_a_heading_beyond_pi_is_refused() -> None:
    with pytest.raises(ValidationError, match="theta"):
        Pose2(x=0.0, y=0.0, theta=3.2)


def test_pi_itself_is_a_heading_both_ways() -> None:
    assert Pose2(x=0.0, y=0.0, theta=np.pi).theta == -Pose2(x=0.0, y=0.0, theta=-np.pi).theta


@pytest.mark.parametrize("distance", [0.0, -1.0, 101.0, float("nan"), float("inf"), "1"])
def test_a_distance_is_positive_and_sane(distance: object) -> None:
    with pytest.raises(ValidationError, match="distance"):
        Drive.model_validate({"distance": distance})


def test_a_command_has_usual_speeds() -> None:
    assert Drive(distance=1.0).speed == pytest.approx(0.3)
    assert Turn(angle=-1.0).rate == pytest.approx(0.6)


@pytest.mark.parametrize("confidence", [-0.1, 1.1, float("nan")])
def test_a_probability_lies_between_zero_and_one(confidence: float) -> None:
    with pytest.raises(ValidationError, match="confidence"):
        PoseEstimate(
            stamp_ns=1,
            frame_id="map",
            pose=HERE,
            covariance=np.eye(3),
            state="localized",
            confidence=confidence,
        )


def test_the_states_of_a_pose_are_four() -> None:
    state = PoseEstimate.model_fields["state"].annotation
    assert set(get_args(state)) == {"unknown", "ambiguous", "localized", "lost"}


def test_a_belief_may_have_no_modes_and_no_marginal() -> None:
    belief = Belief(
        stamp_ns=1,
        frame_id="map",
        map_id="a",
        method="m2",
        samples=np.zeros((0, 4), np.float32),
        entropy=0.0,
        modes=(),
    )
    assert belief.marginal is None


def test_a_list_of_parts_becomes_a_tuple() -> None:
    mode = Mode(mass=1.0, pose=HERE, covariance=np.eye(3))
    belief = {
        "stamp_ns": 1,
        "frame_id": "map",
        "map_id": "a",
        "method": "m2",
        "samples": np.zeros((0, 4), np.float32),
        "entropy": 0.0,
        "modes": [mode],
    }
    assert Belief.model_validate(belief).modes == (mode,)


def test_a_covariance_that_may_be_missing_is_checked_when_it_is_there() -> None:
    assert SetPose(pose=HERE).covariance is None
    with pytest.raises(ValidationError, match="shape must be"):
        SetPose(pose=HERE, covariance=np.eye(2))


def test_a_scan_of_360_beams_is_small() -> None:
    assert len(encode(scan(1, beams=360))) < 360 * 4 + 200


def test_a_map_lies_on_earth() -> None:
    fields = dict(grid(1)) | {"origin": Pose2(x=1.1e8, y=0.0, theta=0.0)}
    with pytest.raises(ValidationError, match="origin"):
        OccupancyGrid.model_validate(fields)


@pytest.mark.parametrize("resolution", [0.0, 1e-4, 11.0])
def test_a_cell_has_a_sane_size(resolution: float) -> None:
    with pytest.raises(ValidationError, match="resolution"):
        OccupancyGrid.model_validate(dict(grid(1)) | {"resolution": resolution})


@pytest.mark.parametrize("sigma", [0.0, -1.0, 1e-300, 2e9])
def test_what_must_be_positive_can_be_divided_by(sigma: float) -> None:
    with pytest.raises(ValidationError, match="sigma"):
        Heading(stamp_ns=1, frame_id="map", yaw=0.0, sigma=sigma)
