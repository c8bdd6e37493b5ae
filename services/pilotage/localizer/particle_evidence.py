"""What a measurement says about particles: all models of a map, multiplied.

Scans by the likelihood field and by what beams may not see through; single rangers by the
expected range (Wu & Bell 2003, eq. 5); compass (eq. 12); landmarks.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer import particle_kernels as kernels
from pilotage.localizer.compass import compass_likelihood
from pilotage.localizer.landmark_model import landmark_likelihoods
from pilotage.localizer.last_measurement import Novelty
from pilotage.localizer.measurement import Measurement, Ranges
from pilotage.localizer.obstacles import enclosed
from pilotage.localizer.particle_field import BeamModel, particle_field
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid
from pilotage.localizer.range_model import (
    LEVELS,
    RangeModelParams,
    RangeTable,
    range_likelihoods,
    range_table,
)
from pilotage.localizer.visibility import VisibilityParams, levels_allowed, optimistic_ranges

BLURS = 0.35, 0.15
"""Spread [m] of a beam's end, seen from poses known to 0.2 m and 5 degrees; to a third of that."""

HOPELESS = 15.0
"""-log of a particle's likelihood, relative to the best, from which visibility is not asked."""

Levels = NDArray[np.uint8]
"""Expected ranges (rows, cols, headings), see RangeTable."""


@dataclass(frozen=True)
class EvidenceParams:
    """Parameters of the sensor models.

    `tempering`: exponent of a scan's likelihood, see MarkovParams. `tables`: cells and headings of
    the tables of ranges. `visibility`: None leaves the term out, and saves its table.
    """

    tempering: float = 0.15
    beam: BeamModel = field(default_factory=BeamModel)
    ranges: RangeModelParams = field(default_factory=RangeModelParams)
    visibility: VisibilityParams | None = field(default_factory=VisibilityParams)
    tables: PoseGridParams = field(default_factory=PoseGridParams)


@dataclass(frozen=True)
class Word:
    """What a measurement says of particles: `logs` (n,), their log likelihoods.

    `fits` (n,): mean likelihood of the `parts`: beams, ranges, sightings; one where there are none.
    """

    logs: NDArray[np.float64]
    fits: NDArray[np.float64]
    parts: int


class ParticleEvidence:
    """The sensor models over one map.

    `sight` is the map's table of optimistic ranges, if it is at hand.
    """

    def __init__(
        self,
        world: OccupancyMap,
        params: EvidenceParams,
        sight: RangeTable | None = None,
        landmarks: LandmarkMap | None = None,
    ) -> None:
        self._world = enclosed(world)
        self._params = params
        self._landmarks = landmarks
        self._field = particle_field(self._world, params.beam)
        sigmas = [float(np.hypot(params.beam.sigma, blur)) for blur in BLURS]
        self._blurred = [particle_field(self._world, replace(params.beam, sigma=s)) for s in sigmas]
        self._cells = pose_grid(world, params.tables).geometry
        self.sight = sight or self._sight()
        self._sight_by_cell = None if self.sight is None else _by_cell(self.sight)
        self._range_max = 0.0
        self._expected: Levels | None = None

    def weigh(
        self, poses: NDArray[np.float64], seen: Measurement, novelty: Novelty | None = None
    ) -> Word:
        """Return what a measurement says about poses (n, 3)."""
        new = novelty or Novelty()
        raw, parts = np.zeros(len(poses)), 0
        logs = np.zeros(len(poses))
        if seen.ends is not None and len(self._field.used(seen.ends)):
            scan = self._field.log_likelihoods(poses, seen.ends)
            raw, parts = raw + scan, parts + len(self._field.used(seen.ends))
            logs += self._params.tempering * new.of_scan * scan
            logs += new.of_scan * self._seen_through(poses, seen.ends, logs)
        if seen.landmarks is not None and self._landmarks is not None and len(seen.landmarks.kinds):
            sighted = landmark_likelihoods(poses, seen.landmarks, self._landmarks)
            raw, parts = raw + sighted, parts + len(seen.landmarks.kinds)
            logs += new.of_ranges * sighted
        if seen.ranges is not None and len(seen.ranges.ranges):
            heard = self._of_ranges(poses, seen.ranges)
            raw, parts = raw + heard, parts + len(seen.ranges.ranges)
            logs += new.of_ranges * heard
        if seen.compass is not None:
            yaw, sigma = seen.compass
            logs += new.of_ranges * np.log(compass_likelihood(poses[:, 2], yaw, sigma))
        return Word(logs, np.exp(raw / max(1, parts)), parts)

    def weigh_coarsely(
        self, poses: NDArray[np.float64], seen: Measurement, novelty: Novelty, blur: int
    ) -> NDArray[np.float64]:
        """Return log likelihoods (n,) of poses that are known no better than BLURS[blur] says."""
        if seen.ends is None:
            return self.weigh(poses, seen, novelty).logs
        tempering = self._params.tempering * novelty.of_scan
        rest = self.weigh(poses, replace(seen, ends=None), novelty).logs
        return rest + tempering * self._blurred[blur].log_likelihoods(poses, seen.ends)

    def _seen_through(
        self, poses: NDArray[np.float64], ends: NDArray[np.float64], logs: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return -penalty times the beams that would go through a wall, for hopeful poses."""
        through, params = np.zeros(len(poses)), self._params.visibility
        if params is None or self._sight_by_cell is None:
            return through
        allowed = levels_allowed(np.hypot(*ends.T), params)
        costs = params.penalty * (np.arange(LEVELS + 1)[None, :] < allowed[:, None])
        hopeful = np.nonzero(logs >= logs.max() - HOPELESS)[0]
        bearings = np.arctan2(ends[:, 1], ends[:, 0])
        through[hopeful] = self._summed(poses[hopeful], bearings, costs, self._sight_by_cell)
        return -through

    def _of_ranges(self, poses: NDArray[np.float64], seen: Ranges) -> NDArray[np.float64]:
        if self._expected is None or self._range_max != seen.range_max:
            headings = self._params.tables.headings
            table = range_table(self._world, self._cells, headings, seen.range_max)
            self._expected, self._range_max = _by_cell(table), seen.range_max
        costs = -np.log(range_likelihoods(seen.ranges, seen.range_max, self._params.ranges))
        return -self._summed(poses, seen.bearings, costs, self._expected)

    def _summed(
        self,
        poses: NDArray[np.float64],
        bearings: NDArray[np.float64],
        costs: NDArray[np.floating],
        levels: Levels,
    ) -> NDArray[np.float64]:
        total = np.empty(len(poses))
        expected = (levels, _cells(self._cells))
        narrow = np.ascontiguousarray(costs, np.float32)
        kernels.sum_levels(poses, np.ascontiguousarray(bearings), narrow, expected, total)
        return total

    def _sight(self) -> RangeTable | None:
        params = self._params
        if params.visibility is None:
            return None
        headings = params.tables.headings
        return optimistic_ranges(self._world, self._cells, headings, params.visibility)


def _by_cell(table: RangeTable) -> Levels:
    """Return a table's levels with the headings of each cell next to each other."""
    return np.ascontiguousarray(table.levels.transpose(1, 2, 0))


def _cells(geometry: GridGeometry) -> kernels.Cells:
    """Return the place of a grid as a kernel takes it, without a table of its own."""
    nothing = np.empty(0, np.uint8)
    return kernels.Cells(nothing, geometry.cols, 0, *geometry.origin, geometry.resolution)
