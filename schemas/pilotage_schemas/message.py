"""What every message has: when it was measured, in which frame, and its number."""

from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from pilotage_schemas.arrays import LARGEST, SMALLEST, Nd

Finite = Annotated[float, Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0.0, le=LARGEST, allow_inf_nan=False)]
Positive = Annotated[float, Field(ge=SMALLEST, le=LARGEST, allow_inf_nan=False)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0, allow_inf_nan=False)]
Name = Annotated[str, Field(max_length=64)]
Text = Annotated[str, Field(max_length=2000)]


class Part(BaseModel):
    """A frozen, strict group of fields; unknown fields are errors."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid")

    @model_validator(mode="after")
    def _axes_named_alike_are_equally_long(self) -> Self:
        lengths: dict[str, int] = {}
        for name, field in type(self).model_fields.items():
            for mark in field.metadata:
                if isinstance(mark, Nd):
                    self._compare(name, mark, lengths)
        return self

    def _compare(self, name: str, mark: Nd, lengths: dict[str, int]) -> None:
        value: Any = getattr(self, name)
        for axis, length in zip(mark.shape, value.shape, strict=True):
            if isinstance(axis, str) and lengths.setdefault(axis, length) != length:
                raise ValueError(f"{name} has {length} along '{axis}', others {lengths[axis]}")


class Message(Part):
    """A message on the bus.

    A derived message carries the stamp of the measurement that caused it, so `now - stamp_ns`
    is the end-to-end latency. `seq` is given by the publisher, one more than the last.
    """

    stamp_ns: Annotated[int, Field(ge=0, lt=2**63, description="time of measurement, Unix, ns")]
    frame_id: Annotated[str, Field(max_length=64, description="frame of the data (REP 105)")]
    seq: Annotated[int, Field(ge=0, lt=2**63, description="publisher's count")] = 0
