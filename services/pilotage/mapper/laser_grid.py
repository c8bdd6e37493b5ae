"""The laser's occupancy grid: log-odds along exact rays, growing with what is seen.

Thrun, Burgard & Fox, Probabilistic Robotics, table 9.1, with bounded log-odds (Hornung et al. 2013,
OctoMap), so that a changed world is learnt in a few scans. Beyond it:

- Who walks through sight and out of it leaves nothing. A surface wider than a person is a wall at
  once. What is narrow becomes one when it is hit again, there or in a cell beside, after
  `lasting_time` or `lasting_travel`; a third of that does if something nearer hides part of it.
  Key scans, which come too far apart to confirm each other, wait only for what is narrow and seen
  whole.
- A beam that ends on a wall at a grazing angle runs along its rough face before it ends; that part
  of it speaks neither for nor against the wall.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.grid import FREE, OCCUPIED, UNKNOWN, GridGeometry, OccupancyMap
from pilotage.mapper.grid_patches import GridWindow
from pilotage.mapper.laser_grid_bounds import Bounds
from pilotage.mapper.laser_grid_clock import ScanClock
from pilotage.mapper.laser_grid_kernels import (
    PASSED,
    PROVEN,
    STEP,
    Layers,
    Place,
    insert_beams,
    raster,
    read_beams,
)
from pilotage.mapper.laser_grid_params import LOG_ODDS_UNIT, LaserGridParams, evidence_of

DEFAULT_PARAMS = LaserGridParams()

MOST_CELLS = 100_000_000
"""A map of 500 m x 500 m, 0.8 GB; one that would be larger comes of a pose gone wrong."""

FARTHEST = 1e7
"""No laser is farther from the map's origin, m."""


