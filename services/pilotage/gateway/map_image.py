"""An occupancy grid as the files that map_server and browsers read.

The palette is map_server's: 0 occupied, 254 free, 205 unknown. Row 0 of the grid is its
bottom, row 0 of an image its top.
"""

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pilotage_schemas.mapping import OccupancyGrid

OCCUPIED_SHADE, FREE_SHADE, UNKNOWN_SHADE = 0, 254, 205
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
"""map_server's thresholds; 205 reads as 0.19608, so from 0.197 on unknown would become free."""

FAST = 1
"""zlib level: a hundredth of a second for a million cells, a fifth larger than the best."""


def shades(cells: NDArray[np.int8]) -> NDArray[np.uint8]:
    """Return the image (rows, cols) of cells -1, 0..100, top row first."""
    image = np.full(cells.shape, UNKNOWN_SHADE, np.uint8)
    image[(cells >= 0) & (cells <= 100 * FREE_THRESH)] = FREE_SHADE
    image[cells >= 100 * OCCUPIED_THRESH] = OCCUPIED_SHADE
    return image[::-1]


def png(grid: OccupancyGrid) -> bytes:
    """Return the map as a PNG of one grey channel."""
    buffer = io.BytesIO()
    image = np.ascontiguousarray(shades(grid.cells))
    Image.fromarray(image).save(buffer, format="PNG", compress_level=FAST)
    return buffer.getvalue()


def pgm(grid: OccupancyGrid) -> bytes:
    """Return the map as a binary PGM."""
    rows, cols = grid.cells.shape
    return b"P5\n%d %d\n255\n" % (cols, rows) + shades(grid.cells).tobytes()


def yaml(grid: OccupancyGrid) -> bytes:
    """Return map_server's YAML for the image of `pgm`, under the name `map.pgm`."""
    origin = ", ".join(repr(float(v)) for v in (grid.origin.x, grid.origin.y, grid.origin.theta))
    text = (
        "image: map.pgm\n"
        "mode: trinary\n"
        f"resolution: {grid.resolution!r}\n"
        f"origin: [{origin}]\n"
        "negate: 0\n"
        f"occupied_thresh: {OCCUPIED_THRESH}\n"
        f"free_thresh: {FREE_THRESH}\n"
    )
    return text.encode()
