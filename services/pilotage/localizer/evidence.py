"""How much a scan speaks for a pose: beam by beam, against the map between the cells.

A likelihood field asks only where a beam ends. Among beams that end on a wall there are some that
went through another wall first: a right pose has hardly any of them, a wrong one many, for what
a map lacks makes readings shorter, and hardly anything makes them longer (methods E). So each
beam is sorted by how far its end lies from an obstacle, and by whether it fell short of
the first obstacle on its way, met it, or went through it; each kind has its weight of evidence.

The weights are log-likelihood ratios between right and wrong poses, found on simulated tracks
through eight buildings with and without clutter, rounded, and bounded so that no beam decides
alone. Those of beams that went through count half of what simulation says: real maps draw door
leaves and jambs too thick, and doors stand open now that were shut (Wean Hall).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.localizer.evidence_kernels import Scales, Scan, Weights, weigh_poses
from pilotage.localizer.measurement import Beams
from pilotage.localizer.obstacles import Obstacles

END_LIMITS = np.array([0.05, 0.1, 0.2, 0.4])
"""Classes of an end's distance from the nearest obstacle [m]."""

USUAL_CELL = 0.1
"""Size of a cell [m] for which those hold; an exact beam ends half a cell from a cell's middle."""

WEIGHTS = np.array(
    [
        # < 0.05, < 0.1, < 0.2, < 0.4, more [m] from an obstacle
        [-1.0, -1.0, -1.2, -1.2, -0.9],  # went through an obstacle
        [0.5, 0.2, -1.2, -0.6, 0.0],  # met it
        [0.8, 0.1, -1.0, -0.5, 0.0],  # fell short of it
    ]
)
"""Weight of evidence [nat] of a beam that came back."""

SILENT_WEIGHTS = np.array([-1.8, 0.3])
"""Weight [nat] of a beam that met nothing: where something is within reach, and where not."""

SILENT_REACH = 6.0
"""Farther away [m] things may well send nothing back: dark ones, and walls met at a slant."""

TOLERANCE = 0.3
"""A beam that ends within this distance [m] of the first obstacle on its way has met it."""

BESIDE, CELLS_BESIDE = 0.1, 2.0
"""A beam that passes an obstacle at this distance [m], or of so many cells, may have missed it."""

GRAZE = 0.3
"""A beam that stays this near [m] to walls beyond the first one that it meets runs along it."""

EVIDENCE_BEAMS = 90
"""Beams that are weighed; neighbours of theirs would say the same."""

PULL = 0.25
"""Scale [m] beyond which a beam's end no longer pulls at a pose."""

MOST_MOVED, MOST_TURNED = 0.35, 0.2
"""A pose refined by more than this [m, rad] is another place: not believed."""


@dataclass(frozen=True)
class Weighed:
    """Poses (n, 3) in map, put where the scan fits best, and what it says about each.

    `evidence` (n,) [nat] of all beams together, `met` (n,) the share of beams that met what the
    map shows, `through` (n,) the share that went through it; `fit` (n,) [nat] is the mean
    evidence of a beam, however new.
    """

    poses: NDArray[np.float64]
    evidence: NDArray[np.float64]
    met: NDArray[np.float64]
    through: NDArray[np.float64]
    fit: NDArray[np.float64]


def chosen_beams(beams: Beams) -> Beams:
    """Return the beams that are weighed: evenly spread, with and without a return."""
    count = min(EVIDENCE_BEAMS, len(beams.ranges))
    chosen = np.rint(np.linspace(0, len(beams.ranges) - 1, count)).astype(np.int64)
    return Beams(
        beams.bearings[chosen], beams.ranges[chosen], beams.base_from_laser, beams.range_max
    )


def weigh(
    map_from_base: NDArray[np.float64],
    beams: Beams,
    novelty: NDArray[np.float64],
    around: Obstacles,
) -> Weighed:
    """Refine poses (n, 3) on a scan and weigh them by it.

    Args:
        map_from_base: where the robot might be.
        beams: the scan, (m,) beams; poses are refined on all that came back.
        novelty: (k,) of `chosen_beams(beams)`: how much each counts.
        around: the obstacles.
    """
    cell = around.geometry.resolution
    refined, sums = weigh_poses(
        around.distance,
        around.in_cells(np.reshape(map_from_base, (-1, 3))),
        _in_cells(beams, novelty, cell),
        _scales(cell),
        Weights(WEIGHTS, SILENT_WEIGHTS),
    )
    return Weighed(around.in_map(refined), *(np.ascontiguousarray(part) for part in sums.T))


def _scales(cell: float) -> Scales:
    """Return the scales in cells of `cell` m."""
    return Scales(
        limits=END_LIMITS * max(1.0, cell / USUAL_CELL) / cell,
        tolerance=TOLERANCE / cell,
        beside=max(BESIDE, CELLS_BESIDE * cell) / cell,
        graze=GRAZE / cell,
        pull=PULL / cell,
        moved=MOST_MOVED / cell,
        turned=MOST_TURNED,
    )


def _in_cells(beams: Beams, novelty: NDArray[np.float64], cell: float) -> Scan:
    """Return a scan as the kernels take it, lengths in cells of `cell` m."""
    chosen = chosen_beams(beams)
    silent = ~np.isfinite(chosen.ranges)
    reach = min(beams.range_max, SILENT_REACH)
    lengths = np.where(silent, reach, chosen.ranges) / cell
    rays = np.column_stack([chosen.bearings, lengths, silent.astype(float), novelty])
    mount = np.asarray(beams.base_from_laser, float) / np.array([cell, cell, 1.0])
    return Scan(ends_in_base(beams) / cell, rays, mount)


def ends_in_base(beams: Beams) -> NDArray[np.float64]:
    """Return the ends (n, 2) in base_link of the beams that came back."""
    back = np.isfinite(beams.ranges)
    ranges, bearings = beams.ranges[back], beams.bearings[back]
    ends = np.stack([ranges * np.cos(bearings), ranges * np.sin(bearings)], axis=1)
    return se2.transform_points(beams.base_from_laser, ends)
