"""Strict CBOR: messages to bytes and back, numpy arrays as typed arrays of RFC 8746.

Decoding refuses what a healthy sender never produces: unknown fields, wrong dtypes or shapes,
numbers that are not finite where they must be, trailing bytes, duplicate keys, deep nesting,
tags other than those of arrays, oversize payloads. It raises `DecodeError` and nothing else.
"""

import io
import math
from collections.abc import Callable
from typing import Any, TypeVar

import cbor2
import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from pilotage_schemas.message import Part

MAX_PAYLOAD = 70_000_000
MAX_DEPTH = 16
MAX_REASON = 300
ROW_MAJOR = 40
"""Tag of a multi-dimensional array: [[dimensions], typed array] (RFC 8746, section 3.1.1)."""

DTYPE_OF_TAG = {64: "<u1", 72: "|i1", 69: "<u2", 70: "<u4", 77: "<i2", 78: "<i4", 79: "<i8"} | {
    84: "<f2",
    85: "<f4",
    86: "<f8",
}
LOW_TAGS_OF_CBOR2 = (*range(6), 25, 28, 29, 30, 35, 36, 37, 52, 54, 100)
TAGS_OF_CBOR2 = (*LOW_TAGS_OF_CBOR2, 256, 258, 260, 261, 1004, 43000, 55799)
"""Dates, big numbers, patterns, references, addresses, sets: refused, and never even built."""

TAG_OF_DTYPE = {np.dtype(name): tag for tag, name in DTYPE_OF_TAG.items()}

Decoded = TypeVar("Decoded", bound=Part)


class DecodeError(ValueError):
    """The bytes are not a valid message; the text says why, in one line."""


def encode(message: Part) -> bytes:
    """Return the message as CBOR."""
    fields = {name: getattr(message, name) for name in type(message).model_fields}
    return cbor2.dumps(fields, default=_encode_special)


def decode(kind: type[Decoded], payload: bytes) -> Decoded:
    """Return the message of type `kind` held by `payload` or raise DecodeError."""
    fields = _load(payload)
    if not isinstance(fields, dict):
        raise DecodeError(f"{kind.__name__}: a map of fields is needed")
    try:
        return kind.model_validate(fields)
    except ValidationError as error:
        raise DecodeError(f"{kind.__name__}: {reason(error)}"[:MAX_REASON]) from error


def reason(error: ValueError) -> str:
    """Return in one short line why a message could not be made: its first fault."""
    return _one_line(_first_reason(error) if isinstance(error, ValidationError) else str(error))


def _encode_special(encoder: cbor2.CBOREncoder, value: object) -> None:
    if isinstance(value, Part):
        encoder.encode({name: getattr(value, name) for name in type(value).model_fields})
    elif isinstance(value, np.ndarray):
        encoder.encode(_tagged(value))
    else:
        raise TypeError(f"{type(value).__name__} has no place in a message")


def _tagged(array: NDArray[Any]) -> cbor2.CBORTag:
    typed = cbor2.CBORTag(TAG_OF_DTYPE[array.dtype], array.tobytes())
    if array.ndim == 1:
        return typed
    return cbor2.CBORTag(ROW_MAJOR, [list(array.shape), typed])


def _load(payload: bytes) -> object:
    if len(payload) > MAX_PAYLOAD:
        raise DecodeError(f"{len(payload)} bytes are more than a message may have")
    stream = io.BytesIO(payload)
    try:
        value: object = cbor2.CBORDecoder(
            stream,
            tag_hook=_untagged,
            semantic_decoders=REFUSALS,
            allow_duplicate_keys=False,
            allow_indefinite=False,
            max_depth=MAX_DEPTH,
        ).decode()
    except (cbor2.CBORError, ValueError, TypeError, OverflowError, MemoryError) as error:
        raise DecodeError(_one_line(f"not valid CBOR: {error.__cause__ or error}")) from error
    if stream.tell() != len(payload):
        raise DecodeError("bytes are left over after the message")
    return value


def _untagged(tag: cbor2.CBORTag, _immutable: bool) -> NDArray[Any]:  # noqa: FBT001 - cbor2's signature
    if tag.tag == ROW_MAJOR:
        return _shaped(tag.value)
    dtype = DTYPE_OF_TAG.get(tag.tag)
    if dtype is None or not isinstance(tag.value, bytes):
        raise ValueError(f"tag {tag.tag} has no place in a message")
    return np.frombuffer(tag.value, dtype)


def _shaped(value: object) -> NDArray[Any]:
    match value:
        case [[*dimensions], np.ndarray() as data]:
            pass
        case _:
            raise ValueError("a multi-dimensional array is [[dimensions], typed array]")
    lengths = [length for length in dimensions if type(length) is int and length >= 0]
    if len(lengths) != len(dimensions) or math.prod(lengths) != data.size:
        raise ValueError(f"the data do not fill {dimensions}")
    return data.reshape(lengths)


def _refuse(tag: int) -> Callable[[object, bool], object]:
    def refuse(_value: object, _immutable: bool) -> object:  # noqa: FBT001 - cbor2's signature
        raise ValueError(f"tag {tag} has no place in a message")

    return refuse


REFUSALS = {tag: _refuse(tag) for tag in TAGS_OF_CBOR2}


def _first_reason(error: ValidationError) -> str:
    first = error.errors(include_url=False, include_input=False)[0]
    place = ".".join(str(part) for part in first["loc"]) or "message"
    return f"{place}: {first['msg']}"


def _one_line(reason: str) -> str:
    """Return the reason short and printable: it may quote the sender."""
    printable = "".join(c if c.isprintable() else " " for c in reason[:MAX_REASON])
    return " ".join(printable.split())
