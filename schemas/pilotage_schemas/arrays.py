"""Numpy arrays as message fields: dtype, shape and finiteness are part of the type.

    class LaserScan(Message):
        ranges: Annotated[Float32Array, Nd("float32", "n", finite=False)]

A field accepts an ndarray of exactly that dtype and rank, nothing else: no lists, no casts.
Axes named alike within a message are checked against each other by `Message`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

Float32Array = NDArray[np.float32]
Float64Array = NDArray[np.float64]
Int8Array = NDArray[np.int8]

MAX_ELEMENTS = 64_000_000
"""Largest array a message may hold: a map of 400 m x 400 m at 0.05 m."""


LARGEST = 1e9
"""No number of a robot is larger, in SI units; its square still fits a float32."""

SMALLEST = 1e-9
"""No number that must be positive is smaller, so dividing by it stays harmless."""


@dataclass(frozen=True)
class Nd:
    """An array of `dtype` whose `axes` are numbers (fixed) or names (free, equal when alike).

    Args:
        dtype: numpy name, e.g. "float32".
        axes: comma-separated, e.g. "n,4" or "rows,cols".
        finite: refuse infinities; else +infinity ("no return") is allowed. NaN never is, nor a
            number beyond `LARGEST`.
    """

    dtype: str
    axes: str
    finite: bool = True

    @property
    def shape(self) -> tuple[int | str, ...]:
        """The axes as numbers and names."""
        return tuple(int(a) if a.isdigit() else a for a in self.axes.split(","))

    def check(self, value: Any) -> NDArray[Any]:  # noqa: ANN401 - any input must be refused clearly
        """Return the array read-only, or raise PydanticCustomError saying what is wrong."""
        if not isinstance(value, np.ndarray):
            raise self._error("an array is needed, not {got}", got=type(value).__name__)
        if value.dtype != np.dtype(self.dtype):
            raise self._error("dtype must be {dtype}, not {got}", got=str(value.dtype))
        if not self._fits(value.shape):
            raise self._error("shape must be ({axes}), not {got}", got=str(value.shape))
        if value.size > MAX_ELEMENTS:
            raise self._error("too many elements: {got}", got=str(value.size))
        if np.issubdtype(value.dtype, np.floating):
            self._check_numbers(value)
        frozen = value.view()
        frozen.flags.writeable = False
        return frozen

    def _fits(self, shape: tuple[int, ...]) -> bool:
        return len(shape) == len(self.shape) and all(
            isinstance(wanted, str) or wanted == got
            for wanted, got in zip(self.shape, shape, strict=True)
        )

    def _check_numbers(self, value: NDArray[Any]) -> None:
        fits = np.abs(value) <= LARGEST
        if not self.finite:
            fits |= value == np.inf
        if not fits.all():
            raise self._error(
                "values must be finite and no larger than {largest}"
                if self.finite
                else "values must be numbers no larger than {largest}, or +infinity",
                got="",
            )

    def _error(self, template: str, got: str) -> PydanticCustomError:
        context = {"dtype": self.dtype, "axes": self.axes, "got": got, "largest": f"{LARGEST:g}"}
        return PydanticCustomError("array", template, context)

    def __get_pydantic_core_schema__(
        self,
        _source: Any,  # noqa: ANN401 - pydantic's signature
        _handler: GetCoreSchemaHandler,
    ) -> CoreSchema:
        """Validate by `check` alone."""
        return core_schema.no_info_plain_validator_function(self.check)

    def __get_pydantic_json_schema__(
        self, _schema: CoreSchema, _handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Describe the array as binary data with its dtype and axes (tags of RFC 8746)."""
        return {
            "type": "string",
            "contentEncoding": "binary",
            "description": f"{self.dtype} array ({self.axes}), RFC 8746 typed array in CBOR",
            "x-dtype": self.dtype,
            "x-axes": list(self.shape),
            "x-finite": self.finite,
        }
