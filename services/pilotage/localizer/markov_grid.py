"""The belief over all poses of a building (Wu & Bell 2003), moved without interpolation.

A belief on fixed cells blurs when it moves by parts of a cell. Here motion moves the cells
instead: each heading's layer carries an offset from the map's cells, of less than half a cell,
and all headings share an origin that turns with the robot. A motion adds to offsets and origin,
exactly; a layer is shifted by whole cells when its offset passes one half. What spreads the
belief is the odometry's uncertainty alone, gathered until it matters.

Frames: `grid` is the map frame moved to the corner of cell (0, 0) and turned to its axes.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.localizer import kernels
from pilotage.localizer.compass import compass_likelihood
from pilotage.localizer.gaussian_start import gaussian_start
from pilotage.localizer.kernels import Prior, Sight
from pilotage.localizer.likelihood_field import STEPS, LikelihoodField
from pilotage.localizer.pose_grid import PoseGrid
from pilotage.localizer.range_model import RangeTable
from pilotage.localizer.visibility import VisibilityParams, levels_allowed


@dataclass(frozen=True)
class MotionSpread:
    """How odometry's uncertainty grows; variances add up along the way.

    `translation`: [m per sqrt(m)] from the way; `translation_from_turn`: [m per sqrt(rad)];
    `rotation`: [rad per sqrt(rad)] from turning; `rotation_from_way`: [rad per sqrt(m)].
    """

    translation: float = 0.06
    translation_from_turn: float = 0.02
    rotation: float = 0.06
    rotation_from_way: float = 0.05


LEAST_SHARE = 0.08
"""Spreading waits until each neighbour would get this share: fewer passes, the same variance."""

MOST_SHARE = 0.25

NEGLIGIBLE = 1e-9
"""Share of the belief below which a state need not be weighed down any further."""


class MarkovGrid:
    """The belief: `predict` moves it; `add_floor`, `weigh_*` and `settle` correct it.

    Attributes:
        belief: (headings, rows, cols) float32, summing to `total`.
        total: its sum, 0 when the measurements have excluded every state (only under M1).
        runs: sums and maxima per run of admissible states, as of the last measurement.
    """

    def __init__(self, grid: PoseGrid, spread: MotionSpread) -> None:
        self.grid = grid
        self.belief = np.zeros(grid.shape, np.float32)
        self._spread = spread
        self._origin_heading = 0.0
        self._offsets = np.zeros((grid.headings, 2))
        self._variance_cells = 0.0
        self._variance_headings = 0.0
        self.set_uniform()

    @property
    def headings(self) -> NDArray[np.float64]:
        """Heading (headings,) of each layer in the grid frame [rad]."""
        steps = np.arange(self.grid.headings) * self.grid.heading_step
        turned: NDArray[np.float64] = np.add(self._origin_heading, steps)
        return wrap(turned)

    def set_uniform(self) -> None:
        """Believe in every admissible state alike."""
        self._anchor()
        self.belief[:] = self.grid.admissible.mask / np.float32(self.grid.admissible_states)
        self.settle()

    def set_gaussian(self, map_from_base: ArrayLike, covariance: NDArray[np.float64]) -> None:
        """Believe in the surroundings of a pose (3,) with covariance (3, 3), both in map frame.

        ValueError, and an unchanged belief, if no admissible state is near it.
        """
        start = gaussian_start(self.grid, map_from_base, covariance)
        self._anchor()
        self.belief[:] = 0.0
        self.belief[:, start.rows, start.cols] = start.weights
        self.settle()

    def set_states(self, poses: NDArray[np.float64], weights: NDArray[np.float64]) -> None:
        """Believe in poses (n, 3) of the map frame with weights (n,), and a little everywhere.

        What the weights lack to one is spread over all admissible states.
        """
        self.set_uniform()
        self.belief *= np.float32(max(0.0, 1.0 - float(weights.sum())))
        local = se2.compose(se2.inverse(self.grid.geometry.origin), poses)
        layers = np.rint(local[:, 2] / self.grid.heading_step).astype(np.int64)
        cells = self.grid.geometry.cells_of(poses[:, :2])
        inside = self.grid.geometry.contains(cells)
        states = (layers[inside] % self.grid.headings, *cells[inside].T)
        np.add.at(self.belief, states, weights[inside].astype(np.float32))
        self.belief *= self.grid.admissible.mask
        self.settle()

    def predict(self, increment: ArrayLike) -> None:
        """Move the belief by odometry's `increment` (3,): the new base seen from the old one."""
        dx, dy, turn = np.asarray(increment, float)
        way = float(np.hypot(dx, dy))
        headings = self.headings
        cos, sin = np.cos(headings), np.sin(headings)
        self._offsets[:, 0] += (cos * dx - sin * dy) / self.grid.geometry.resolution
        self._offsets[:, 1] += (sin * dx + cos * dy) / self.grid.geometry.resolution
        self._origin_heading = wrap(self._origin_heading + float(turn))
        self._shift_layers()
        self._gather_variance(way, abs(float(turn)))

    def add_floor(self, recovery_weight: float, compass: tuple[float, float] | None = None) -> None:
        """Begin a correction: `Bel <- P(b | l) (Bel + recovery_weight P0)` (eq. 8 and 12).

        Args:
            recovery_weight: of the floor P0 = 1 / |Omega|; 1 is the paper's M2, 0 its M1 (eq. 3).
            compass: yaw in the map frame and its standard deviation [rad], if measured.
        """
        floor = recovery_weight / self.grid.admissible_states
        scale = 1.0 / self.total if self.total > 0.0 else 0.0
        prior = Prior(scale, floor, self._compass_weights(compass))
        kernels.add_floor(self.belief, self.grid.admissible, prior)

    def weigh_scan(
        self, ends_base: NDArray[np.float64], field: LikelihoodField, tempering: float
    ) -> None:
        """`Bel <- P(s | l)^tempering Bel` for laser beams that end at `ends_base` (n, 2)."""
        used = ends_base[np.hypot(*ends_base.T) <= field.class_limits[-1]]
        costs = np.arange(len(used) * STEPS + 1) * (field.step * tempering)
        likelihood = np.exp(-costs).astype(np.float32)
        beams = self._scan_beams(used, field)
        kernels.weigh_scan(self.belief, self.grid.admissible, beams, field.costs, likelihood)

    def weigh_visibility(
        self, ends_base: NDArray[np.float64], table: RangeTable, params: VisibilityParams
    ) -> None:
        """Weigh down states from which beams to `ends_base` (n, 2) would go through walls.

        Only states of more than NEGLIGIBLE of the belief (as `settle` last summed it) are looked
        at: the term is at most 1, so all others could only become still lighter.
        """
        allowed = levels_allowed(np.hypot(*ends_base.T), params)
        directions = self._range_directions(np.arctan2(*ends_base.T[::-1]), table)
        sight = Sight(directions, allowed, np.float32(NEGLIGIBLE * self.total))
        factors = np.exp(-params.penalty * np.arange(len(allowed) + 1)).astype(np.float32)
        kernels.weigh_visibility(self.belief, self.grid.admissible, sight, table.levels, factors)

    def weigh_ranges(
        self,
        bearings: NDArray[np.float64],
        likelihoods: NDArray[np.float32],
        table: RangeTable,
    ) -> None:
        """`Bel <- P(s_1 | l) ... P(s_n | l) Bel` (eq. 14) for single rangers.

        Args:
            bearings: (n,) directions in base_link.
            likelihoods: (n, 256) of each range, by expected level (see range_model).
            table: expected ranges.
        """
        directions = self._range_directions(bearings, table)
        kernels.weigh_ranges(
            self.belief, self.grid.admissible, directions, table.levels, likelihoods
        )

    def settle(self) -> None:
        """End a correction: sum up what is left (the next one divides by it, eq. 8's a)."""
        self.runs = kernels.sum_runs(self.belief, self.grid.admissible)
        total = float(self.runs.mass.sum())
        # Of less than this, 1 / total would overflow float32 and turn the belief into NaN.
        self.total = total if total > np.finfo(np.float32).tiny else 0.0

    def poses_of(self, states: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the poses (n, 3) in the map frame of states (n, 3) as heading, row, col."""
        k, row, col = states.T
        resolution = self.grid.geometry.resolution
        x = (col + 0.5 + self._offsets[k, 0]) * resolution
        y = (row + 0.5 + self._offsets[k, 1]) * resolution
        grid_from_base = np.stack([x, y, self.headings[k]], axis=1)
        return se2.compose(self.grid.geometry.origin, grid_from_base)

    def heaviest(self, most: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return poses (n, 3) and weights (n,) of about the `most` heaviest states.

        Weights are shares of the whole belief: what they lack to one lies elsewhere.
        """
        states, weights = self.heaviest_states(most)
        return self.poses_of(states), weights

    def heaviest_states(self, most: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return about the `most` heaviest states (n, 3), as heading, row, col, and weights (n,).

        Weights are shares of the whole belief.
        """
        if self.total == 0.0:
            return np.empty((0, 3), np.int64), np.empty(0)
        states, weights = self._states_above(self._threshold(most), most)
        if len(weights) > most:
            order = np.argpartition(weights, -most)[-most:]
            states, weights = states[order], weights[order]
        return states, weights.astype(np.float64) / self.total

    def scale_states(self, states: NDArray[np.int64], factors: NDArray[np.float32]) -> None:
        """Multiply different states (n, 3) by factors (n,) and sum the belief up anew."""
        self.belief[tuple(states.T)] *= factors
        self.settle()

    def marginal(self) -> NDArray[np.float32]:
        """Return the share of the belief (rows, cols) in each cell, whatever the heading."""
        if self.total == 0.0:
            return np.zeros(self.grid.geometry.shape, np.float32)
        least = NEGLIGIBLE * self.total
        summed = kernels.sum_headings(self.belief, self.grid.admissible, self.runs.mass, least)
        return summed / np.float32(self.total)

    def entropy(self) -> float:
        """Return H = -sum Bel log2 Bel in bits (Liu et al. 2008, eq. 5), to about 1e-3."""
        if self.total == 0.0:
            return 0.0
        bits = self.belief.view(np.int32)
        summed = kernels.sum_logarithms(self.belief, bits, self.grid.admissible, self.runs.mass)
        # H of b / total is log2(total) - (sum b log2 b) / total.
        return max(0.0, float(np.log2(self.total) - summed / self.total))

    def _threshold(self, most: int) -> float:
        """Return a weight that about `most` states at most exceed, judged by the runs' maxima."""
        peaks = self.runs.peak.ravel()
        highest = float(peaks.max())
        busiest = max(1, most // 8)
        usual = float(np.partition(peaks, -busiest)[-busiest]) if len(peaks) > busiest else 0.0
        return max(highest * 1e-4, min(usual, highest * 0.999))

    def _states_above(
        self, threshold: float, most: int
    ) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Return the states (n, 3) above a threshold, and weights (n,), in the `most` best runs.

        The `most` heaviest states lie in no more runs than that, and an even belief, where every
        state is above the threshold, must not be gathered as a whole.
        """
        layers, runs = np.nonzero(self.runs.peak > threshold)
        if len(layers) > most:
            best = np.argpartition(self.runs.peak[layers, runs], -most)[-most:]
            layers, runs = layers[best], runs[best]
        states, weights = [np.empty((0, 3), np.int64)], [np.empty(0, np.float32)]
        for k, (row, first, last) in zip(layers, self.grid.admissible.runs[runs], strict=True):
            run = self.belief[k, row, first:last]
            cols = np.nonzero(run > threshold)[0]
            places = np.column_stack([np.full_like(cols, k), np.full_like(cols, row), cols + first])
            states.append(places)
            weights.append(run[cols])
        return np.concatenate(states), np.concatenate(weights)

    def _anchor(self) -> None:
        """Put the layers back onto the map's cells."""
        self._origin_heading = 0.0
        self._offsets[:] = 0.0
        self._variance_cells = self._variance_headings = 0.0

    def _scan_beams(
        self, ends_base: NDArray[np.float64], field: LikelihoodField
    ) -> NDArray[np.int64]:
        """Return class, row and col (headings, n, 3) by which each beam's end lies off a state."""
        cos, sin = np.cos(self.headings)[:, None], np.sin(self.headings)[:, None]
        x, y = ends_base.T / self.grid.geometry.resolution
        cols = np.floor(0.5 + self._offsets[:, :1] + cos * x - sin * y) + field.margin
        rows = np.floor(0.5 + self._offsets[:, 1:] + sin * x + cos * y) + field.margin
        classes = np.broadcast_to(field.classes_of(np.hypot(*ends_base.T)), rows.shape)
        return np.stack([classes, rows, cols], axis=-1).astype(np.int64)

    def _range_directions(
        self, bearings: NDArray[np.float64], table: RangeTable
    ) -> NDArray[np.int64]:
        """Return the layer (headings, n) of the range table that each bearing points along."""
        count = len(table.levels)
        map_headings = self.headings + self.grid.geometry.origin[2]
        turns = (map_headings[:, None] + bearings[None, :]) / (2.0 * np.pi)
        return np.rint(turns * count).astype(np.int64) % count

    def _shift_layers(self) -> None:
        whole = np.rint(self._offsets).astype(np.int64)
        for k in np.nonzero(whole.any(axis=1))[0]:
            right, up = whole[k]
            kernels.shift_layer(self.belief[k], int(up), int(right))
        self._offsets -= whole

    def _gather_variance(self, way: float, turn: float) -> None:
        spread, resolution = self._spread, self.grid.geometry.resolution
        along = spread.translation**2 * way + spread.translation_from_turn**2 * turn
        around = spread.rotation**2 * turn + spread.rotation_from_way**2 * way
        self._variance_cells += along / resolution**2
        self._variance_headings += around / self.grid.heading_step**2
        while self._variance_cells / 2.0 >= LEAST_SHARE:
            share = min(self._variance_cells / 2.0, MOST_SHARE)
            for layer in self.belief:
                kernels.spread_layer(layer, share)
            self._variance_cells -= 2.0 * share
        while self._variance_headings / 2.0 >= LEAST_SHARE:
            share = min(self._variance_headings / 2.0, MOST_SHARE)
            kernels.spread_headings(self.belief, share, self._layer_shifts())
            self._variance_headings -= 2.0 * share

    def _layer_shifts(self) -> NDArray[np.int64]:
        """Return by how many whole rows and cols (headings, 2) layer k + 1 lies beyond layer k."""
        apart = np.roll(self._offsets, -1, axis=0) - self._offsets
        return np.rint(apart[:, ::-1]).astype(np.int64)

    def _compass_weights(self, compass: tuple[float, float] | None) -> NDArray[np.float32]:
        if compass is None:
            return np.ones(self.grid.headings, np.float32)
        yaw, sigma = compass
        # A layer stands for all headings of its bin, hence the bin's own variance.
        widened = float(np.sqrt(sigma**2 + self.grid.heading_step**2 / 12.0))
        yaw_grid = yaw - self.grid.geometry.origin[2]
        return compass_likelihood(self.headings, yaw_grid, widened).astype(np.float32)
