"""The file `session.npz` of a stored map: what mapping needs to go on with it.

It may come from anybody who may upload maps, so what it holds is not believed.
"""

import io
import zipfile
import zlib
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.mapping_session import MappingSession

Sensor = Literal["laser", "sonar"]

LARGEST = 2**30
"""Bytes of all arrays unpacked; a day's session has a tenth of that."""

UNREADABLE = (
    *(KeyError, ValueError, TypeError, OSError, EOFError, MemoryError),
    # Encrypted or packed in a way of which nobody knows (RuntimeError), cut off, damaged.
    *(RuntimeError, zipfile.BadZipFile, zlib.error),
)

UNFIT = (KeyError, ValueError, TypeError, IndexError, OverflowError, MemoryError)
"""What arrays of other shapes and kinds lead to."""


def packed_session(sensor: str | None, session: MappingSession) -> bytes:
    """Return the content of the file."""
    made = io.BytesIO()
    remembered: dict[str, Any] = dict(session.remember())
    np.savez_compressed(made, sensor=np.array(sensor), **remembered)
    return made.getvalue()


def unpacked_session(content: bytes) -> tuple[Sensor, dict[str, NDArray[Any]]]:
    """Return the sensor that made a map and the arrays of the run; ValueError if damaged."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            size = sum(info.file_size for info in archive.infolist())
        if size > LARGEST:
            raise ValueError(f"unpacked it has {size} bytes; {LARGEST} are taken at most")
        with np.load(io.BytesIO(content), allow_pickle=False) as kept:
            arrays = {name: kept[name] for name in kept.files}
        return "sonar" if str(arrays.pop("sensor")) == "sonar" else "laser", arrays
    except UNREADABLE as error:
        raise ValueError(f"it is damaged: {error}") from error


def resume_session(session: MappingSession, arrays: dict[str, NDArray[Any]]) -> None:
    """Let a session go on from such arrays; ValueError if they do not fit."""
    try:
        session.resume(arrays)
    except UNFIT as error:
        raise ValueError(f"it does not fit: {error}") from error
