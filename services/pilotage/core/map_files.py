"""Maps on disk: map_server's YAML with an image, and the text format of CMU's Wean Hall.

A map that is being saved survives a power cut as the old or the new one. Image and YAML are
first written whole under temporary names; then the YAML, which states the image's checksum, is
renamed into place, and then the image. A loader that comes between these two renames finds the
image that fits the checksum under its temporary name.
"""

import hashlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import yaml

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.map_image import MapFileError, read_shades
from pilotage.core.map_shades import FREE_THRESH, OCCUPIED_THRESH, cells_from_shades, pgm_from_cells
from pilotage.core.map_yaml import MapDescription, read_description
from pilotage.core.maybe_gzip import read_maybe_gzip
from pilotage.core.wean_map import is_wean_map, read_wean_map
from pilotage.core.whole_files import temporary_of, write_whole

__all__ = ["MapFileError", "load_map", "map_digest", "map_documents", "save_map", "save_map_files"]

LARGEST_FILE = 256 * 2**20
"""More bytes than this in a YAML or text map are a mistake."""


def load_map(path: str | Path) -> OccupancyMap:
    """Read a map_server YAML with its image, or a Wean Hall map, told apart by content.

    Raises:
        MapFileError: saying in one sentence which file is wrong and why.
    """
    if not str(path).strip():
        raise MapFileError("no map file is named: the path is empty")
    file = Path(path)
    content = _read_bytes(file)
    if is_wean_map(content):
        return read_wean_map(content, file)
    description = read_description(content, file)
    shades = read_shades(_image_of(description, file))
    rows, cols = shades.values.shape
    geometry = GridGeometry(rows, cols, description.resolution, description.origin)
    return OccupancyMap(geometry, cells_from_shades(shades, description.reading))


def save_map(world: OccupancyMap, yaml_path: str | Path) -> None:
    """Write a map as YAML and, beside it, as PGM; it loads back exactly, here and in ROS.

    Cells of -1, 0 and 100 are written in map_server's mode trinary, others in mode raw.

    Raises:
        OSError: the folder is missing, full or read-only; the old map is then still there.
    """
    file = Path(yaml_path)
    save_map_files(file, map_documents(world, file.name))


def save_map_files(yaml_path: Path, files: Mapping[str, bytes]) -> None:
    """Write the documents of a map, and what else belongs to it, so that a power cut halves none.

    Raises:
        OSError: the folder is missing, full or read-only; the old files are then still there.
    """
    _finish_saving(yaml_path)
    write_whole(yaml_path.parent, files)


def map_documents(world: OccupancyMap, yaml_name: str) -> dict[str, bytes]:
    """Return the files of a map by name: the YAML and then the PGM that it states the sum of."""
    image = Path(yaml_name).with_suffix(".pgm").name
    pgm, mode = pgm_from_cells(world.cells)
    return {yaml_name: _yaml(world.geometry, image, pgm, mode), image: pgm}


def map_digest(world: OccupancyMap) -> str:
    """Return 16 hex digits that identify a map by its geometry and cells."""
    geometry = world.geometry
    place = np.array([geometry.rows, geometry.cols, geometry.resolution, *geometry.origin])
    digest = hashlib.sha256(place.astype("<f8").tobytes())
    digest.update(np.ascontiguousarray(world.cells).tobytes())
    return digest.hexdigest()[:16]


def _read_bytes(file: Path) -> bytes:
    """Return a file's content, unpacked if it is gzip."""
    try:
        return read_maybe_gzip(file, LARGEST_FILE)
    except FileNotFoundError:
        raise MapFileError(f"{file}: the map file does not exist") from None
    except OSError as error:
        raise MapFileError(f"{file}: the map file cannot be read ({error.strerror})") from None
    except ValueError as error:
        raise MapFileError(f"{file}: the map file cannot be read ({error})") from None


def _image_of(description: MapDescription, file: Path) -> Path:
    """Return the image that a description means, looking beside it if the path is relative.

    Maps are often handed on with their PGM packed as PNG and the YAML left as it was: if the
    image is not there, the same name with another ending is taken.
    """
    image = file.parent / description.image
    unfinished, checksum = temporary_of(image), description.image_sha256
    if checksum and unfinished.is_file() and _checksum(unfinished.read_bytes()) == checksum:
        return unfinished
    if not image.is_file():
        others = [image.with_suffix(suffix) for suffix in (".png", ".pgm", ".bmp")]
        return next((other for other in others if other.is_file()), image)
    return image


def _finish_saving(file: Path) -> None:
    """Put an image in place that a power cut kept from it, before another is written there."""
    try:
        description = read_description(_read_bytes(file), file)
    except MapFileError:
        return
    image = file.parent / description.image
    if _image_of(description, file) == temporary_of(image):
        temporary_of(image).replace(image)


def _yaml(geometry: GridGeometry, image: str, pgm: bytes, mode: str) -> bytes:
    """Return map_server's YAML for a map; other programs pass over the checksum."""
    values = {
        "image": image,
        "mode": mode,
        "resolution": float(geometry.resolution),
        "origin": [float(value) for value in geometry.origin],
        "negate": 0,
        "occupied_thresh": OCCUPIED_THRESH,
        "free_thresh": FREE_THRESH,
        "image_sha256": _checksum(pgm),
    }
    return yaml.safe_dump(values, sort_keys=False, default_flow_style=None).encode()


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
