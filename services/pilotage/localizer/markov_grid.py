"""The belief over all poses of a building (Wu & Bell 2003), moved without interpolation.

A belief on fixed cells blurs when it moves by parts of a cell. Here motion moves the cells
instead: each heading's layer carries an offset from the map's cells, of less than half a cell,
and all headings share an origin that turns with the robot (`layers`). A motion adds to offsets
and origin, exactly; a layer is shifted by whole cells when its offset passes one half. What
spreads the belief is the odometry's uncertainty alone, gathered until it matters.

Work is done where the belief is (`focus`); the rest of it is known by a bound.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.grid import GridGeometry
from pilotage.localizer import kernels
from pilotage.localizer.compass import compass_likelihood
from pilotage.localizer.focus import Focus, FocusParams
from pilotage.localizer.gaussian_start import gaussian_start
from pilotage.localizer.heaviest import heaviest_states
from pilotage.localizer.kernels import Area, Prior, Runs, Sight
from pilotage.localizer.layers import Layers
from pilotage.localizer.likelihood_field import LikelihoodField
from pilotage.localizer.motion_spread import MotionSpread, SpreadDue
from pilotage.localizer.pose_grid import PoseGrid
from pilotage.localizer.range_model import RangeTable, ranges_of_levels
from pilotage.localizer.state_likelihood import ScanLikelihood, StateLikelihood, TileLikelihood
from pilotage.localizer.visibility import VisibilityParams, levels_allowed

__all__ = ["FocusParams", "MarkovGrid", "MotionSpread"]

NEGLIGIBLE = 1e-9
"""Share of the belief below which a state need not be weighed down any further."""

MOST_BEAMS = 1000
"""Costs of so many beams sum up within 16 bits."""

MOST_SIGHTS = 255
"""So many beams are counted within 8 bits."""


class MarkovGrid:
    """The belief: `predict` moves it; `add_floor`, `weigh_*` and `settle` correct it.

    Attributes:
        total: the sum of the belief and of the bound of its rest; 0 when the measurements have
            excluded every state (only under M1).
        runs: sums and maxima per run of `area`, as of the last measurement.
    """

    def __init__(
        self, grid: PoseGrid, spread: MotionSpread, focus: FocusParams | None = None
    ) -> None:
        self.grid = grid
        self._belief = np.zeros(grid.shape, np.float32)
        self._layers = Layers(grid)
        self._due = SpreadDue(spread, grid.geometry.resolution, grid.heading_step)
        self._focus = Focus(grid, focus or FocusParams())
        self._unchanged = Prior(1.0, 0.0, np.ones(grid.headings, np.float32))
        self._prior: Prior | None = None
        self._is_summed = False
        self._is_rest_weighed = False
        self._recovery_weight = 0.0
        self.set_uniform()

    @property
    def geometry(self) -> GridGeometry:
        """The cells of each layer."""
        return self.grid.geometry

    @property
    def belief(self) -> NDArray[np.float32]:
        """The belief (headings, rows, cols), summing to `total` with the rest; may be changed."""
        self._begin()
        self._is_summed = False
        return self._belief

    @property
    def area(self) -> Area:
        """Where the belief is worked on; elsewhere it is zero."""
        return self._focus.area

    @property
    def headings(self) -> NDArray[np.float64]:
        """Heading (headings,) of each layer in the grid frame [rad]."""
        return self._layers.headings

    @property
    def rest_mass(self) -> float:
        """Share of the total that is only bounded: what lies outside `area` weighs no more."""
        return self._focus.rest.mass / self.total if self.total > 0.0 else 0.0

    def set_uniform(self) -> None:
        """Believe in every admissible state alike."""
        self._forget()
        self._belief[:] = self.grid.admissible.mask / np.float32(self.grid.admissible_states)
        self.settle()

    def set_gaussian(self, map_from_base: ArrayLike, covariance: NDArray[np.float64]) -> None:
        """Believe in the surroundings of a pose (3,) with covariance (3, 3), both in map frame.

        ValueError, and an unchanged belief, if no admissible state is near it.
        """
        start = gaussian_start(self.grid, map_from_base, covariance)
        self._forget()
        self._belief[:] = 0.0
        self._belief[:, start.rows, start.cols] = start.weights
        self.settle()

    def set_states(self, poses: NDArray[np.float64], weights: NDArray[np.float64]) -> None:
        """Believe in poses (n, 3) of the map frame with weights (n,), and a little everywhere.

        What the weights lack to one is spread over all admissible states.
        """
        self._forget()
        even = max(0.0, 1.0 - float(weights.sum())) / self.grid.admissible_states
        self._belief[:] = np.float32(even)
        local = se2.compose(se2.inverse(self.grid.geometry.origin), poses)
        layers = np.rint(local[:, 2] / self.grid.heading_step).astype(np.int64)
        cells = self.grid.geometry.cells_of(poses[:, :2])
        inside = self.grid.geometry.contains(cells)
        states = (layers[inside] % self.grid.headings, *cells[inside].T)
        np.add.at(self._belief, states, weights[inside].astype(np.float32))
        self._belief *= self.grid.admissible.mask
        self.settle()

    def predict(self, increment: ArrayLike) -> None:
        """Move the belief by odometry's `increment` (3,): the new base seen from the old one."""
        dx, dy, turn = (float(value) for value in np.asarray(increment, float))
        self._begin()
        self._narrow()
        cells = self._layers.move(dx, dy, turn)
        self._due.add(float(np.hypot(dx, dy)), abs(turn))
        of_cells, of_headings = self._due.take_cells(), self._due.take_headings()
        reach = int(np.abs(cells).max()) + len(of_cells)
        self._focus.grow(self._belief, reach, len(of_headings))
        self._shift(cells)
        for share in of_cells:
            self._spread_cells(share)
        for share in of_headings:
            self._spread_headings(share)
        self._is_summed = False

    def add_floor(self, recovery_weight: float, compass: tuple[float, float] | None = None) -> None:
        """Begin a correction: `Bel <- P(b | l) (Bel + recovery_weight P0)` (eq. 8 and 12).

        Args:
            recovery_weight: of the floor P0 = 1 / |Omega|; 1 is the paper's M2, 0 its M1 (eq. 3).
            compass: yaw in the map frame and its standard deviation [rad], if measured.
        """
        self._begin()
        self._recovery_weight, self._is_rest_weighed = recovery_weight, False
        if not self._focus.allows(recovery_weight):
            self._focus.open(self._belief)
        floor = recovery_weight / self.grid.admissible_states
        scale = 1.0 / self.total if self.total > 0.0 else 0.0
        # Done by the first pass that weighs: the belief is then read and written but once.
        self._prior = Prior(scale, floor, self._compass_weights(compass))

    def weigh_scan(
        self, ends_base: NDArray[np.float64], field: LikelihoodField, tempering: float
    ) -> None:
        """`Bel <- P(s | l)^tempering Bel` for laser beams that end at `ends_base` (n, 2)."""
        used = ends_base[np.hypot(*ends_base.T) <= field.class_limits[-1]]
        for first in range(0, len(used), MOST_BEAMS):
            self._weigh_beams(used[first : first + MOST_BEAMS], field, tempering)

    def weigh_visibility(
        self, ends_base: NDArray[np.float64], table: RangeTable, params: VisibilityParams
    ) -> None:
        """Weigh down states from which beams to `ends_base` (n, 2) would go through walls.

        Only states of more than NEGLIGIBLE of the belief (as `settle` last summed it) are looked
        at: the term is at most 1, so all others could only become still lighter.
        """
        self._sum_up()
        allowed = levels_allowed(np.hypot(*ends_base.T), params)
        bearings = np.arctan2(*ends_base.T[::-1])
        directions = self._layers.directions_of(bearings, len(table.levels))
        factors = np.exp(-params.penalty * np.arange(MOST_SIGHTS + 1)).astype(np.float32)
        least = np.float32(NEGLIGIBLE * self.total)
        for first in range(0, len(allowed), MOST_SIGHTS):
            some = slice(first, first + MOST_SIGHTS)
            ahead = np.ascontiguousarray(directions[:, some])
            sight = Sight(ahead, table.levels, allowed[some], factors, least)
            kernels.weigh_visibility(self._belief, self.area, self.runs, sight)

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
        directions = self._layers.directions_of(bearings, len(table.levels))
        ahead = self._layers.offsets_along(bearings)
        of_layers = kernels.shift_levels(likelihoods, ranges_of_levels(table.range_max), ahead)
        echoes = kernels.echoes_of(directions, table.levels, of_layers)
        prior, of_rest = self._take_prior()
        if not self._focus.rest.is_empty:
            self._focus.rest.begin(of_rest)
        self._summed(kernels.weigh_ranges(self._belief, self.area, prior, echoes))

    def weigh_states(self, said: TileLikelihood) -> None:
        """`Bel <- P(said | l) Bel`, and the rest weighed by its bounds."""
        self._begin()
        said.weigh(self._belief, self.area)
        self._summed(kernels.sum_runs(self._belief, self.area))
        rest, self._is_rest_weighed = self._focus.rest, True
        if not rest.is_empty:
            rest.weigh_more(said.bounds(rest.tiles))
            self._wake(said)

    def settle(self) -> None:
        """End a correction: sum up what is left (the next one divides by it, eq. 8's a)."""
        self._begin()
        self._sum_up()
        total = float(self.runs.mass.sum()) + self._focus.rest.mass
        # Of less than this, 1 / total would overflow float32 and turn the belief into NaN.
        self.total = total if total > np.finfo(np.float32).tiny else 0.0

    def poses_of(self, states: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the poses (n, 3) in the map frame of states (n, 3) as heading, row, col."""
        return self._layers.poses_of(states)

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
        states, weights = heaviest_states(self._belief, self.area, self.runs, most)
        return states, weights.astype(np.float64) / self.total

    def scale_states(self, states: NDArray[np.int64], factors: NDArray[np.float32]) -> None:
        """Multiply different states (n, 3) by factors (n,) and sum the belief up anew."""
        self._begin()
        self._is_summed = False
        self._belief[tuple(states.T)] *= factors
        self.settle()

    def marginal(self) -> NDArray[np.float32]:
        """Return the share of the belief (rows, cols) in each cell, whatever the heading."""
        if self.total == 0.0:
            return np.zeros(self.grid.geometry.shape, np.float32)
        least = NEGLIGIBLE * self.total
        summed = kernels.sum_headings(self._belief, self.area, self.runs.mass, least)
        return summed / np.float32(self.total)

    def entropy(self) -> float:
        """Return H = -sum Bel log2 Bel in bits (Liu et al. 2008, eq. 5), to about 1e-3."""
        if self.total == 0.0:
            return 0.0
        bits = self._belief.view(np.int32)
        summed = kernels.sum_logarithms(self._belief, bits, self.area, self.runs.mass)
        # H of b / total is log2(total) - (sum b log2 b) / total.
        return max(0.0, float(np.log2(self.total) - summed / self.total))

    def _forget(self) -> None:
        """Put the layers back onto the map's cells and work on all of them."""
        self._layers.anchor()
        self._due.forget()
        self._focus.forget()
        self._prior, self._is_summed = None, False
        self._is_rest_weighed, self._recovery_weight = True, 0.0

    def _weigh_beams(
        self, ends_base: NDArray[np.float64], field: LikelihoodField, tempering: float
    ) -> None:
        ends = self._layers.cells_of_ends(ends_base)
        scan = field.scan(np.hypot(*ends_base.T), ends, tempering)
        rest, self._is_rest_weighed = self._focus.rest, True
        prior, of_rest = self._take_prior()
        self._summed(kernels.weigh_scan(self._belief, self.area, prior, scan))
        if not rest.is_empty:
            rest.weigh(of_rest, field.coarse_scan(scan, rest.tiles.phases))
            self._wake(ScanLikelihood(scan))

    def _wake(self, said: StateLikelihood) -> None:
        """Give back what the rest may hold that matters, once belief and rest are weighed."""
        if self._focus.wake(self._belief, said, float(self.runs.mass.sum())):
            self._summed(kernels.sum_runs(self._belief, self.area))

    def _take_prior(self) -> tuple[Prior, Prior]:
        """Return what belief and rest still have to be turned into before they are weighed.

        A rest takes all of the floor, so that what is empty in the boxes stays empty.
        """
        prior, self._prior = self._prior or self._unchanged, None
        return (prior if self._focus.rest.is_empty else prior._replace(floor=0.0)), prior

    def _begin(self) -> None:
        """Turn the belief into its prior, if that has not been done yet."""
        if self._prior is not None:
            prior, of_rest = self._take_prior()
            if not self._focus.rest.is_empty:
                self._focus.rest.begin(of_rest)
            self._summed(kernels.weigh_prior(self._belief, self.area, prior))

    def _summed(self, runs: Runs) -> None:
        self.runs, self._is_summed = runs, True

    def _sum_up(self) -> None:
        if not self._is_summed:
            self._summed(kernels.sum_runs(self._belief, self.area))

    def _narrow(self) -> None:
        """Work on no more than is worth it from now on.

        Ranges alone do not weigh the rest: its bound would grow at every correction.
        """
        if not self._is_rest_weighed:
            self._focus.open_if_heavy(self._belief, self.total)
        elif self._is_summed and self.total > 0.0 and self._focus.allows(self._recovery_weight):
            self._focus.narrow(self._belief, self.runs, self.total)

    def _shift(self, cells: NDArray[np.int64]) -> None:
        """Move the states by whole rows and cols (headings, 2)."""
        if cells.any():
            kernels.shift_layers(self._belief, self._focus.room, cells)
            if not self._focus.rest.is_empty:
                self._focus.rest.shift(cells)

    def _spread_cells(self, share: float) -> None:
        kernels.spread_layers(self._belief, self._focus.room, share)
        if not self._focus.rest.is_empty:
            self._focus.rest.spread(share)

    def _spread_headings(self, share: float) -> None:
        shifts = self._layers.shifts()
        kernels.spread_headings(self._belief, self._focus.room, share, shifts)
        if not self._focus.rest.is_empty:
            self._focus.rest.spread_headings(share, shifts)

    def _compass_weights(self, compass: tuple[float, float] | None) -> NDArray[np.float32]:
        if compass is None:
            return np.ones(self.grid.headings, np.float32)
        yaw, sigma = compass
        # A layer stands for all headings of its bin, hence the bin's own variance.
        widened = float(np.sqrt(sigma**2 + self.grid.heading_step**2 / 12.0))
        yaw_grid = yaw - self.grid.geometry.origin[2]
        return compass_likelihood(self.headings, yaw_grid, widened).astype(np.float32)
