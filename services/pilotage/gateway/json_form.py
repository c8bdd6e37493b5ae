"""Messages as JSON and back: arrays are nested lists, "no return" (infinity) is null."""

import json
import math
from typing import Any, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from pilotage_schemas.arrays import LARGEST, Nd
from pilotage_schemas.message import Part

Request = TypeVar("Request", bound=Part)
Json = dict[str, Any]

DECIMALS = 6
"""Of float32 values: a micrometre, where their own digits end."""


EXACT = 2.0**53
"""Below this a float holds every integer."""


class BadRequestError(ValueError):
    """JSON that is not a request of the wanted kind; the text says why, in one line."""


def to_json(message: Part) -> Json:
    """Return the message's fields in JSON's own types."""
    return {name: _plain(getattr(message, name)) for name in type(message).model_fields}


def from_json(kind: type[Request], body: bytes) -> Request:
    """Return the request of type `kind` in `body`, where nothing means {}, or BadRequestError."""
    try:
        fields = json.loads(
            body or b"{}",
            parse_constant=_refuse_constant,
            parse_float=_number,
            object_pairs_hook=_unique,
        )
    except (ValueError, RecursionError) as error:
        raise BadRequestError(f"the body is not valid JSON: {error}") from error
    if not isinstance(fields, dict):
        raise BadRequestError("a JSON object is needed")
    try:
        return kind.model_validate(_with_arrays(kind, fields))
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(str(part) for part in first["loc"]) or "body"
        raise BadRequestError(f"{place}: {first['msg']}") from error


def schema_of(kind: type[Part], *, is_reply: bool = True) -> Json:
    """Return the JSON Schema of a message's JSON form, self-contained."""
    schema = kind.model_json_schema(mode="serialization" if is_reply else "validation")
    described: Json = _described(schema, schema.get("$defs", {}))
    described.pop("$defs", None)
    return described


def _refuse_constant(name: str) -> None:
    raise ValueError(f"{name} is not JSON")


def _number(text: str) -> float:
    """Return a number; to JSON Schema 7.0 is an integer as much as 7 is."""
    value = float(text)
    return int(value) if abs(value) < EXACT and value == int(value) else value


def _unique(pairs: list[tuple[str, object]]) -> dict[str, object]:
    fields = dict(pairs)
    if len(fields) != len(pairs):
        raise ValueError("a key appears twice")
    return fields


def _plain(value: object) -> object:
    match value:
        case Part():
            return to_json(value)
        case np.ndarray():
            return _nested(value)
        case tuple():
            return [_plain(item) for item in value]
        case float() if not math.isfinite(value):
            return None
    return value


def _nested(array: NDArray[Any]) -> object:
    if array.dtype.kind != "f":
        return array.tolist()
    rounded = array.astype(np.float64)
    if array.dtype == np.float32:
        rounded = rounded.round(DECIMALS)
    if np.isfinite(rounded).all():
        return rounded.tolist()
    holed = rounded.astype(object)
    holed[~np.isfinite(rounded)] = None
    return holed.tolist()


def _with_arrays(kind: type[Part], fields: Json) -> Json:
    """Return the fields with nested lists turned into arrays wherever `kind` has arrays."""
    return {name: _array_or_same(kind, name, value) for name, value in fields.items()}


def _array_or_same(kind: type[Part], name: str, value: object) -> object:
    field = kind.model_fields.get(name)
    if field is None:
        return value
    alternatives = (field.annotation, *get_args(field.annotation))
    mark = next((m for m in (*field.metadata, *_marks(alternatives)) if isinstance(m, Nd)), None)
    if mark is not None and isinstance(value, list):
        return _array(mark, name, value)
    nested = next((a for a in alternatives if isinstance(a, type) and issubclass(a, Part)), None)
    if nested is not None and isinstance(value, dict):
        return _with_arrays(nested, value)
    return value


def _marks(alternatives: tuple[Any, ...]) -> list[Any]:
    return [mark for a in alternatives for mark in getattr(a, "__metadata__", ())]


def _array(mark: Nd, name: str, value: list[Any]) -> NDArray[Any]:
    try:
        array = np.array(value)
    except ValueError as error:
        raise BadRequestError(f"{name}: rows of unequal length") from error
    if array.dtype.kind not in "iuf" or _has_boolean(value):
        raise BadRequestError(f"{name}: numbers are needed")
    with np.errstate(over="ignore", invalid="ignore"):
        cast = array.astype(mark.dtype)
    if cast.dtype.kind != "f" and not np.array_equal(cast, array):
        raise BadRequestError(f"{name}: {mark.dtype} cannot hold these numbers")
    return cast


def _has_boolean(value: object) -> bool:
    if isinstance(value, list):
        return any(_has_boolean(item) for item in value)
    return isinstance(value, bool)


def _described(node: Any, definitions: Json) -> Any:  # noqa: ANN401 - any part of a JSON Schema
    """Return the schema with references replaced by what they mean, arrays as nested lists."""
    if isinstance(node, list):
        return [_described(item, definitions) for item in node]
    if not isinstance(node, dict):
        return node
    if "$ref" in node:
        rest = {key: value for key, value in node.items() if key != "$ref"}
        return _described(definitions[node["$ref"].rsplit("/", 1)[-1]] | rest, definitions)
    if "x-axes" in node:
        return _nested_schema(node)
    return {key: _described(value, definitions) for key, value in node.items() if key != "$defs"}


def _nested_schema(mark: Json) -> Json:
    is_float = mark["x-dtype"].startswith("float")
    number = "number" if is_float else "integer"
    schema: Json = {"type": number if mark["x-finite"] else [number, "null"]}
    if is_float:
        schema |= {"minimum": -LARGEST, "maximum": LARGEST}
    for axis in reversed(mark["x-axes"]):
        schema = {"type": "array", "items": schema}
        if isinstance(axis, int):
            schema |= {"minItems": axis, "maxItems": axis}
    return schema
