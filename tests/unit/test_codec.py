"""The wire format, byte by byte where it matters; its laws are in property/test_codec.py."""

import struct
import tracemalloc
from datetime import UTC, date, datetime
from decimal import Decimal
from fractions import Fraction
from ipaddress import ip_address
from typing import Annotated

import cbor2
import numpy as np
import pytest

from pilotage_schemas.arrays import Float32Array, Nd
from pilotage_schemas.codec import MAX_PAYLOAD, DecodeError, decode, encode
from pilotage_schemas.commands import Done, Kidnap, Nothing
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.mapping import OccupancyGrid
from pilotage_schemas.message import Part
from pilotage_schemas.sensors import LaserScan, Odometry
from sample_messages import grid, odometry, scan


class Picture(Part):
    """One matrix of floats."""

    pixels: Annotated[Float32Array, Nd("float32", "rows,cols")]


def picture(pixels: object) -> bytes:
    return cbor2.dumps({"pixels": pixels})


def typed(values: list[float]) -> cbor2.CBORTag:
    return cbor2.CBORTag(85, struct.pack(f"<{len(values)}f", *values))


def pose(**fields: object) -> bytes:
    return cbor2.dumps({"x": 0.0, "y": 0.0, "theta": 0.0} | fields)


def test_a_vector_travels_as_a_typed_array_of_rfc_8746() -> None:
    fields = cbor2.loads(encode(scan(1)))
    assert fields["ranges"] == cbor2.CBORTag(85, struct.pack("<4f", np.inf, 1, 1, 1))


def test_a_matrix_travels_row_by_row_with_its_dimensions() -> None:
    tag = cbor2.loads(encode(grid(1, rows=3, cols=2)))["cells"]
    assert (tag.tag, list(tag.value[0]), tag.value[1].tag) == (40, [3, 2], 72)
    assert tag.value[1].value == bytes([100, 0, 0, 0, 0, 0])


def test_a_transposed_matrix_arrives_as_it_looks() -> None:
    pixels = np.arange(6, dtype=np.float32).reshape(2, 3).T
    assert (decode(Picture, encode(Picture(pixels=pixels))).pixels == pixels).all()


def test_arrays_arrive_read_only() -> None:
    ranges = decode(LaserScan, encode(scan(1))).ranges
    with pytest.raises(ValueError, match="read-only"):
        ranges[0] = 1.0


def test_parts_and_tuples_nest() -> None:
    request = Kidnap(pose=Pose2(x=1.0, y=2.0, theta=0.5))
    assert decode(Kidnap, encode(request)) == request


def test_an_empty_message_is_an_empty_map() -> None:
    assert encode(Nothing()) == b"\xa0"
    assert decode(Nothing, b"\xa0") == Nothing()


def test_left_out_fields_take_their_defaults() -> None:
    assert decode(Done, b"\xa0") == Done(detail="")


def test_what_is_no_message_cannot_be_encoded() -> None:
    broken = Done.model_construct(detail=object())  # type: ignore[arg-type]  # on purpose
    with pytest.raises(TypeError, match="object has no place in a message"):
        encode(broken)


@pytest.mark.parametrize(
    ("payload", "reason"),
    [
        (b"", "end of stream"),
        (b"\x01", "a map of fields is needed"),
        (b"\x80", "a map of fields is needed"),
        (b"\xf6", "a map of fields is needed"),
        (pose() + b"\x00", "bytes are left over"),
        (pose(z=1.0), "z: Extra inputs are not permitted"),
        (cbor2.dumps({"x": 0.0, "y": 0.0}), "theta: Field required"),
        (pose(x="0"), "x: Input should be a valid number"),
        (pose(x=True), "x: Input should be a valid number"),
        (pose(x=None), "x: Input should be a valid number"),
        (pose(x=cbor2.undefined), "x: Input should be a valid number"),
        (pose(x=float("nan")), "x: Input should be a finite number"),
        (pose(x=float("inf")), "x: Input should be a finite number"),
        (pose(theta=float("nan")), "theta: Input should be"),
        (pose(theta=3.15), "theta: Input should be less than or equal to 3.14"),
        (cbor2.dumps({1: 0.0, "x": 0.0}), "Pose2: "),
        (cbor2.dumps({(1, 2): 0.0}), "Pose2: "),
        (cbor2.dumps({b"x": 0.0}), "Pose2: "),
        (b"\xa2\x61x\x00\x61x\x00", "Duplicate map key"),
        (b"\xbf\x61x\x00\xff", "indefinite length"),
        (b"\xa1\x61\xff\x00", "not valid CBOR"),
        (b"\x81" * 1000 + b"\x00", "nesting depth"),
        (b"\xc6" * 1000 + b"\x00", "nesting depth"),
    ],
)
def test_what_a_healthy_sender_never_sends_is_refused(payload: bytes, reason: str) -> None:
    with pytest.raises(DecodeError, match=reason):
        decode(Pose2, payload)


