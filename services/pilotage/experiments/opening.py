"""What maps say of the narrow opening, and what it takes to find out (Li 2008, 5.2)."""

import time
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.experiments.arc_twin import place_echoes_plainly
from pilotage.experiments.sonar_halls import MIDDLE, OPENING, UPPER
from pilotage.experiments.sonar_maps import CROSSINGS
from pilotage.experiments.wall_segments import Floats, distance_to_walls
from pilotage.mapper.arc_median import place_echoes
from pilotage.mapper.sonar_arcs import ArcCrossings, are_on_surface

AROUND = 0.4
"""m to either side of the opening's middle in which a gap is looked for."""

DEPTH = 0.15
"""m before and behind the wall that have to be free of occupied cells: the wall is as thick."""

ON_SURFACE = 0.05
"""m from a true surface up to which a crossing is valid."""


def width_of_opening(world: OccupancyMap) -> float:
    """Return the widest gap in the wall, m: columns without an occupied cell near its line.

    The line itself has to be known: what no cone reached is no opening.
    """
    near, beside = _places(world)
    on_line = np.abs(near) <= world.geometry.resolution
    is_free = ~_is_blocked(world) & (world.is_free & on_line[:, None]).any(axis=0)
    return world.geometry.resolution * _longest(is_free & (np.abs(beside) <= AROUND))


def share_blocked(world: OccupancyMap) -> float:
    """Return which share of the true opening's columns holds an occupied cell."""
    _, beside = _places(world)
    within = np.abs(beside) < OPENING / 2.0
    return float(_is_blocked(world)[within].mean())


def _is_blocked(world: OccupancyMap) -> NDArray[np.bool_]:
    """Say of every column (cols,) whether a cell near the wall's line is occupied."""
    near, _ = _places(world)
    return np.asarray(world.is_wall[np.abs(near) <= DEPTH].any(axis=0), bool)


def _places(world: OccupancyMap) -> tuple[Floats, Floats]:
    """Return how far rows lie above the wall's line and columns beside the middle, m."""
    geometry = world.geometry
    left, bottom, _ = geometry.origin
    above = bottom + (np.arange(geometry.rows) + 0.5) * geometry.resolution - UPPER
    beside = left + (np.arange(geometry.cols) + 0.5) * geometry.resolution - MIDDLE
    return np.asarray(above, float), np.asarray(beside, float)


def share_on_surface(crossings: ArcCrossings, walls: Floats) -> tuple[int, int]:
    """Return how many of the crossings that place obstacles lie on a true surface, and all."""
    used = crossings.points[crossings.is_used]
    valid = are_on_surface(distance_to_walls(walls, used), ON_SURFACE)
    return int(np.count_nonzero(valid)), len(used)


def placing_times(arcs: Floats, cone: float) -> dict[str, float]:
    """Return what it takes to place an arc among others, ms of the processor, by method.

    `_twin`: the same in plain numpy.
    """
    times: dict[str, float] = {}
    for name in ("atm", "improved_atm"):
        improved = name == "improved_atm"
        times[name] = _ms(partial(place_by_kernel, arcs, cone, improved=improved))
        twin = partial(place_echoes_plainly, arcs, cone, CROSSINGS, improved=improved)
        times[f"{name}_twin"] = _ms(twin)
    return {name: spent / len(arcs) for name, spent in times.items()}


def place_by_kernel(arcs: Floats, cone: float, *, improved: bool) -> Floats:
    """Return for arcs (n, 4) the angle (n,) from the axis that the echo came from."""
    weights = np.array(CROSSINGS.weights)
    rule = improved, CROSSINGS.least_angle, weights, CROSSINGS.least_score
    return place_echoes(arcs, 0, len(arcs), cone, rule)[:, 0]


def _ms(work: Callable[[], object]) -> float:
    begun = time.process_time()
    work()
    return (time.process_time() - begun) * 1e3


def _longest(flags: NDArray[np.bool_]) -> int:
    """Return the length of the longest row of true flags."""
    edges = np.flatnonzero(np.diff(flags, prepend=False, append=False)).reshape(-1, 2)
    return int(np.diff(edges, axis=1).max(initial=0))
