"""How sharp a sonar map is, and how well it foretells what was heard and not drawn."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.mapper.sonar_ring import SonarRing

Round = tuple[NDArray[np.float64], NDArray[np.float64]]
"""A pose (3,) in the map and the ranges (n,) heard there."""
SIDE = np.deg2rad(20.0)
"""An echo is explained by an obstacle at its range so far aside of the axis ..."""
CORE = np.deg2rad(7.0)
"""... and contradicted by a nearer one within this."""


def entropy(world: OccupancyMap) -> NDArray[np.float64]:
    """Return the binary entropy (rows, cols) of the cells in bits; unknown cells have 1.

    Probabilities are those of the map's per cent, kept half a per cent from 0 and 1.
    """
    p = np.clip(world.cells / 100.0, 0.005, 0.995)
    bits = -(p * np.log2(p) + (1.0 - p) * np.log2(1.0 - p))
    return np.where(world.cells < 0, 1.0, bits)


def mean_entropy_of_known(world: OccupancyMap) -> float:
    """Return the mean entropy over the cells that this map knows, bits."""
    return float(entropy(world)[world.cells >= 0].mean())


def mean_entropies(worlds: Sequence[OccupancyMap]) -> list[float]:
    """Return the mean entropy of each map over the cells that ANY of them knows, bits.

    The grids share resolution and cell borders; a cell that a map does not know counts 1 bit.
    """
    places = [_known_places(world) for world in worlds]
    touched = set().union(*places)
    return [(sum(bits.values()) + len(touched) - len(bits)) / len(touched) for bits in places]


def foretold(
    world: OccupancyMap, ring: SonarRing, rounds: Iterable[Round], use: tuple[float, float]
) -> tuple[float, float]:
    """Return which shares of readings a map explains and contradicts.

    Args:
        world: drawn without these rounds.
        ring: whose readings they are.
        rounds: poses and ranges.
        use: readings up to this range count, m, to within this tolerance, m.
    """
    occupied = world.geometry.centres_of(np.argwhere(world.is_wall))
    farthest, tolerance = use
    explained, contradicted = [], []
    for pose, ranges in rounds:
        for x, y, axis, reading in ring.readings(pose, ranges):
            if not 0.1 <= reading <= farthest:
                continue
            seen = (occupied - [x, y]) @ [1.0, 1.0j] * np.exp(-1j * axis)
            beyond, aside = np.abs(seen) - reading, np.abs(np.angle(seen))
            explained.append(bool(((np.abs(beyond) <= tolerance) & (aside < SIDE)).any()))
            contradicted.append(bool(((beyond < -tolerance) & (aside < CORE)).any()))
    return float(np.mean(explained)), float(np.mean(contradicted))


def _known_places(world: OccupancyMap) -> dict[tuple[int, int], float]:
    """Return the entropy of each known cell by its place on the lattice of the map."""
    cells = np.argwhere(world.cells >= 0)
    lattice = np.floor(world.geometry.centres_of(cells) / world.geometry.resolution).astype(int)
    bits = entropy(world)[cells[:, 0], cells[:, 1]]
    return {(x, y): float(b) for (x, y), b in zip(lattice.tolist(), bits, strict=True)}
