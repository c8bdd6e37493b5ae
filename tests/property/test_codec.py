"""Laws of the codec: what goes in comes out, and nothing else comes out than errors."""

import math
from typing import Any

import cbor2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pilotage_schemas.codec import DecodeError, decode, encode
from pilotage_schemas.message import Part
from pilotage_schemas.topics import QUERIES, TOPICS
from strategies import cbor_bytes, cbor_values, parts

KINDS: list[type[Part]] = sorted(
    {topic.message for topic in TOPICS.values()}
    | {kind for query in QUERIES.values() for kind in (query.request, query.reply)},
    key=lambda kind: kind.__name__,
)
every_kind = pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
any_kind = st.sampled_from(KINDS)
many = settings(max_examples=100)


def same(one: object, other: object) -> bool:
    """Equality that looks into arrays, parts and tuples."""
    if isinstance(one, Part) and isinstance(other, Part):
        names = type(one).model_fields
        return type(one) is type(other) and all(
            same(getattr(one, n), getattr(other, n)) for n in names
        )
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other


def decodes_or_refuses(kind: type[Part], payload: bytes) -> None:
    """Decode; a DecodeError of one short line is the only other way out."""
    outcome = decoded_or_error(kind, payload)
    if isinstance(outcome, DecodeError):
        assert str(outcome).isprintable()
        assert len(str(outcome)) <= 300
    else:
        assert isinstance(outcome, kind)


def decoded_or_error(kind: type[Part], payload: bytes) -> Part | DecodeError:
    try:
        return decode(kind, payload)
    except DecodeError as error:
        return error


@every_kind
@settings(max_examples=12)
@given(data=st.data())
def test_every_message_comes_back_as_it_went(kind: type[Part], data: st.DataObject) -> None:
    message = data.draw(parts(kind))
    assert same(decode(kind, encode(message)), message)


@many
@given(kind=any_kind, payload=st.binary(max_size=200))
def test_random_bytes_are_refused(kind: type[Part], payload: bytes) -> None:
    with pytest.raises(DecodeError):
        decode(kind, payload)


@many
@given(kind=any_kind, payload=cbor_bytes())
def test_any_cbor_is_decoded_or_refused(kind: type[Part], payload: bytes) -> None:
    decodes_or_refuses(kind, payload)


@many
@given(kind=any_kind, data=st.data())
def test_a_flipped_byte_is_decoded_or_refused(kind: type[Part], data: st.DataObject) -> None:
    payload = bytearray(encode(data.draw(parts(kind))))
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(payload) - 1))
        payload[place] = data.draw(st.integers(0, 255))
    decodes_or_refuses(kind, bytes(payload))


@many
@given(kind=any_kind, data=st.data())
def test_a_truncated_message_is_refused(kind: type[Part], data: st.DataObject) -> None:
    payload = encode(data.draw(parts(kind)))
    length = data.draw(st.integers(0, len(payload) - 1))
    with pytest.raises(DecodeError):
        decode(kind, payload[:length])


@many
@given(kind=any_kind, data=st.data(), rest=st.binary(min_size=1, max_size=20))
def test_bytes_after_the_message_are_refused(
    kind: type[Part], data: st.DataObject, rest: bytes
) -> None:
    payload = encode(data.draw(parts(kind)))
    with pytest.raises(DecodeError):
        decode(kind, payload + rest)


@many
@given(kind=any_kind, data=st.data())
def test_an_unknown_field_is_refused(kind: type[Part], data: st.DataObject) -> None:
    fields = as_cbor(data.draw(parts(kind))) | {"unheard_of": data.draw(cbor_values())}
    with pytest.raises(DecodeError):
        decode(kind, cbor2.dumps(fields))


@many
@given(kind=any_kind, data=st.data())
def test_any_value_in_any_field_is_decoded_or_refused(
    kind: type[Part], data: st.DataObject
) -> None:
    fields = as_cbor(data.draw(parts(kind)))
    if fields:
        name = data.draw(st.sampled_from(sorted(fields)))
        fields[name] = data.draw(cbor_values())
    decodes_or_refuses(kind, cbor2.dumps(fields))


@many
@given(kind=any_kind, data=st.data())
def test_no_number_decodes_to_nan(kind: type[Part], data: st.DataObject) -> None:
    fields = as_cbor(data.draw(parts(kind)))
    numbers = [name for name, value in fields.items() if isinstance(value, float)]
    for name in numbers:
        with pytest.raises(DecodeError):
            decode(kind, cbor2.dumps(fields | {name: math.nan}))


def as_cbor(part: Part) -> dict[str, Any]:
    """The fields of a part as plain CBOR values."""
    fields: dict[str, Any] = cbor2.loads(encode(part))
    return fields
