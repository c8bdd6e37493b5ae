"""What a sonar hears of walls: the physics that makes sonar maps noisy; pure.

After Kuc & Siegel 1987 and Leonard & Durrant-Whyte 1992. At 40 to 50 kHz (7 mm) a painted wall is
a mirror: it answers where the cone holds its perpendicular, by its roughness some way beside it,
and further aside not at all; a concave corner answers like a wall, an edge or the end of a wall
weakly and from near. What finds no answer may bounce off a wall and come back from another, and
then a wall stands where there is none.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.experiments.wall_segments import (
    HAIR,
    Floats,
    cross,
    directions_of,
    is_concave,
    is_in_cone,
    is_seen,
    nearest_in_cone,
    normals_of,
)

PART_AT_ONCE = 2000
"""Sonars worked out together, for the memory's sake."""


@dataclass(frozen=True)
class EchoParams:
    """The sonar of MORCS-2 (Li 2008, 3.1, 4.2 and 5), and how walls answer it."""

    half_cone: float = float(np.deg2rad(12.5))
    """rad."""
    range_min: float = 0.1
    """m."""
    range_max: float = 4.0
    """m."""
    sigma: float = 0.01
    """Standard deviation of a range, m (the thesis's accuracy of 10 mm)."""
    resolution: float = 0.01
    """m."""
    sure_incidence: float = float(np.deg2rad(10.0))
    """Off the perpendicular, a wall answers always up to here [rad] ..."""
    last_incidence: float = float(np.deg2rad(35.0))
    """... and never from here on; in between ever more rarely."""
    edge_chance: float = 0.7
    """That an edge answers from near."""
    edge_reach: float = 2.5
    """m at which no edge answers any more; the chance falls off evenly."""
    bounce_chance: float = 0.5
    """That an echo that went astray comes back by way of a second wall."""
    share_without_echo: float = 0.02
    """Rounds in which nothing comes back, whatever stands there."""
    share_of_crosstalk: float = 0.01
    """Rounds in which another sonar's sound is taken for the own: any range."""


def sonar_ranges(
    walls: Floats, sonars: Floats, params: EchoParams, rng: np.random.Generator
) -> Floats:
    """Return the range (m,) that each sonar (m, 3: pose in the map) measures; infinite: none."""
    parts = [
        _ranges(walls, sonars[first : first + PART_AT_ONCE], params, rng)
        for first in range(0, len(sonars), PART_AT_ONCE)
    ]
    ranges = np.concatenate(parts) if parts else np.empty(0)
    ranges += params.sigma * rng.standard_normal(len(ranges))
    ranges = np.round(ranges / params.resolution) * params.resolution
    chance = rng.random(len(ranges))
    ranges[chance < params.share_without_echo] = np.inf
    anything = rng.uniform(params.range_min, params.range_max, len(ranges))
    ranges = np.where(chance > 1.0 - params.share_of_crosstalk, anything, ranges)
    return np.where(ranges <= params.range_max, np.maximum(ranges, params.range_min), np.inf)


def _ranges(walls: Floats, sonars: Floats, params: EchoParams, rng: np.random.Generator) -> Floats:
    """Return the true way to whatever answers first, infinite if nothing does."""
    first = np.minimum(
        _from_walls(walls, sonars, params, rng), _from_corners(walls, sonars, params, rng)
    )
    astray = np.isinf(first) & (rng.random(len(first)) < params.bounce_chance)
    first[astray] = bounced(walls, sonars[astray], params)
    return first


def _from_walls(
    walls: Floats, sonars: Floats, params: EchoParams, rng: np.random.Generator
) -> Floats:
    """Return the range (m,) of the nearest wall that answers."""
    points, holds = nearest_in_cone(walls, sonars, params.half_cone)
    towards = points - sonars[:, None, :2]
    ranges = np.hypot(*np.moveaxis(towards, -1, 0))
    across = np.abs(np.einsum("mnd,nd->mn", towards, normals_of(walls)))
    incidence = np.arccos(np.clip(across / np.maximum(ranges, HAIR), 0.0, 1.0))
    fading = params.last_incidence - params.sure_incidence
    chance = np.clip((params.last_incidence - incidence) / fading, 0.0, 1.0)
    answers = holds & (rng.random(ranges.shape) < chance) & is_seen(walls, sonars, points)
    return np.asarray(np.where(answers, ranges, np.inf).min(axis=1), float)


def _from_corners(
    walls: Floats, sonars: Floats, params: EchoParams, rng: np.random.Generator
) -> Floats:
    """Return the range (m,) of the nearest corner, edge or end of a wall that answers."""
    corners = np.unique(walls.reshape(-1, 2).round(6), axis=0)
    towards = corners[None] - sonars[:, None, :2]
    ranges = np.hypot(*np.moveaxis(towards, -1, 0))
    holds = is_in_cone(towards, sonars, params.half_cone)
    of_edge = params.edge_chance * np.clip(1.0 - ranges / params.edge_reach, 0.0, 1.0)
    chance = np.where(is_concave(walls, corners, sonars), 1.0, of_edge)
    points = np.broadcast_to(corners[None], towards.shape)
    answers = holds & (rng.random(ranges.shape) < chance) & is_seen(walls, sonars, points)
    return np.asarray(np.where(answers, ranges, np.inf).min(axis=1), float)


def bounced(walls: Floats, sonars: Floats, params: EchoParams) -> Floats:
    """Return the range (m,) of an echo by way of two walls, the shortest of five rays' each.

    The sound is mirrored by the first wall; the second must lie so square to it that it sends it
    back the same way.
    """
    shortest = np.full(len(sonars), np.inf)
    for side in np.linspace(-params.half_cone, params.half_cone, 5):
        bearing = sonars[:, 2] + side
        first, mirror, hit = _trace(walls, sonars[:, :2], bearing)
        # Where nothing was hit there is nothing to go on from: any wall serves, and is discarded.
        mirrored = 2.0 * directions_of(walls)[mirror] - bearing
        second, back, _ = _trace(walls, hit, mirrored)
        normal = directions_of(walls)[back] + np.pi / 2.0
        off = np.abs(wrap(2.0 * (mirrored - normal))) / 2.0
        way = np.where(off <= params.sure_incidence, first + second, np.inf)
        shortest = np.minimum(shortest, way)
    return shortest


def _trace(
    walls: Floats, origins: Floats, bearings: Floats
) -> tuple[Floats, NDArray[np.int64], Floats]:
    """Return ways (m,), the walls that rays hit, and points (m, 2) just before these."""
    ways, where = cross(walls, origins, bearings)
    ways = np.where(where & (ways > HAIR), ways, np.inf)
    wall = ways.argmin(axis=1)
    way = ways.min(axis=1)
    reach = np.where(np.isfinite(way), way - 2.0 * HAIR, 0.0)
    ahead = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
    return way, wall, origins + reach[:, None] * ahead
