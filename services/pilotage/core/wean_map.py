"""The text format of the CMU Wean Hall map: a header, then one probability per cell.

The first index of the values is x and the second y; 1 is surely free, 0 surely a wall, -1
unknown; the header gives the cell size in cm.
"""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OCCUPIED, UNKNOWN, GridGeometry, OccupancyMap
from pilotage.core.map_image import MapFileError
from pilotage.core.map_shades import FREE_THRESH, OCCUPIED_THRESH

_HEADER_BYTES = 4096
_SIZE = re.compile(rb"^global_map\[0\]:\s*(\d{1,6})\s+(\d{1,6})[ \t]*$", re.MULTILINE)
_RESOLUTION = re.compile(rb"^robot_specifications->resolution\s+(\S+)\s*$", re.MULTILINE)


def is_wean_map(content: bytes) -> bool:
    """Say whether the content of a file begins like a Wean Hall map."""
    header = content[:_HEADER_BYTES]
    return b"global_map[0]:" in header or b"robot_specifications->" in header


def read_wean_map(content: bytes, file: Path) -> OccupancyMap:
    """Return the map in `content`; `file` is named in errors.

    Raises:
        MapFileError: the header is incomplete, or the values are damaged or of another number.
    """
    header = content[:_HEADER_BYTES]
    size, resolution = _SIZE.search(header), _RESOLUTION.search(header)
    if size is None or resolution is None:
        raise MapFileError(f"{file}: the header lacks the map's size or resolution")
    cols, rows = int(size[1]), int(size[2])
    values = _values(content[size.end() :], file)
    if values.size != rows * cols or not values.size:
        raise MapFileError(f"{file}: {values.size} cells instead of {cols} x {rows}")
    geometry = GridGeometry(rows, cols, _resolution(resolution[1], file))
    return OccupancyMap(geometry, _cells(values.reshape(cols, rows).T))


def _values(text: bytes, file: Path) -> NDArray[np.float64]:
    """Return the probabilities (n,) of being free; negative where unknown."""
    try:
        values = np.array(list(map(float, text.split())))
    except ValueError:
        raise MapFileError(f"{file}: some cells are not numbers") from None
    if not np.all(values <= 1.0) or np.any(np.isinf(values)):
        raise MapFileError(f"{file}: some cells are not probabilities")
    return values


def _resolution(text: bytes, file: Path) -> float:
    """Return the cell size in m from its text in cm."""
    try:
        centimetres = float(text)
    except ValueError:
        centimetres = 0.0
    if not 0.0 < centimetres < np.inf:
        raise MapFileError(f"{file}: the resolution must be a positive number of cm")
    return centimetres / 100.0


def _cells(free: NDArray[np.float64]) -> NDArray[np.int8]:
    """Return occupancy cells from probabilities of being free, same shape.

    Around its corridors the map guesses 0.5 to 0.8, never seen; by map_server's thresholds that
    is unknown, and a robot cannot be there.
    """
    occupancy = 1.0 - free
    is_guess = (occupancy >= FREE_THRESH) & (occupancy <= OCCUPIED_THRESH)
    percent = np.round(OCCUPIED * occupancy)
    cells = np.where(is_guess | (free < 0.0), UNKNOWN, percent).astype(np.int8)
    return np.ascontiguousarray(cells)
