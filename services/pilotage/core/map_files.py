"""Maps on disk: map_server's YAML with an image, and the text format of CMU's Wean Hall.

A map that is being saved survives a power cut as the old or the new one. Image and YAML are
first written whole under temporary names; then the YAML, which states the image's checksum, is
renamed into place, and then the image. A loader that comes between these two renames finds the
image that fits the checksum under its temporary name.
"""

import hashlib
import os
from pathlib import Path

import numpy as np
import yaml

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.map_image import MapFileError, read_shades
from pilotage.core.map_shades import FREE_THRESH, OCCUPIED_THRESH, cells_from_shades, pgm_from_cells
from pilotage.core.map_yaml import MapDescription, read_description
from pilotage.core.maybe_gzip import read_maybe_gzip
from pilotage.core.wean_map import is_wean_map, read_wean_map

__all__ = ["MapFileError", "load_map", "map_digest", "save_map"]

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
    image = file.with_suffix(".pgm")
    pgm, mode = pgm_from_cells(world.cells)
    description = _yaml(world.geometry, image.name, pgm, mode)
    _write_synced(_temporary(image), pgm)
    _write_synced(_temporary(file), description)
    _temporary(file).replace(file)
    _sync_folder(file.parent)
    _temporary(image).replace(image)
    _sync_folder(file.parent)


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
    if not image.is_file():
        others = [image.with_suffix(suffix) for suffix in (".png", ".pgm", ".bmp")]
        return next((other for other in others if other.is_file()), image)
    unfinished = _temporary(image)
    if description.image_sha256 is None or not unfinished.is_file():
        return image
    is_the_new_one = _checksum(unfinished.read_bytes()) == description.image_sha256
    return unfinished if is_the_new_one else image


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


def _temporary(file: Path) -> Path:
    return file.with_name(file.name + ".new")


def _write_synced(file: Path, content: bytes) -> None:
    """Write a file and wait until it is on the disk."""
    with file.open("wb") as stream:
        stream.write(content)
        stream.flush()
        os.fsync(stream.fileno())


def _sync_folder(folder: Path) -> None:
    """Wait until the renames in a folder are on the disk."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
