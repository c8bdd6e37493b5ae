"""How the laser's grid learns."""

import math
from dataclasses import dataclass

from pilotage.mapper.laser_grid_kernels import STEP, Reading, Weights

LOG_ODDS_UNIT = 256
"""Evidence of a log-odds of one."""

TICKS = 1000
"""Ticks of the clock to a proof."""

GLIMPSE = 0.3
"""Share of a proof that does for an obstacle that something hides in part."""


@dataclass(frozen=True)
class LaserGridParams:
    """How a grid learns."""

    resolution: float = 0.05
    """Side of a cell, m."""
    hit_log_odds: float = 0.85
    """What a scan adds to a cell that a beam ends in (OctoMap: 0.85)."""
    miss_log_odds: float = 0.3
    """What it takes off a cell that beams only pass (OctoMap's 0.4): the legs of chairs are passed
    by most beams, and missed by some scans for errors of pose."""
    limit_log_odds: float = 2.5
    """A cell is never surer than this: 92 % (OctoMap's 97 %)."""
    occupied_log_odds: float = 0.62
    """Log-odds from which a cell is occupied: 65 %."""
    lasting_time: float = 1.0
    """An obstacle is a wall if it is hit again after so many s."""
    lasting_travel: float = 0.5
    """Or after the laser went so many m."""
    wall_depth_cells: float = 1.0
    """How deep the faces of walls lie in their cells, with the error of poses."""
    graze_max: float = 2.0
    """Of a beam that grazes a wall at most so many m are disregarded."""
    surface_gap: float = 0.25
    """Ends of neighbouring beams this near are one surface, m."""
    person_width: float = 1.0
    """A surface longer than this is no person, nor two, and needs not last, m."""
    range_max: float = 80.0
    """Beams are cut there, m."""

    def __post_init__(self) -> None:
        """Refuse what cannot be drawn with (ValueError)."""
        positive = ("resolution", "hit_log_odds", "miss_log_odds", "lasting_time", "range_max")
        for name in (*positive, "lasting_travel"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise ValueError(f"{name} must be a positive number, it is {getattr(self, name)}")
        if not 0.0 < self.occupied_log_odds <= self.limit_log_odds <= 100.0:
            raise ValueError("0 < occupied_log_odds <= limit_log_odds <= 100 must hold")

    @property
    def reading(self) -> Reading:
        """How beams become cells."""
        longest, graze = self.range_max / self.resolution, self.graze_max / self.resolution
        gap, piece = self.surface_gap, self.person_width
        return Reading(1.0 / self.resolution, longest, self.wall_depth_cells, graze, gap, piece)

    @property
    def weights(self) -> Weights:
        """What cells learn."""
        limit = evidence_of(self.limit_log_odds)
        hit, miss = evidence_of(self.hit_log_odds), evidence_of(self.miss_log_odds)
        return Weights(hit, miss, -limit, limit, TICKS, round(TICKS * GLIMPSE))


def evidence_of(log_odds: float) -> int:
    """Return log-odds as evidence."""
    return max(1, round(log_odds * LOG_ODDS_UNIT / STEP)) * STEP