class LaserGrid:
    """What a laser has seen, drawn scan by scan."""

    def __init__(self, params: LaserGridParams = DEFAULT_PARAMS) -> None:
        self._params = params
        self._reading, self._weights = params.reading, params.weights
        self._layers = _layers((0, 0))
        self._cells = np.empty((0, 0), np.int8)
        self._corner = 0, 0
        self._extent: Bounds | None = None
        self._stale: Bounds | None = None
        self._changed: Bounds | None = None
        self._beams = np.empty((0, 5), np.int64)
        self._clock = ScanClock(params)

    @property
    def params(self) -> LaserGridParams:
        """How it learns."""
        return self._params

    def insert(
        self, origin: ArrayLike, ends: ArrayLike, is_hit: ArrayLike, stamp: float | None = None
    ) -> None:
        """Draw a scan.

        Args:
            origin: (2,) of the laser, map frame.
            ends: (n, 2) of the beams in the order of their bearings, map frame; beams with a NaN or
                infinity are left out.
            is_hit: (n,) whether something is there; without, the way to the end is free.
            stamp: s; without one, the scan counts as a key scan.

        Raises:
            ValueError: the laser is nowhere or so far away that the map would be too large.
        """
        x, y = (float(value) for value in np.asarray(origin, np.float64))
        if not (abs(x) <= FARTHEST and abs(y) <= FARTHEST):
            raise ValueError(f"the laser is at ({x}, {y}): a scan from nowhere cannot be drawn")
        points = np.ascontiguousarray(ends, np.float64).reshape(-1, 2)
        hits = np.ascontiguousarray(is_hit, np.bool_)
        if len(hits) != len(points):
            raise ValueError(f"{len(points)} ends, but is_hit has {len(hits)}")
        if len(self._beams) < len(points):
            self._beams = np.empty((len(points), 5), np.int64)
        beams = self._beams[: len(points)]
        bounds = Bounds(*read_beams(beams, (x, y), points, hits, self._reading))
        self._make_room(bounds)
        start = raster(x * self._reading.per_metre), raster(y * self._reading.per_metre)
        place = Place(self._corner, start, bounds)
        moment = self._clock.moment(x, y, stamp)
        insert_beams(self._layers, beams, place, self._weights, moment)
        # Proofs reach one cell beyond the hits.
        self._touch(bounds.widened(1))

    def map(self) -> OccupancyMap:
        """Return the map: 100 wall, 0 free, -1 never seen, or hit but not yet known to last."""
        self._render()
        if self._extent is None:
            empty = GridGeometry(0, 0, self._params.resolution)
            return OccupancyMap(empty, np.empty((0, 0), np.int8))
        cells = self._cells[self._slices(self._extent)].copy()
        return OccupancyMap(self._geometry(self._extent), cells)

    def changed(self) -> GridWindow | None:
        """Return where the map as it is now may have changed since this was asked last.

        If the map has grown meanwhile, its geometry differs too.
        """
        if self._changed is None or self._extent is None:
            return None
        area = self._changed.overlap(self._extent)
        self._changed = None
        corner = self._extent.row_from, self._extent.col_from
        return GridWindow(area.row_from - corner[0], area.col_from - corner[1], *area.shape)

    def log_odds(self) -> NDArray[np.float64]:
        """Return the log-odds (rows, cols) of the cells of `map`, NaN where nothing was seen."""
        if self._extent is None:
            return np.empty((0, 0))
        evidence = self._layers.evidence[self._slices(self._extent)]
        return np.where(evidence == 0, np.nan, (evidence & -STEP) / LOG_ODDS_UNIT)

    def state(self) -> dict[str, NDArray[np.generic]]:
        """Return all that `from_state` needs, as arrays by name."""
        extent = self._extent or Bounds(0, 0, 0, 0)
        area = self._slices(extent)
        return {
            "evidence": self._layers.evidence[area].copy(),
            "since": self._layers.since[area].copy(),
            "corner": np.array([extent.row_from, extent.col_from], np.int64),
            "clock": self._clock.state(),
        }

    @classmethod
    def from_state(
        cls, state: dict[str, NDArray[np.generic]], params: LaserGridParams = DEFAULT_PARAMS
    ) -> "LaserGrid":
        """Return the grid that gave `state`, under the same params.

        Raises:
            ValueError: arrays are missing or do not fit each other.
        """
        grid = cls(params)
        try:
            evidence, since = state["evidence"], state["since"]
            row, col = (int(value) for value in state["corner"])
            grid._clock.resume(state["clock"])
        except (KeyError, TypeError) as error:
            raise ValueError(f"this is no state of a laser grid: {error}") from error
        if evidence.ndim != 2 or evidence.shape != since.shape:
            raise ValueError(f"evidence {evidence.shape} and since {since.shape} do not fit")
        if evidence.size:
            bounds = Bounds(row, row + evidence.shape[0], col, col + evidence.shape[1])
            grid._make_room(bounds)
            grid._layers.evidence[grid._slices(bounds)] = evidence
            grid._layers.since[grid._slices(bounds)] = since
            grid._touch(bounds)
        return grid

    def make_room(self, low: ArrayLike, high: ArrayLike) -> None:
        """Grow at once to hold the points from `low` (2,) to `high` (2,), map frame."""
        lower = np.floor(np.asarray(low, float) * self._reading.per_metre).astype(int)
        upper = np.floor(np.asarray(high, float) * self._reading.per_metre).astype(int) + 1
        self._make_room(Bounds(int(lower[1]), int(upper[1]), int(lower[0]), int(upper[0])))

    def _touch(self, bounds: Bounds) -> None:
        """Note where cells may have changed."""
        self._stale = bounds.union(self._stale)
        self._changed = bounds.union(self._changed)

    def _make_room(self, bounds: Bounds) -> None:
        """Grow so that the cells of `bounds` are in the map."""
        wanted = bounds.in_blocks().union(self._extent)
        if wanted == self._extent:
            return
        if math.prod(wanted.shape) > MOST_CELLS:
            raise ValueError(f"the map would grow to {wanted.shape} cells: is the pose right?")
        rows, cols = self._layers.evidence.shape
        row, col = self._corner
        if wanted.overlap(Bounds(row, row + rows, col, col + cols)) != wanted:
            self._move_to(wanted.with_reserve(self._extent))
        self._extent = wanted

    def _move_to(self, held: Bounds) -> None:
        """Take new arrays over the cells of `held`, and what is known along."""
        layers, cells = _layers(held.shape), np.full(held.shape, UNKNOWN, np.int8)
        corner = held.row_from, held.col_from
        if self._extent is not None:
            old, new = self._slices(self._extent), self._extent.slices_from(corner)
            layers.evidence[new] = self._layers.evidence[old]
            layers.since[new] = self._layers.since[old]
            cells[new] = self._cells[old]
        self._layers, self._cells, self._corner = layers, cells, corner

    def _slices(self, bounds: Bounds) -> tuple[slice, slice]:
        """Return bounds as an index of the arrays."""
        return bounds.slices_from(self._corner)

    def _geometry(self, bounds: Bounds) -> GridGeometry:
        """Return the place of bounds in the map frame."""
        size = self._params.resolution
        return GridGeometry(
            *bounds.shape, size, (bounds.col_from * size, bounds.row_from * size, 0.0)
        )

    def _render(self) -> None:
        """Bring the map's cells up to date where scans were drawn."""
        if self._stale is None or self._extent is None:
            return
        area = self._slices(self._stale.overlap(self._extent))
        evidence = self._layers.evidence[area]
        is_wall = evidence >= evidence_of(self._params.occupied_log_odds)
        is_wall &= (evidence & PROVEN) != 0
        seen = np.where((evidence & PASSED) != 0, np.int8(FREE), np.int8(UNKNOWN))
        self._cells[area] = np.where(is_wall, np.int8(OCCUPIED), seen)
        self._stale = None


def _layers(shape: tuple[int, int]) -> Layers:
    """Return layers of nothing seen."""
    return Layers(np.zeros(shape, np.int16), np.zeros(shape, np.int32), np.zeros(shape, np.uint8))
