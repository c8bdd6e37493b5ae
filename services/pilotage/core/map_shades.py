"""What a shade of a map image means, as ROS map_server reads it, and the way back."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import FREE, OCCUPIED, UNKNOWN
from pilotage.core.map_image import Shades

MODES = ("trinary", "scale", "raw")
FREE_SHADE, OCCUPIED_SHADE, UNKNOWN_SHADE = 254, 0, 205
FREE_THRESH, OCCUPIED_THRESH = 0.196, 0.65
"""map_server's own. Shade 205 means 0.19608, so from 0.197 on unknown would load as free."""


@dataclass(frozen=True)
class ShadeReading:
    """How shades become cells: `mode` and, but for raw, thresholds of occupancy 0..1."""

    mode: str
    free_thresh: float
    occupied_thresh: float
    negate: bool
    """White is occupied, not black."""


def cells_from_shades(shades: Shades, reading: ShadeReading) -> NDArray[np.int8]:
    """Return cells (rows, cols), row 0 at the bottom; what mode scale sees through is unknown."""
    values = 1.0 - shades.values if reading.negate else shades.values
    cells = _raw(values) if reading.mode == "raw" else _by_thresholds(values, reading)
    if reading.mode == "scale":
        _grade(cells, 1.0 - values, shades.is_opaque, reading)
    # Image row 0 is the top of the drawing, grid row 0 the bottom.
    return np.ascontiguousarray(cells[::-1])


def pgm_from_cells(cells: NDArray[np.int8]) -> tuple[bytes, str]:
    """Return a binary PGM file, and the mode in which it gives back exactly these cells."""
    is_trinary = bool(np.isin(cells, (UNKNOWN, FREE, OCCUPIED)).all())
    if is_trinary:
        shades = np.full(cells.shape, UNKNOWN_SHADE, np.uint8)
        shades[cells == FREE] = FREE_SHADE
        shades[cells == OCCUPIED] = OCCUPIED_SHADE
    else:
        shades = np.where(cells == UNKNOWN, 255, cells).astype(np.uint8)
    rows, cols = cells.shape
    header = b"P5\n%d %d\n255\n" % (cols, rows)
    return header + shades[::-1].tobytes(), "trinary" if is_trinary else "raw"


def _raw(values: NDArray[np.float64]) -> NDArray[np.int8]:
    """The grey level itself is the cell; above 100 it is unknown."""
    levels = np.round(255.0 * values)
    return np.where(levels <= OCCUPIED, levels, UNKNOWN).astype(np.int8)


def _by_thresholds(values: NDArray[np.float64], reading: ShadeReading) -> NDArray[np.int8]:
    """Free below one threshold of occupancy, occupied above the other, unknown between."""
    cells = np.full(values.shape, UNKNOWN, np.int8)
    cells[1.0 - values < reading.free_thresh] = FREE
    cells[1.0 - values > reading.occupied_thresh] = OCCUPIED
    return cells


def _grade(
    cells: NDArray[np.int8],
    occupancy: NDArray[np.float64],
    is_opaque: NDArray[np.bool_],
    reading: ShadeReading,
) -> None:
    """Give the opaque cells between the thresholds their share from 1 to 99, in place.

    What is not opaque is unknown, whatever its colour, as nav2 has it; ROS 1 took transparent black
    for a wall and transparent white for free.
    """
    cells[~is_opaque] = UNKNOWN
    between = (cells == UNKNOWN) & is_opaque
    span = reading.occupied_thresh - reading.free_thresh
    ratio = (occupancy[between] - reading.free_thresh) / span
    cells[between] = (1.0 + 98.0 * ratio).astype(np.int8)
