"""Where landmarks stand: beacons, goals, reflectors, read from YAML.

    landmarks:
      - {class: beacon, x: 1.5, y: -2.0, id: north}
      - {class: beacon, x: 1.5, y: 3.0}

`class` is what a sensor takes it for; `id`, where there is one, tells it from its likes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

LONGEST_NAME = 64
"""Characters of a class or an id; messages carry no more."""


class LandmarkFileError(ValueError):
    """A file of landmarks cannot be used; the message names file, entry and fault."""


@dataclass(frozen=True)
class LandmarkMap:
    """Landmarks: positions (n, 2) in the map frame [m], their classes and identities (or None)."""

    positions: NDArray[np.float64]
    classes: tuple[str, ...]
    identities: tuple[str | None, ...]

    def __post_init__(self) -> None:
        """Refuse what does not fit together (ValueError)."""
        count = len(self.classes)
        if self.positions.shape != (count, 2) or len(self.identities) != count:
            raise ValueError("landmarks need a position, a class and an identity or None each")
        if not np.isfinite(self.positions).all():
            raise ValueError("positions of landmarks must be finite")
        named = [identity for identity in self.identities if identity is not None]
        twice = next((name for name in named if named.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"the id '{twice}' is given to two landmarks")

    def candidates(self, kind: str, identity: str | None) -> NDArray[np.float64]:
        """Return the positions (k, 2) that a sighting may belong to, none if it is not mapped."""
        if identity is not None:
            fits = [own == identity for own in self.identities]
        else:
            fits = [own == kind for own in self.classes]
        places: NDArray[np.float64] = self.positions[np.array(fits, bool)]
        return places


NO_LANDMARKS = LandmarkMap(np.empty((0, 2)), (), ())


def read_landmarks(file: Path) -> LandmarkMap:
    """Return the landmarks of a YAML file.

    Raises:
        LandmarkFileError: unreadable, or an entry is missing something or wrong.
    """
    try:
        values = yaml.safe_load(file.read_bytes())
    except OSError as error:
        raise LandmarkFileError(f"{file}: {error.strerror or error}") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise LandmarkFileError(f"{file}: not readable as YAML ({reason})") from None
    try:
        return _landmarks(values)
    except ValueError as error:
        raise LandmarkFileError(f"{file}: {error}") from None


def landmarks_of(entries: Sequence[object]) -> LandmarkMap:
    """Return the landmarks of a list as it stands in a file; ValueError says which is wrong."""
    return _assembled([_entry(n, entry) for n, entry in enumerate(entries, start=1)])


def _landmarks(values: object) -> LandmarkMap:
    match values:
        case {"landmarks": list(entries), **rest}:
            if rest:
                raise ValueError(f"unknown key '{next(iter(rest))}'")
            return landmarks_of(entries)
        case _:
            raise ValueError("there is no list 'landmarks'")


def _assembled(entries: Sequence[tuple[str, float, float, str | None]]) -> LandmarkMap:
    positions = np.array([(x, y) for _, x, y, _ in entries]).reshape(-1, 2)
    classes = tuple(entry[0] for entry in entries)
    return LandmarkMap(positions, classes, tuple(entry[3] for entry in entries))


def _entry(number: int, entry: object) -> tuple[str, float, float, str | None]:
    """Return class, x, y and identity of one entry; ValueError says which and what is wrong."""
    where = f"landmark {number}"
    match entry:
        case {"class": kind, "x": x, "y": y, **rest}:
            unknown = [str(key) for key in rest if key != "id"]
            if unknown:
                raise ValueError(f"{where}: unknown key '{unknown[0]}'")
            name = rest.get("id")
            identity = None if name is None else _word(where, "id", name)
            place = _coordinate(where, "x", x), _coordinate(where, "y", y)
            return _word(where, "class", kind), *place, identity
        case dict():
            missing = next(key for key in ("class", "x", "y") if key not in entry)
            raise ValueError(f"{where}: the key '{missing}' is missing")
        case _:
            raise ValueError(f"{where} must be a mapping with class, x and y, not {entry!r}")


def _word(where: str, key: str, value: object) -> str:
    """Return a name; numbers are names too, as barcodes are."""
    if isinstance(value, bool) or not isinstance(value, str | int) or value == "":
        raise ValueError(f"{where}: {key} must be a name, not {value!r}")
    name = str(value)
    if len(name) > LONGEST_NAME:
        raise ValueError(f"{where}: {key} has more than {LONGEST_NAME} characters")
    return name


def _coordinate(where: str, key: str, value: object) -> float:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    number = float(str(value)) if is_number else math.nan
    if not math.isfinite(number):
        raise ValueError(f"{where}: {key} must be a finite number, not {value!r}")
    return number
