"""The environment potential field of landmarks: Liu et al. 2008, eq. 1 to 3; pure.

A landmark helps the more, the rarer it is and the more surely it is recognised from where the
robot stands. Its potential at distance d is (eq. 1; erratum: the print has lost k)

    f(d) = k / (1 + exp((d - d0) / T)).

Landmarks of which the sensor tells each apart have k = 1, m alike ones k = 1 / m.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.cell_traversal import cast_ray_in_grid
from pilotage.core.grid import OccupancyMap
from pilotage.core.jit import kernel
from pilotage.core.landmark_map import LandmarkMap

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Recognition:
    """How far a sensor recognises a class of landmarks.

    `reach` (d0) [m]: the recognition probability is one half there; `fall` (T) [m]: the larger,
    the more slowly it falls.
    """

    reach: float
    fall: float

    @classmethod
    def measured(cls, d_low: float, d_high: float) -> "Recognition":
        """Return the paper's rule: below 0.5 beyond `d_low` (d_L), below 0.1 beyond `d_high`."""
        return cls(d_low, (d_high - d_low) / float(np.log(9.0)))


class Walls(NamedTuple):
    """What hides landmarks: `is_wall` (rows, cols), its corner's pose and its cells' width."""

    is_wall: NDArray[np.bool_]
    corner: tuple[float, float, float]
    resolution: float


class Sources(NamedTuple):
    """Landmarks as sources of the field, those of a kind next to one another.

    `positions` (n, 2) in the map frame; `kinds` (n,): the kind of each, ascending from 0;
    `firsts` (kinds + 1,): those of kind c are firsts[c] to firsts[c + 1]; `strengths` (k),
    `reaches` (d0) and `falls` (T), all (n,); `walls`: may be without cells.
    """

    positions: Array
    kinds: NDArray[np.int64]
    firsts: NDArray[np.int64]
    strengths: Array
    reaches: Array
    falls: Array
    walls: Walls


def kinds_of(landmarks: LandmarkMap) -> list[tuple[str, str | None]]:
    """Return what a sensor can tell apart: each identity, and each class without one, sorted."""
    names = zip(landmarks.classes, landmarks.identities, strict=True)
    return sorted(set(names), key=lambda kind: (kind[0], kind[1] or ""))


def sources_of(
    landmarks: LandmarkMap,
    recognitions: Mapping[str, Recognition],
    world: OccupancyMap | None = None,
) -> Sources:
    """Return landmarks as sources by the paper's rule: k = 1 / m for m of a kind.

    Args:
        landmarks: where they stand.
        recognitions: how far each class is recognised; KeyError if a class is missing.
        world: whose walls hide them, if any do.
    """
    known = kinds_of(landmarks)
    names = list(zip(landmarks.classes, landmarks.identities, strict=True))
    kinds = np.array([known.index(name) for name in names], np.int64)
    order = np.argsort(kinds, kind="stable")
    counts = np.bincount(kinds, minlength=len(known)).astype(np.int64)
    seen = [recognitions[landmarks.classes[i]] for i in order]
    return Sources(
        landmarks.positions[order].astype(float),
        kinds[order],
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        1.0 / counts[kinds[order]],
        np.array([one.reach for one in seen], float),
        np.array([one.fall for one in seen], float),
        _walls_of(world),
    )


def _walls_of(world: OccupancyMap | None) -> Walls:
    if world is None:
        return Walls(np.zeros((0, 0), bool), (0.0, 0.0, 0.0), 1.0)
    x, y, theta = map(float, world.geometry.origin)
    return Walls(world.is_wall, (x, y, theta), float(world.geometry.resolution))


def environment_potential(sources: Sources, places: ArrayLike) -> Array:
    """Return F_S(P) (n,) at places (n, 2) of the map frame: of all landmarks in sight (eq. 3)."""
    return _environment(sources, np.ascontiguousarray(places, float))


def window_potential(
    sources: Sources, places: ArrayLike, headings: ArrayLike, half_view: float
) -> Array:
    """Return F(P, theta) (n, h): of the landmarks within a field of view (eq. 2).

    Args:
        sources: the landmarks.
        places: (n, 2) in the map frame.
        headings: (h,) where the sensor points, in the map frame.
        half_view: alpha, half of the field of view [rad].
    """
    pointings = np.ascontiguousarray(headings, float)
    return _window(sources, np.ascontiguousarray(places, float), pointings, half_view)


@kernel
def recognised(distance: float, reach: float, fall: float) -> float:
    """Return the probability that a landmark in view is recognised at `distance`: f(d) / k."""
    exponent = (distance - reach) / fall
    return 1.0 / (1.0 + np.exp(exponent)) if exponent < 700.0 else 0.0


@kernel
def is_within(bearing: float, middle: float, half_view: float) -> bool:
    """Say whether a bearing lies within the view [middle - half, middle + half]."""
    off = bearing - middle
    off -= 2.0 * np.pi * np.rint(off / (2.0 * np.pi))
    return bool(abs(off) <= half_view)


@kernel
def is_in_sight(walls: Walls, x: float, y: float, bearing: float, distance: float) -> bool:
    """Say whether nothing stands between (x, y) and what is seen from there, map frame.

    A landmark may hang on a wall: what the line meets within the last two cells is its own.
    """
    if walls.is_wall.size == 0:
        return True
    corner_x, corner_y, turn = walls.corner
    dx, dy = x - corner_x, y - corner_y
    cos, sin = np.cos(turn), np.sin(turn)
    col = (cos * dx + sin * dy) / walls.resolution
    row = (cos * dy - sin * dx) / walls.resolution
    cells = distance / walls.resolution - 2.0
    return bool(cast_ray_in_grid(walls.is_wall, col, row, bearing - turn, cells) >= cells)


@kernel
def _environment(sources: Sources, places: Array) -> Array:
    total = np.zeros(len(places))
    for i in range(len(places)):
        for at in range(len(sources.positions)):
            total[i] += _potential(sources, at, places[i, 0], places[i, 1])[0]
    return total


@kernel
def _window(sources: Sources, places: Array, headings: Array, half_view: float) -> Array:
    total = np.zeros((len(places), len(headings)))
    for i in range(len(places)):
        for at in range(len(sources.positions)):
            potential, bearing = _potential(sources, at, places[i, 0], places[i, 1])
            for h in range(len(headings)):
                if is_within(bearing, headings[h], half_view):
                    total[i, h] += potential
    return total


@kernel
def _potential(sources: Sources, at: int, x: float, y: float) -> tuple[float, float]:
    """Return the potential of a landmark at (x, y), 0 if it is hidden, and its direction."""
    dx, dy = sources.positions[at, 0] - x, sources.positions[at, 1] - y
    distance, bearing = np.hypot(dx, dy), np.arctan2(dy, dx)
    share = recognised(distance, sources.reaches[at], sources.falls[at])
    # No ray is cast for what is hardly ever recognised from there.
    if share < 1e-6 or not is_in_sight(sources.walls, x, y, bearing, distance):
        return 0.0, bearing
    return sources.strengths[at] * share, bearing


def warm_up() -> None:
    """Compile the kernels."""
    landmarks = LandmarkMap(np.zeros((1, 2)), ("post",), (None,))
    sources = sources_of(landmarks, {"post": Recognition(1.0, 0.1)})
    environment_potential(sources, np.zeros((1, 2)))
    window_potential(sources, np.zeros((1, 2)), np.zeros(1), 0.5)
