"""How the laser's grid learns."""

import math
from dataclasses import dataclass

from pilotage.mapper.laser_grid_kernels import STEP, Reading, Weights

LOG_ODDS_UNIT = 256
"""Evidence of a log-odds of one."""

TICKS = 1000
"""Ticks of the clock to a proof."""


@dataclass(frozen=True)
class LaserGridParams:
    """How a grid learns."""

    resolution: float = 0.05
    """Side of a cell, m."""
    hit_log_odds: float = 0.85
    """What a scan adds to a cell that a beam ends in (OctoMap's 0.7)."""
    miss_log_odds: float = 0.4
    """What it takes off a cell that beams only pass (OctoMap's 0.4)."""
    limit_log_odds: float = 3.5
    """A cell is never surer than this (OctoMap's 0.97)."""
    occupied_log_odds: float = 0.62
    """Log-odds from which a cell is occupied: 65 %."""
    lasting_time: float = 1.0
    """An obstacle is a wall if it is hit again after so many s."""
    lasting_travel: float = 0.5
    """Or after the laser went so many m."""
    wall_depth: float = 0.05
    """Roughness of a wall's face with the error of poses, m."""
    graze_max: float = 1.0
    """Of a beam that grazes a wall at most so many m are disregarded."""
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
        lengths = self.range_max, self.wall_depth, self.graze_max
        return Reading(1.0 / self.resolution, *(length / self.resolution for length in lengths))

    @property
    def weights(self) -> Weights:
        """What cells learn."""
        limit = evidence_of(self.limit_log_odds)
        hit, miss = evidence_of(self.hit_log_odds), evidence_of(self.miss_log_odds)
        return Weights(hit, miss, -limit, limit, TICKS)


def evidence_of(log_odds: float) -> int:
    """Return log-odds as evidence."""
    return max(1, round(log_odds * LOG_ODDS_UNIT / STEP)) * STEP
