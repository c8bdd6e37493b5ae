"""The Markov grid in plain numpy: the same steps, a layer at a time, without compiled code.

The twin that the product is measured against (and, in the tests, compared with). It works on the
first few headings only, so that it takes part of the time: a heading costs what another does.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.distance_field import distance_to_walls
from pilotage.localizer.compass import compass_likelihood
from pilotage.localizer.likelihood_field import LikelihoodFieldParams
from pilotage.localizer.pose_grid import PoseGrid
from pilotage.localizer.range_model import RangeTable, ranges_of_levels

SPREAD_SHARE = 0.08
"""What each neighbour gets where motion spreads the belief; one pass per prediction."""


class PlainField:
    """-log p of a beam's end (classes, rows + 2 margin, cols + 2 margin), float32.

    For maps whose cells are the belief's and lie along its axes.
    """

    def __init__(self, states: PoseGrid, params: LikelihoodFieldParams) -> None:
        geometry, resolution = states.geometry, states.geometry.resolution
        self.limits = np.array(params.class_limits)
        self.margin = int(np.ceil(self.limits[-1] / resolution)) + 2
        distance = _distance(states, self.margin)
        middles = (np.concatenate([[0.0], self.limits[:-1]]) + self.limits) / 2.0
        width = resolution**2 + (middles * states.heading_step) ** 2
        sigmas = np.sqrt(params.sigma**2 + width / 12.0)
        shape = np.array(geometry.shape) + 2 * self.margin
        self.costs = np.empty((len(sigmas), *shape), np.float32)
        for costs, sigma in zip(self.costs, sigmas, strict=True):
            hit = (1.0 - params.outlier) * np.exp(-0.5 * (distance / sigma) ** 2)
            costs[:] = -np.log(hit + params.outlier)


class PlainGrid:
    """The belief of the first `layers` headings (layers, rows, cols), float32."""

    def __init__(self, states: PoseGrid, layers: int) -> None:
        self.states = states
        self.headings = np.arange(layers, dtype=np.float64) * states.heading_step
        self.offsets = np.zeros((layers, 2))
        share = np.float32(1.0 / states.admissible_states)
        self.belief = np.tile(states.admissible.mask * share, (layers, 1, 1))

    def predict(self, increment: NDArray[np.float64], *, spreads: bool = True) -> None:
        """Move each layer by whole cells, keep the rest as offsets, and spread the belief."""
        dx, dy, turn = increment
        cos, sin = np.cos(self.headings), np.sin(self.headings)
        along = np.stack([cos * dx - sin * dy, sin * dx + cos * dy], axis=1)
        self.offsets += along / self.states.geometry.resolution
        self.headings = self.headings + turn
        whole = np.rint(self.offsets)
        self.offsets -= whole
        for layer, (right, up) in zip(self.belief, whole.astype(int), strict=True):
            _shift(layer, up, right)
        if spreads:
            self._spread()

    def add_floor(self, floor: float, compass: tuple[float, float] | None) -> None:
        """Begin a correction (eq. 8 and 12), `floor` being the weight of P0."""
        added = np.float32(floor / self.states.admissible_states)
        weights = np.ones(len(self.headings), np.float32)
        if compass is not None:
            yaw, sigma = compass
            widened = float(np.sqrt(sigma**2 + self.states.heading_step**2 / 12.0))
            weights = compass_likelihood(self.headings, yaw, widened).astype(np.float32)
        prior = (self.belief + added) * weights[:, None, None]
        self.belief = prior * self.states.admissible.mask

    def weigh_ranges(
        self, bearings: NDArray[np.float64], likelihoods: NDArray[np.float32], table: RangeTable
    ) -> None:
        """Multiply by the likelihood (n, 256) of each range, by expected level (eq. 14)."""
        turns = (self.headings[:, None] + bearings) / (2.0 * np.pi)
        directions = np.rint(turns * len(table.levels)).astype(int) % len(table.levels)
        aside, up = self.offsets.T[:, :, None] * self.states.geometry.resolution
        ahead = np.cos(2.0 * np.pi * turns) * aside + np.sin(2.0 * np.pi * turns) * up
        for k, along in enumerate(directions):
            for beam, direction in enumerate(along):
                of_levels = _shifted(likelihoods[beam], ahead[k, beam], table.range_max)
                self.belief[k] *= of_levels[table.levels[direction]]

    def weigh_scan(
        self, ends_base: NDArray[np.float64], field: PlainField, tempering: float
    ) -> None:
        """Multiply by P(s | l)^tempering of beams that end at `ends_base` (n, 2)."""
        ends = ends_base[np.hypot(*ends_base.T) <= field.limits[-1]]
        classes = np.searchsorted(field.limits, np.hypot(*ends.T))
        x, y = ends.T / self.states.geometry.resolution
        rows, cols = self.states.geometry.shape
        for k, (heading, (aside, up)) in enumerate(zip(self.headings, self.offsets, strict=True)):
            right = np.floor(0.5 + aside + np.cos(heading) * x - np.sin(heading) * y).astype(int)
            above = np.floor(0.5 + up + np.sin(heading) * x + np.cos(heading) * y).astype(int)
            total = np.zeros((rows, cols), np.float32)
            for kind, row, col in zip(
                classes, above + field.margin, right + field.margin, strict=True
            ):
                total += field.costs[kind, row : row + rows, col : col + cols]
            self.belief[k] *= np.exp(-np.float32(tempering) * total)

    def settle(self) -> float:
        """End a correction: make the belief sum to one; return what it summed to."""
        total = float(self.belief.sum(dtype=np.float64))
        self.belief /= np.float32(total)
        return total

    def _spread(self) -> None:
        """Give a share of each state to its neighbours in x and y, and in heading."""
        keep, give = np.float32(1.0 - 2.0 * SPREAD_SHARE), np.float32(SPREAD_SHARE)
        for layer in self.belief:
            for axis in (0, 1):
                padded = np.pad(layer, [(1, 1) if axis == a else (0, 0) for a in (0, 1)], "edge")
                before, after = (
                    np.take(padded, range(first, first + layer.shape[axis]), axis)
                    for first in (0, 2)
                )
                layer[:] = keep * layer + give * (before + after)
        ahead, behind = np.roll(self.belief, -1, axis=0), np.roll(self.belief, 1, axis=0)
        self.belief = keep * self.belief + give * (ahead + behind)


def _shift(layer: NDArray[np.float32], up: int, right: int) -> None:
    """Move a layer by whole cells in place; what enters is 0."""
    if not (up or right):
        return
    moved = np.zeros_like(layer)
    rows, cols = layer.shape
    into = slice(max(0, up), rows + min(0, up)), slice(max(0, right), cols + min(0, right))
    from_ = slice(max(0, -up), rows + min(0, -up)), slice(max(0, -right), cols + min(0, -right))
    moved[into] = layer[from_]
    layer[:] = moved


def _distance(states: PoseGrid, margin: int) -> NDArray[np.float64]:
    """Return the distance to the nearest wall at each cell's centre, infinity off the map."""
    geometry, world = states.geometry, states.world
    fine = distance_to_walls(world.is_wall, world.geometry.resolution)
    every = np.argwhere(np.ones(np.array(geometry.shape) + 2 * margin, bool)) - margin
    cells = world.geometry.cells_of(geometry.centres_of(every))
    inside = world.geometry.contains(cells)
    distance = np.full(len(cells), np.inf)
    distance[inside] = fine[tuple(cells[inside].T)]
    return distance.reshape(np.array(geometry.shape) + 2 * margin)


def _shifted(
    likelihoods: NDArray[np.float32], ahead: float, range_max: float
) -> NDArray[np.float32]:
    """Return likelihoods by level for states that lie so far [m] ahead of their cells."""
    ranges = ranges_of_levels(range_max)
    between = np.interp(ranges[:-1] - ahead, ranges, likelihoods)
    return np.append(between, likelihoods[-1]).astype(np.float32)
