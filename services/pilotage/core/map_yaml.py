"""The YAML of a map_server map, checked."""

import math
from dataclasses import dataclass
from pathlib import Path

import yaml

from pilotage.core.map_image import MapFileError
from pilotage.core.map_shades import MODES, ShadeReading


@dataclass(frozen=True)
class MapDescription:
    """What map_server's YAML says of a map; `resolution` in m, `origin` x, y in m, yaw in rad."""

    image: str
    resolution: float
    origin: tuple[float, float, float]
    reading: ShadeReading
    image_sha256: str | None
    """Checksum of the image file, written by `save_map`; None in maps of others."""


def read_description(content: bytes, file: Path) -> MapDescription:
    """Return the description in `content`; `file` is named in errors.

    `mode` and `negate` may be left out (trinary, 0), as nav2's map_server has it.

    Raises:
        MapFileError: unreadable YAML, or a key missing or wrong.
    """
    values = _mapping(content, file)
    for key in ("image", "resolution", "origin", "occupied_thresh", "free_thresh"):
        if key not in values:
            raise MapFileError(f"{file}: the key '{key}' is missing")
    try:
        return _description(values)
    except ValueError as error:
        raise MapFileError(f"{file}: {error}") from None


def _mapping(content: bytes, file: Path) -> dict[str, object]:
    """Parse YAML that has to be a mapping at its top."""
    try:
        values = yaml.safe_load(content)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise MapFileError(f"{file}: not readable as YAML ({reason})") from None
    if not isinstance(values, dict):
        raise MapFileError(f"{file}: neither the YAML of a map nor a Wean Hall map")
    return values


def _description(values: dict[str, object]) -> MapDescription:
    """Check the values one by one; ValueError says what is wrong."""
    resolution = _number(values, "resolution")
    if resolution <= 0.0:
        raise ValueError(f"resolution must be positive, not {resolution}")
    occupied, free = _number(values, "occupied_thresh"), _number(values, "free_thresh")
    if not 0.0 <= free < occupied <= 1.0:
        raise ValueError(
            f"thresholds must satisfy 0 <= free_thresh < occupied_thresh <= 1, "
            f"not {free} and {occupied}"
        )
    mode, image = values.get("mode", "trinary"), values["image"]
    if mode not in MODES:
        raise ValueError(f"mode must be one of {', '.join(MODES)}, not {mode!r}")
    if not isinstance(image, str) or not image or "\0" in image:
        raise ValueError(f"image must be a file name, not {image!r}")
    checksum = values.get("image_sha256")
    return MapDescription(
        image=image,
        resolution=resolution,
        origin=_origin(values["origin"]),
        reading=ShadeReading(str(mode), free, occupied, _negate(values.get("negate", 0))),
        image_sha256=str(checksum) if checksum is not None else None,
    )


def _number(values: dict[str, object], key: str) -> float:
    """Return a finite number; YAML 1.1 takes 5e-2 (no dot) for text, map_server does not."""
    value = values[key]
    try:
        number = math.nan if isinstance(value, bool) else float(str(value))
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{key} must be a finite number, not {value!r}")
    return number


def _origin(value: object) -> tuple[float, float, float]:
    """Return the pose of the lower left corner."""
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError(f"origin must be a list of x, y and yaw, not {value!r}")
    x, y, yaw = (_number({"origin": part}, "origin") for part in value)
    return x, y, yaw


def _negate(value: object) -> bool:
    """Return a switch written as 0, 1, false or true."""
    if value not in (0, 1):
        raise ValueError(f"negate must be 0 or 1, not {value!r}")
    return bool(value)
