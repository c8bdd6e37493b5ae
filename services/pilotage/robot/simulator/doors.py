"""Doors of a simulated world: an opening in its walls with a frame, and a leaf in it; pure.

An entry of a world file or of a file with a list `doors`:

    {ends: [[3.0, 7.2], [3.9, 7.2]], state: closed}

`ends` are the jambs, on the line where the leaf is when closed; it hangs at the first, and opens
to the left of the way from the first to the second.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeGuard, get_args

import numpy as np
import yaml
from numpy.typing import NDArray

from pilotage.core.grid import GridGeometry

State = Literal["open", "closed", "ajar"]
AJAR = float(np.deg2rad(35.0))
"""How far a leaf that is ajar is open, rad."""
THICKEST_LEAF, NARROWEST = 0.2, 0.3
"""m."""
Place = tuple[float, float]


class DoorFileError(ValueError):
    """A list of doors that cannot be used; the text says why, in one line."""


@dataclass(frozen=True)
class Door:
    """A door. `leaf`: how thick its leaf is, m; an open one's is out of the way, or in the map."""

    ends: tuple[Place, Place]
    state: State = "open"
    leaf: float = 0.05

    @property
    def jambs(self) -> NDArray[np.float64]:
        """Both ends (2, 2) in the map frame, m."""
        return np.array(self.ends)

    @property
    def hung(self) -> NDArray[np.float64] | None:
        """From the hinge to the other side of the leaf (2, 2), map frame; None if it is open."""
        if self.state == "open":
            return None
        hinge, along = self.jambs[0], self.jambs[1] - self.jambs[0]
        angle = AJAR if self.state == "ajar" else 0.0
        cos, sin = np.cos(angle), np.sin(angle)
        turned = np.array([cos * along[0] - sin * along[1], sin * along[0] + cos * along[1]])
        return np.array([hinge, hinge + turned])


@dataclass(frozen=True)
class Doors:
    """The doors of a world."""

    doors: tuple[Door, ...] = ()

    def __len__(self) -> int:
        return len(self.doors)

    @property
    def jambs(self) -> NDArray[np.float64]:
        """Jambs (n, 2, 2) of all, map frame, m."""
        return np.array([door.ends for door in self.doors]).reshape(-1, 2, 2)

    @property
    def leaves(self) -> NDArray[np.float64]:
        """Leaves (k, 2, 2) that hang in the way, hinge first, map frame, m."""
        hung = [leaf for door in self.doors if (leaf := door.hung) is not None]
        return np.array(hung).reshape(-1, 2, 2)

    def fill(self, cells: NDArray[np.int8], geometry: GridGeometry, value: int) -> None:
        """Set the cells of a grid that leaves stand in."""
        for door in self.doors:
            leaf = door.hung
            if leaf is not None:
                _fill(cells, geometry, leaf, (door.leaf, value))


NO_DOORS = Doors()


def doors_of(entries: Sequence[object]) -> Doors:
    """Return the doors of a list as it stands in a file; ValueError says which is wrong."""
    return Doors(tuple(_door(f"door {n}", entry) for n, entry in enumerate(entries, start=1)))


def read_doors(file: Path) -> Doors:
    """Return the doors of a YAML file with a list `doors`; DoorFileError."""
    try:
        values = yaml.safe_load(file.read_bytes())
    except OSError as error:
        raise DoorFileError(f"{file}: {error.strerror or error}") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise DoorFileError(f"{file}: not readable as YAML ({reason})") from None
    try:
        return _doors(values)
    except ValueError as error:
        raise DoorFileError(f"{file}: {error}") from None


def _doors(values: object) -> Doors:
    match values:
        case {"doors": list(entries), **rest} if not rest:
            return doors_of(entries)
        case _:
            raise ValueError("a list 'doors' is needed, and nothing else")


def _door(where: str, entry: object) -> Door:
    """Return one entry's door; ValueError says which and what is wrong."""
    if not isinstance(entry, dict) or "ends" not in entry:
        raise ValueError(f"{where} must be a mapping with ends, not {entry!r}")
    unknown = [str(key) for key in entry if key not in ("ends", "state", "leaf")]
    if unknown:
        raise ValueError(f"{where}: unknown key '{unknown[0]}'")
    state = entry.get("state", "open")
    if state not in get_args(State):
        raise ValueError(f"{where}: state must be one of {', '.join(get_args(State))}")
    leaf = entry.get("leaf", 0.05)
    if not (_is_number(leaf) and 0.0 < leaf <= THICKEST_LEAF):
        raise ValueError(f"{where}: leaf must be a thickness of at most {THICKEST_LEAF:g} m")
    return Door(_ends(where, entry["ends"]), state, float(leaf))


def _ends(where: str, value: object) -> tuple[Place, Place]:
    match value:
        case [[float() | int(), float() | int()], [float() | int(), float() | int()]]:
            (x0, y0), (x1, y1) = value
            if not all(math.isfinite(number) for number in (x0, y0, x1, y1)):
                raise ValueError(f"{where}: its ends must be finite")
            if math.hypot(x1 - x0, y1 - y0) < NARROWEST:
                raise ValueError(f"{where}: its ends lie nearer than {NARROWEST:g} m")
            return (float(x0), float(y0)), (float(x1), float(y1))
        case _:
            raise ValueError(f"{where}: ends must be two points, [[x0, y0], [x1, y1]] in m")


def _is_number(value: object) -> TypeGuard[float]:
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return is_number and math.isfinite(float(str(value)))


def _fill(
    cells: NDArray[np.int8],
    geometry: GridGeometry,
    leaf: NDArray[np.float64],
    thickness_value: tuple[float, int],
) -> None:
    """Set the cells whose centres lie in a leaf, and all that its middle line crosses."""
    thickness, value = thickness_value
    along = leaf[1] - leaf[0]
    length = float(np.hypot(*along))
    steps = np.linspace(0.0, 1.0, max(int(4.0 * length / geometry.resolution), 2))
    crossed = geometry.cells_of(leaf[0] + steps[:, None] * along)
    crossed = crossed[geometry.contains(crossed)]
    cells[crossed[:, 0], crossed[:, 1]] = value
    candidates = _around(crossed, geometry, thickness)
    offset = geometry.centres_of(candidates) - leaf[0]
    beside = np.abs(offset @ (-along[1], along[0])) / length
    ahead = offset @ along / length
    inside = (beside < thickness / 2.0 - 1e-9) & (ahead > 0.0) & (ahead < length)
    rows, cols = candidates[inside].T
    cells[rows, cols] = value


def _around(
    crossed: NDArray[np.int64], geometry: GridGeometry, thickness: float
) -> NDArray[np.int64]:
    """Return the cells (m, 2) of the box round cells (n, 2)."""
    if len(crossed) == 0:
        return crossed
    margin = int(thickness / geometry.resolution) + 1
    low = np.maximum(crossed.min(axis=0) - margin, 0)
    high = np.minimum(crossed.max(axis=0) + margin + 1, geometry.shape)
    box: NDArray[np.int64] = np.argwhere(np.ones(high - low, bool)) + low
    return box
