"""The image of a map file as shades between 0 (black) and 1 (white)."""

import struct
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

FORMATS = ("PPM", "PNG", "BMP")
"""Plain and raw PGM come under Pillow's name PPM."""


class MapFileError(ValueError):
    """A map file cannot be read; the message names the file and the reason in one sentence."""


@dataclass(frozen=True, eq=False)
class Shades:
    """An image: `values` (rows, cols) from 0 black to 1 white, row 0 on top; where it is opaque."""

    values: NDArray[np.float64]
    is_opaque: NDArray[np.bool_]


def read_shades(file: Path) -> Shades:
    """Read a PGM (P2, P5), PNG or BMP image of 8 or 16 bits; colours are averaged.

    Raises:
        MapFileError: the image is missing, damaged, truncated, empty or too large.
    """
    try:
        with warnings.catch_warnings():
            # Pillow warns from 89 million pixels on; a map of that size is a mistake.
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(file, formats=FORMATS) as image:
                image.load()
                return _shades_of(image)
    except FileNotFoundError:
        raise MapFileError(f"{file}: the map's image does not exist") from None
    except (Image.DecompressionBombWarning, Image.DecompressionBombError):
        raise MapFileError(f"{file}: the image is too large for a map") from None
    except UnidentifiedImageError:
        raise MapFileError(f"{file}: not a PGM, PNG or BMP image") from None
    except (OSError, SyntaxError, ValueError, EOFError, struct.error, zlib.error) as error:
        raise MapFileError(f"{file}: the image is damaged ({error})") from None


def _shades_of(image: Image.Image) -> Shades:
    """Return the shades of a loaded image; ValueError if its kind has none."""
    if image.mode in {"I", "I;16", "I;16B", "I;16L"}:
        values = np.asarray(image, np.float64) / 65535.0
        return Shades(np.clip(values, 0.0, 1.0), np.ones(values.shape, bool))
    if image.mode in {"1", "L"}:
        values = np.asarray(image.convert("L"), np.float64) / 255.0
        return Shades(values, np.ones(values.shape, bool))
    if image.mode not in {"P", "PA", "LA", "La", "RGB", "RGBA", "RGBa"}:
        raise ValueError(f"pixels of kind {image.mode} are no shades of grey")
    channels = np.asarray(image.convert("RGBA"), np.float64) / 255.0
    return Shades(channels[..., :3].mean(axis=2), channels[..., 3] == 1.0)
