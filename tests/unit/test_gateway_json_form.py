"""Messages as JSON and back."""

import json
from typing import Annotated

import jsonschema_rs
import numpy as np
import pytest

from gateway_world import belief, description, grid, odometry, pose_estimate, scan
from pilotage.gateway.json_form import BadRequestError, from_json, schema_of, to_json
from pilotage_schemas.arrays import Float32Array, Int8Array, Nd
from pilotage_schemas.commands import Drive, Kidnap, Nothing, SetAlgorithm, SetPose
from pilotage_schemas.message import Message, Part

POSE = {"x": 1, "y": 2.5, "theta": 0.0}


class Small(Part):
    numbers: Annotated[Int8Array, Nd("int8", "n")]


class Single(Part):
    numbers: Annotated[Float32Array, Nd("float32", "n")]


def test_a_range_without_return_is_null() -> None:
    assert to_json(scan(5, 1.5, np.inf))["ranges"] == [1.5, None]


def test_single_precision_shows_no_false_digits() -> None:
    assert to_json(scan(5, 0.1))["ranges"] == [0.1]


def test_arrays_are_nested_lists() -> None:
    assert to_json(grid("#."))["cells"] == [[100, 0]]
    assert to_json(pose_estimate(5))["covariance"] == [[0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.01]]


def test_parts_within_parts_are_objects() -> None:
    form = to_json(belief(5))
    assert form["modes"][0]["pose"] == {"x": 1.0, "y": 2.0, "theta": 0.5}
    assert form["marginal"] is None


@pytest.mark.parametrize(
    "message",
    [belief(5), description(5), grid("#?"), odometry(5), pose_estimate(5), scan(5, np.inf)],
)
def test_every_message_fits_its_schema(message: Message) -> None:
    form = json.loads(json.dumps(to_json(message), allow_nan=False))
    schema = schema_of(type(message))
    jsonschema_rs.Draft202012Validator(schema).validate(form)


def test_schemas_stand_alone() -> None:
    text = json.dumps(schema_of(SetPose, is_reply=False))
    assert "$ref" not in text
    assert "$defs" not in text
    assert '"minItems": 3' in text


def test_a_request_is_read_strictly() -> None:
    assert from_json(Drive, b'{"distance": 2}') == Drive(distance=2.0)
    assert from_json(SetAlgorithm, b'{"algorithm": "m1"}').algorithm == "m1"


def test_nothing_means_all_defaults() -> None:
    assert from_json(Nothing, b"") == Nothing()
    assert from_json(Kidnap, b"{}").pose is None


def test_nested_lists_become_arrays() -> None:
    body = json.dumps({"pose": POSE, "covariance": np.eye(3, dtype=int).tolist()}).encode()
    covariance = from_json(SetPose, body).covariance
    assert covariance is not None
    assert covariance.dtype == np.float64
    np.testing.assert_array_equal(covariance, np.eye(3))


@pytest.mark.parametrize(
    ("covariance", "reason"),
    [
        ([[1, 0], [0, 1]], "shape"),
        ([[1, 0, 0], [0, 1], [0, 0, 1]], "unequal"),
        ([["1", 0, 0], [0, 1, 0], [0, 0, 1]], "numbers"),
        ([[True, 0, 0], [0, 1, 0], [0, 0, 1]], "numbers"),
        ([[None, 0, 0], [0, 1, 0], [0, 0, 1]], "numbers"),
        ([[10**400, 0, 0], [0, 1, 0], [0, 0, 1]], "numbers"),
        ([[1e999, 0, 0], [0, 1, 0], [0, 0, 1]], "JSON"),
        ("eye", "array"),
        ([], "shape"),
    ],
)
def test_a_wrong_array_is_refused_with_its_name(covariance: object, reason: str) -> None:
    body = json.dumps({"pose": POSE, "covariance": covariance}).encode()
    with pytest.raises(BadRequestError, match=reason):
        from_json(SetPose, body)


def test_infinity_written_as_a_large_number_is_refused() -> None:
    body = b'{"pose": {"x": 0, "y": 0, "theta": 0}, "covariance": [[1e999,0,0],[0,1,0],[0,0,1]]}'
    with pytest.raises(BadRequestError, match="finite"):
        from_json(SetPose, body)


@pytest.mark.parametrize("numbers", [[300], [1.5], [-129]])
def test_numbers_that_do_not_fit_are_refused(numbers: list[float]) -> None:
    with pytest.raises(BadRequestError, match="cannot hold"):
        from_json(Small, json.dumps({"numbers": numbers}).encode())


def test_numbers_beyond_single_precision_are_refused() -> None:
    with pytest.raises(BadRequestError, match="finite"):
        from_json(Single, b'{"numbers": [1e300]}')


@pytest.mark.parametrize(
    "body",
    [
        b"{",
        b"\xff",
        b"[]",
        b"null",
        b"1",
        b'"forward"',
        b'{"distance": NaN}',
        b'{"distance": Infinity}',
        b'{"distance": "1"}',
        b'{"distance": true}',
        b'{"distance": null}',
        b'{"distance": 0}',
        b'{"distance": -1}',
        b'{"distance": 1e999}',
        b'{"distance": 1, "distance": 2}',
        b'{"distance": 1, "loud": true}',
        b"{}",
        b"[" * 100_000,
        b'{"distance": 1' + b"0" * 5000 + b"}",
    ],
)
def test_anything_else_is_refused_in_one_line(body: bytes) -> None:
    with pytest.raises(BadRequestError) as refusal:
        from_json(Drive, body)
    assert "\n" not in str(refusal.value)
