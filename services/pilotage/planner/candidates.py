"""Where the robot could look from next: Q = M u S u R u {P0}, Liu et al. 2008, eq. 4; pure.

The paper names places of the map; as long as several places are likely, a place of the map is
somewhere else for each of them. So candidates are displacements from here: the places where the
potential is highest (M, S) as each likely place sees them, places drawn at random from the ground
that can be reached (R), and here (P0).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import GridGeometry
from pilotage.planner.situation import Hypotheses

Kind = Literal["here", "potential", "random"]


@dataclass(frozen=True)
class Reach:
    """What can be reached from here: `metres` (rows, cols) of the way, on a grid in base_link."""

    geometry: GridGeometry
    passable: NDArray[np.bool_]
    metres: NDArray[np.float32]


@dataclass(frozen=True)
class Candidates:
    """Displacements: `points` (n, 2) in base_link, `travel` (n,) [m], and the kind of each."""

    points: NDArray[np.float64]
    travel: NDArray[np.float64]
    kinds: tuple[Kind, ...]


def candidates(
    reach: Reach,
    maxima: NDArray[np.float64],
    places: Hypotheses,
    count: int,
    rng: np.random.Generator,
) -> Candidates:
    """Return at most about `count` candidates.

    Args:
        reach: where the robot can go.
        maxima: (k, 2) places of high potential, map frame, the highest first.
        places: the likely places, heaviest first.
        count: how many; a third of them by potential.
        rng: draws the random ones.
    """
    promising = _promising(reach, maxima, places, count // 3)
    anywhere = _anywhere(reach, count - len(promising) - 1, rng)
    points = np.vstack([np.zeros((1, 2)), promising, anywhere])
    travel = _metres(reach, points)
    travel[0] = 0.0
    kinds: list[Kind] = ["here"]
    kinds += ["potential"] * len(promising)
    kinds += ["random"] * len(anywhere)
    return Candidates(points, travel, tuple(kinds))


def _promising(
    reach: Reach, maxima: NDArray[np.float64], places: Hypotheses, count: int
) -> NDArray[np.float64]:
    """Return up to `count` maxima (n, 2) within reach, as the heaviest places see them."""
    shares = np.ceil(count * places.weights / places.weights.sum()).astype(int)
    found: list[NDArray[np.float64]] = []
    for pose, share in zip(places.poses[:count], shares[:count], strict=True):
        seen = se2.transform_points(se2.inverse(pose), maxima)
        seen = seen[np.isfinite(_metres(reach, seen))]
        found.append(seen[:share])
    return np.vstack([np.zeros((0, 2)), *found])[:count]


def _anywhere(reach: Reach, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return `count` places (n, 2) that can be reached, near ones as often as far ones."""
    cells = np.argwhere(np.isfinite(reach.metres))
    metres = reach.metres[cells[:, 0], cells[:, 1]].astype(float)
    # A floor has more far cells than near ones: each ring of the same width gets the same share.
    rings = np.floor(metres).astype(int)
    weights = 1.0 / np.bincount(rings)[rings]
    drawn = rng.choice(len(cells), min(count, len(cells)), replace=False, p=weights / weights.sum())
    return reach.geometry.centres_of(cells[drawn])


def _metres(reach: Reach, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the way [m] to points (n, 2), infinite where there is none."""
    cells = reach.geometry.cells_of(points)
    inside = reach.geometry.contains(cells)
    metres = np.full(len(points), np.inf)
    metres[inside] = reach.metres[cells[inside, 0], cells[inside, 1]]
    return metres
