"""Hypothesis strategies: any valid message of a type, and any CBOR whatsoever."""

import types
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import cbor2
import numpy as np
from annotated_types import Ge, Gt, Le, Lt, MaxLen
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pydantic.fields import FieldInfo

from pilotage_schemas.arrays import LARGEST, Nd
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.mapping import FARTHEST, OccupancyGrid
from pilotage_schemas.message import Part
from pilotage_schemas.topology import MatchedPairs

MAX_LENGTH = 5
Lengths = dict[str, int]


@st.composite
def parts(draw: st.DrawFn, kind: type[Part]) -> Part:
    """Any valid instance of `kind`; axes named alike get the same length."""
    lengths = _Lengths(draw)
    values: dict[str, Any] = {
        name: draw(_of(field.annotation, list(field.metadata), lengths))
        for name, field in kind.model_fields.items()
    }
    if kind is OccupancyGrid:
        values["origin"] = draw(origins())
    if kind is MatchedPairs:
        size = len(values["seen"])
        words = st.sampled_from(["line", "corner", "door", "passage"])
        values["kinds"] = tuple(draw(st.lists(words, min_size=size, max_size=size)))
    return kind(**values)


def origins() -> st.SearchStrategy[Pose2]:
    """Poses at which a map may lie."""
    return st.builds(
        Pose2,
        x=st.floats(-FARTHEST, FARTHEST),
        y=st.floats(-FARTHEST, FARTHEST),
        theta=st.floats(-3.1415, 3.1415),
    )


class _Lengths(Lengths):
    """Draws the length of each named axis when it is first asked for."""

    def __init__(self, draw: st.DrawFn) -> None:
        super().__init__()
        self._draw = draw

    def __missing__(self, axis: str) -> int:
        self[axis] = self._draw(st.integers(0, MAX_LENGTH))
        return self[axis]


def _of(annotation: object, marks: list[Any], lengths: Lengths) -> st.SearchStrategy[Any]:
    marks = [inner for mark in marks for inner in _unfolded(mark)]
    arrays = [mark for mark in marks if isinstance(mark, Nd)]
    if arrays:
        return _arrays(arrays[0], lengths)
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _of(arguments[0], [*arguments[1:], *marks], lengths)
    if origin in (Union, types.UnionType):
        return st.one_of([_of(choice, marks, lengths) for choice in arguments])
    if origin is Literal:
        return st.sampled_from(arguments)
    if origin is tuple:
        return st.lists(_of(arguments[0], [], lengths), max_size=MAX_LENGTH).map(tuple)
    return _plain(annotation, marks)


def _unfolded(mark: object) -> list[Any]:
    return list(mark.metadata) if isinstance(mark, FieldInfo) else [mark]


def _plain(annotation: object, marks: list[Any]) -> st.SearchStrategy[Any]:
    if annotation is type(None):
        return st.none()
    if annotation is bool:
        return st.booleans()
    if annotation is str:
        longest = min([20, *(mark.max_length for mark in marks if isinstance(mark, MaxLen))])
        return st.text(max_size=longest)
    if annotation is int:
        return st.integers(*_bounds(marks, step=1))
    if annotation is float:
        low, high = _bounds(marks, step=0)
        return st.floats(
            low,
            high,
            exclude_min=any(isinstance(mark, Gt) for mark in marks),
            exclude_max=any(isinstance(mark, Lt) for mark in marks),
            allow_nan=False,
            allow_infinity=False,
        )
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return parts(annotation)
    raise TypeError(f"no strategy for {annotation}")


def _bounds(marks: list[Any], step: int) -> tuple[Any, Any]:
    low: list[Any] = [mark.ge for mark in marks if isinstance(mark, Ge)]
    high: list[Any] = [mark.le for mark in marks if isinstance(mark, Le)]
    above: list[Any] = [mark.gt for mark in marks if isinstance(mark, Gt)]
    below: list[Any] = [mark.lt for mark in marks if isinstance(mark, Lt)]
    low += [bound + step for bound in above]
    high += [bound - step for bound in below]
    return max(low, default=None), min(high, default=None)


def _arrays(mark: Nd, lengths: Lengths) -> st.SearchStrategy[Any]:
    shape = tuple(lengths[axis] if isinstance(axis, str) else axis for axis in mark.shape)
    dtype = np.dtype(mark.dtype)
    if dtype.kind != "f":
        return hnp.arrays(dtype, shape)
    width = 8 * dtype.itemsize
    numbers = st.floats(-LARGEST, LARGEST, width=width)  # type: ignore[arg-type]  # 32 or 64
    elements = numbers if mark.finite else numbers | st.just(float("inf"))
    return hnp.arrays(dtype, shape, elements=elements)


def cbor_values() -> st.SearchStrategy[object]:
    """Any value CBOR can hold: numbers, NaN, texts, bytes, arrays, maps, tags, undefined."""
    leaves = st.one_of(
        st.none(),
        st.booleans(),
        st.integers(-(2**70), 2**70),
        st.floats(),
        st.text(max_size=8),
        st.binary(max_size=16),
        st.just(cbor2.undefined),
    )
    return st.recursive(
        leaves,
        lambda inner: st.one_of(
            st.lists(inner, max_size=4),
            st.dictionaries(st.text(max_size=6) | st.integers(), inner, max_size=4),
            st.builds(cbor2.CBORTag, st.integers(0, 300), inner),
        ),
        max_leaves=12,
    )


def cbor_bytes() -> st.SearchStrategy[bytes]:
    """Any well-formed CBOR."""
    return cbor_values().map(cbor2.dumps)