@pytest.mark.parametrize(
    "value",
    [
        datetime(2026, 1, 1, tzinfo=UTC),
        date(2026, 1, 1),
        2**64,
        -(2**65),
        Decimal("1.5"),
        Fraction(1, 3),
        ip_address("127.0.0.1"),
        {1, 2},
        complex(1, 2),
        cbor2.CBORTag(35, "(a+)+$"),
        cbor2.CBORTag(5, [10**9, 1]),
        cbor2.CBORTag(37, b"0" * 16),
        cbor2.CBORTag(55799, 1.0),
        cbor2.CBORTag(24, b"\x00"),
        cbor2.CBORTag(999_999, 1.0),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_tag_that_is_no_array_is_refused(value: object) -> None:
    with pytest.raises(DecodeError, match=r"tag \d+ has no place in a message"):
        decode(Pose2, pose(x=value))


def test_no_tag_but_those_of_arrays_is_read() -> None:
    """Guards against a newer cbor2 that reads one tag more by itself."""
    for tag in [
        *range(40),
        *range(41, 500),
        1000,
        1001,
        1002,
        1003,
        1004,
        1010,
        21065,
        43000,
        55799,
        65535,
    ]:
        with pytest.raises(DecodeError, match=f"tag {tag} has no place"):
            decode(Pose2, pose(x=cbor2.CBORTag(tag, 1.0)))


@pytest.mark.parametrize(
    "payload",
    [
        bytes.fromhex("d81ca16178 d81d00"),  # a map that holds itself
        bytes.fromhex("a26178 d81c00 6179 d81d00"),
        bytes.fromhex("a16178 d81d00"),
        bytes.fromhex("d90100 a16178 d81900"),
    ],
)
def test_references_are_refused(payload: bytes) -> None:
    with pytest.raises(DecodeError, match=r"tag (25|28|29|256) has no place"):
        decode(Pose2, payload)


@pytest.mark.parametrize(
    "head", ["5b00000fffffffffff", "7b00000fffffffffff", "9b00000fffffffffff", "bb00000fffffffffff"]
)
def test_a_huge_length_allocates_nothing(head: str) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(DecodeError):
            decode(Pose2, b"\xa1\x61x" + bytes.fromhex(head))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1_000_000


def test_an_oversize_payload_is_refused_unread() -> None:
    with pytest.raises(DecodeError, match="more than a message may have"):
        decode(Pose2, bytes(MAX_PAYLOAD + 1))


@pytest.mark.parametrize(
    ("pixels", "reason"),
    [
        (cbor2.CBORTag(40, [[2, 3], typed([1.0] * 5)]), "do not fill"),
        (cbor2.CBORTag(40, [[2, -3], typed([1.0] * 6)]), "do not fill"),
        (cbor2.CBORTag(40, [[2**62, 0], typed([])]), "not valid CBOR"),
        (cbor2.CBORTag(40, [[True, 1], typed([1.0])]), "do not fill"),
        (cbor2.CBORTag(40, [[1] * 100, typed([1.0])]), "not valid CBOR"),
        (cbor2.CBORTag(40, [[1, 1], [1.0]]), "is \\[\\[dimensions\\], typed array\\]"),
        (cbor2.CBORTag(40, [1.0]), "is \\[\\[dimensions\\], typed array\\]"),
        (cbor2.CBORTag(40, [[], typed([1.0])]), r"shape must be \(rows,cols\)"),
        (cbor2.CBORTag(85, b"123"), "multiple of element size"),
        (cbor2.CBORTag(85, "1234"), "tag 85 has no place"),
        (typed([1.0]), r"shape must be \(rows,cols\)"),
        ([[1.0]], "an array is needed"),
        (cbor2.CBORTag(40, [[1, 1], typed([float("nan")])]), "must be finite"),
        (cbor2.CBORTag(40, [[1, 1], cbor2.CBORTag(86, bytes(8))]), "dtype must be float32"),
    ],
)
def test_a_malformed_array_is_refused(pixels: object, reason: str) -> None:
    with pytest.raises(DecodeError, match=reason):
        decode(Picture, picture(pixels))


def test_the_reason_is_one_short_line_whatever_it_quotes() -> None:
    with pytest.raises(DecodeError) as caught:
        decode(Pose2, pose(**{"a\nb\x1b[31m" + "c" * 100_000: 1.0}))
    assert len(str(caught.value)) <= 300
    assert str(caught.value).isprintable()


def test_a_message_of_another_type_is_refused() -> None:
    with pytest.raises(DecodeError, match="LaserScan: "):
        decode(LaserScan, encode(odometry(1)))


def test_numpy_scalars_arrive_as_plain_numbers() -> None:
    sent = odometry(1).model_copy(update={"pose": Pose2(x=np.float64(1.5), y=0.0, theta=0.0)})
    assert type(decode(Odometry, encode(sent)).pose.x) is float


def test_a_whole_building_fits() -> None:
    building = grid(1, rows=5000, cols=5000)
    assert decode(OccupancyGrid, encode(building)).cells.shape == (5000, 5000)
