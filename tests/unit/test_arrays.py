"""Arrays as message fields."""

from typing import Annotated

import numpy as np
import pytest
from pydantic import ValidationError

from pilotage_schemas.arrays import Float32Array, Float64Array, Int8Array, Nd
from pilotage_schemas.message import Part


class Grids(Part):
    """Every kind of array a message has."""

    cells: Annotated[Int8Array, Nd("int8", "rows,cols")]
    shades: Annotated[Float32Array, Nd("float32", "rows,cols", finite=False)]
    covariance: Annotated[Float64Array, Nd("float64", "3,3")]


def grids(**changes: object) -> Grids:
    fields = {
        "cells": np.zeros((2, 4), np.int8),
        "shades": np.zeros((2, 4), np.float32),
        "covariance": np.eye(3),
    }
    return Grids.model_validate(fields | changes)


def test_a_fitting_array_is_accepted() -> None:
    assert grids().cells.shape == (2, 4)


def test_an_accepted_array_cannot_be_written() -> None:
    with pytest.raises(ValueError, match="read-only"):
        grids().cells[0, 0] = 1


def test_the_senders_own_array_stays_writable() -> None:
    mine = np.zeros((2, 4), np.int8)
    grids(cells=mine)
    mine[0, 0] = 1
    assert mine[0, 0] == 1


@pytest.mark.parametrize("other", [np.uint8, np.int16, np.float32, np.bool_])
def test_another_dtype_is_refused(other: type) -> None:
    with pytest.raises(ValidationError, match="dtype must be int8"):
        grids(cells=np.zeros((2, 4), other))


def test_the_other_byte_order_is_refused() -> None:
    with pytest.raises(ValidationError, match="dtype must be float64"):
        grids(covariance=np.eye(3).astype(">f8"))


@pytest.mark.parametrize("shape", [(8,), (2, 4, 1), ()])
def test_another_rank_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValidationError, match=r"shape must be \(rows,cols\)"):
        grids(cells=np.zeros(shape, np.int8))


def test_another_fixed_length_is_refused() -> None:
    with pytest.raises(ValidationError, match=r"shape must be \(3,3\), not \(2, 2\)"):
        grids(covariance=np.eye(2))


def test_axes_of_one_name_must_agree() -> None:
    with pytest.raises(ValidationError, match="shades has 5 along 'cols', others 4"):
        grids(shades=np.zeros((2, 5), np.float32))


@pytest.mark.parametrize("value", [[[0] * 4] * 2, "0", None, 0, b"00000000"])
def test_what_is_no_array_is_refused(value: object) -> None:
    with pytest.raises(ValidationError, match="an array is needed"):
        grids(cells=value)


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 1e300, -1.1e9])
def test_a_number_that_is_not_finite_is_refused(number: float) -> None:
    with pytest.raises(ValidationError, match="values must be finite"):
        grids(covariance=np.full((3, 3), number))


def test_no_return_is_plus_infinity() -> None:
    shades = np.full((2, 4), np.inf, np.float32)
    assert np.isinf(grids(shades=shades).shades).all()


@pytest.mark.parametrize("number", [np.nan, -np.inf, 1e30])
def test_no_return_is_nothing_else(number: float) -> None:
    with pytest.raises(ValidationError, match=r"numbers no larger than 1e\+09, or \+infinity"):
        grids(shades=np.full((2, 4), number, np.float32))


def test_too_many_elements_are_refused() -> None:
    huge = np.broadcast_to(np.int8(0), (10_000, 10_000))
    with pytest.raises(ValidationError, match="too many elements: 100000000"):
        grids(cells=huge)


def test_an_empty_array_has_a_shape_too() -> None:
    empty = grids(cells=np.zeros((0, 4), np.int8), shades=np.zeros((0, 4), np.float32))
    assert empty.cells.shape == (0, 4)


def test_the_schema_names_dtype_and_axes() -> None:
    cells = Grids.model_json_schema()["properties"]["cells"]
    assert cells["x-dtype"] == "int8"
    assert cells["x-axes"] == ["rows", "cols"]
