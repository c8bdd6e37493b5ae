"""An occupancy grid from the cones of a sonar ring (Li 2008, chapters 3 and 4).

The models differ in where in its cone they look for the obstacle; see `sonar_models`. All are
drawn in log-odds, which adds up to Bayes' rule (3-12) from a prior of 1/2.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.grid import OCCUPIED_FROM, UNKNOWN, GridGeometry, OccupancyMap
from pilotage.mapper.cell_layers import Box, CellLayers, both
from pilotage.mapper.echo_memory import EchoMemory, EchoMemoryParams
from pilotage.mapper.sonar_arcs import ArcCrossings
from pilotage.mapper.sonar_kernels import add_readings, bounds_of
from pilotage.mapper.sonar_models import KERNEL_OF, BeamShape, SonarModel
from pilotage.mapper.sonar_news import SonarNews, SonarNewsParams
from pilotage.mapper.sonar_ring import SonarReadings, SonarRing
from pilotage.mapper.temporal_filter import FREE_VOTE, OCCUPIED_VOTE, VERDICTS, close_slice

DOUBTFUL = 100 - OCCUPIED_FROM
"""What a cell shows at most if its last slices say that it is free."""


@dataclass(frozen=True)
class SonarGridParams:
    """How readings become cells; the defaults are what measured best on real rings."""

    resolution: float = 0.05
    """Side of a cell, m."""
    range_sigma: float = 0.03
    """delta of (3-10): how well a range is known, m; never drawn thinner than 3/4 of a cell."""
    visible_share: float = 0.6
    """rho_v of (3-8) as a share of the maximum range (the thesis's is 1.2 m of 4.0)."""
    certainty: float = 0.6
    """Certainty of the best single reading, 0 to 1; the thesis's 1 would decide for ever."""
    point_certainty: float = 0.84
    """The same of a place on the arc found by crossings."""
    limit: float = 6.0
    """Log-odds beyond which more of the same adds nothing, so that a changed world is believed."""
    least_said: float = 0.5
    """Log-odds below which a cell stays unknown, as at the edge of a cone: 38 to 62 % is no news,
    and whoever plans takes what is known and not occupied for free."""
    slice_rounds: int = 5
    """Rounds that make a slice of time."""
    temporal_filter: bool = False
    """Let the last slices of a cell decide (Li 2008, 4.7)."""
    news: SonarNewsParams = field(default_factory=SonarNewsParams)
    """Which readings are used."""
    echoes: EchoMemoryParams = field(default_factory=EchoMemoryParams)
    """How echoes are placed on their arcs, by the methods that do."""


class SonarGrid:
    """Draws rounds of a ring, heard at known poses, into a grid that grows as needed."""

    def __init__(
        self, params: SonarGridParams, ring: SonarRing, model: SonarModel = "improved_atm"
    ) -> None:
        self.params, self.model = params, model
        self._cells = CellLayers(params.resolution)
        self._echoes = EchoMemory(params.echoes, ring.cone, improved=model == "improved_atm")
        self._rounds = 0
        self._slice_box: Box | None = None
        self.use_ring(ring)

    def use_ring(self, ring: SonarRing) -> None:
        """Hear with this ring from now on."""
        self.ring = ring
        self._news = SonarNews(self.params.news, ring)
        self._echoes.cone = ring.cone
        self._shape = beam_shape(self.params, ring)

    def insert(
        self, map_from_base: ArrayLike, ranges: ArrayLike, *, is_turning: bool = False
    ) -> None:
        """Take in ranges (n,) in m of all sonars, heard at a pose (3,) in the map.

        Nothing is taken in while the robot turns: echoes then smear into a ring of noise.
        """
        if is_turning:
            return
        readings = self._news.of(self.ring.readings(map_from_base, ranges))
        self._draw(self._echoes.take(readings) if self._is_placing else _on_axis(readings))
        self._rounds += 1
        if self._rounds % self.params.slice_rounds == 0:
            self._close_slice()

    def map(self) -> OccupancyMap:
        """Return the map of all that was heard so far; cells in no cone are unknown."""
        waiting = self._echoes.waiting()
        self._cover(waiting)
        layers = self._cells
        if layers.log_odds.size == 0:
            return nothing_known(self.params.resolution)
        said = layers.log_odds + layers.recent
        self._add_to(said, waiting)
        cells = np.round(50.0 + 50.0 * np.tanh(said / 2.0)).astype(np.int8)
        cells[np.abs(said) < self.params.least_said] = UNKNOWN
        if self.params.temporal_filter:
            cells = filtered(cells, VERDICTS[layers.counts, layers.votes])
        return OccupancyMap(layers.geometry, cells)

    def crossings(self) -> ArcCrossings:
        """Return all transversal crossings of the arcs in memory, and which the model uses."""
        return self._echoes.crossings()

    def remember(self) -> dict[str, NDArray[np.generic]]:
        """Return all that `resume` needs; what sonars last said is heard anew."""
        return {**self._cells.remember(), **self._echoes.remember()}

    def resume(self, memory: Mapping[str, NDArray[np.generic]]) -> None:
        """Go on from what an earlier grid remembered; ValueError if it does not fit."""
        self._echoes.resume(memory)
        self._cells.resume(memory)
        self._slice_box = self._cells.box

    @property
    def _is_placing(self) -> bool:
        """Whether the model asks where on its arc an echo came from."""
        return self.model in {"atm", "improved_atm"}

    def _draw(self, echoes: NDArray[np.float64]) -> None:
        """Add echoes (k, 5) to the open slice."""
        box = self._cover(echoes)
        if box is not None:
            self._add_to(self._cells.recent, echoes)
            self._slice_box = both(self._slice_box, box)

    def _cover(self, echoes: NDArray[np.float64]) -> Box | None:
        """Make room for echoes (k, 5); return the box that they lie in, None if nowhere."""
        if len(echoes) == 0:
            return None
        box = bounds_of(echoes, self._shape)
        return box if self._cells.cover(box) else None

    def _add_to(self, layer: NDArray[np.float32], echoes: NDArray[np.float64]) -> None:
        """Draw echoes (k, 5) in log-odds (rows, cols)."""
        cells, model = self._cells, KERNEL_OF[self.model]
        add_readings(layer, cells.corner, cells.resolution, echoes, model, self._shape)

    def _close_slice(self) -> None:
        """Let the cells of the open slice vote, and begin another."""
        if self._slice_box is None:
            return
        cells, here = self._cells, self._cells.window(self._slice_box)
        layers = cells.log_odds[here], cells.recent[here], cells.votes[here], cells.counts[here]
        close_slice(*layers, self.params.limit)
        self._slice_box = None


def nothing_known(resolution: float) -> OccupancyMap:
    """Return a map of one unknown cell."""
    return OccupancyMap(GridGeometry(1, 1, resolution), np.full((1, 1), UNKNOWN, np.int8))


def beam_shape(params: SonarGridParams, ring: SonarRing) -> BeamShape:
    """Return how the sonars of a ring are drawn."""
    depth = max(params.range_sigma, 0.75 * params.resolution)
    visible = params.visible_share * ring.range_max
    return BeamShape(
        half_cone=ring.half_cone,
        depth=depth,
        visible=visible,
        certainty=params.certainty,
        point_certainty=params.point_certainty,
        width=params.resolution,
    )


def filtered(cells: NDArray[np.int8], verdicts: NDArray[np.uint8]) -> NDArray[np.int8]:
    """Return cells (rows, cols) of 0 to 100 as their last slices will have them."""
    free = np.where(verdicts == FREE_VOTE, np.minimum(cells, DOUBTFUL), cells)
    return np.where(verdicts == OCCUPIED_VOTE, np.maximum(free, OCCUPIED_FROM), free)


def _on_axis(readings: SonarReadings) -> NDArray[np.float64]:
    """Return readings (k, 4) as echoes (k, 5) from the middle of their arcs."""
    return np.column_stack([readings, np.zeros(len(readings))])
