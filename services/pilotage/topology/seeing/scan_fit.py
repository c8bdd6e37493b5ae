"""Whether a whole scan fits the occupancy map at a pose that a few features speak for.

Doors and corners repeat themselves through a building; the walls between them seldom do, and no
beam goes through one. Furniture and people only shorten beams, so that they count for little.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.topology.seeing.scan_view import ScanView


@dataclass(frozen=True)
class FitParams:
    """When a scan fits; lengths in m, shares of the beams that returned."""

    tolerance: float = 0.25
    """Between the range measured and the one expected: half a door's leaf, and the pose's error."""
    least_agreeing: float = 0.45
    """In a crowd every second beam ends at somebody; by chance every fifth fits."""
    most_through: float = 0.15
    """Farther than a wall allows: a door that was closed on the map makes some."""
    beams: int = 90
    """So many are looked at."""


def scan_fits(
    world: OccupancyMap,
    map_from_base: NDArray[np.float64],
    view: ScanView,
    params: FitParams = FitParams(),
) -> bool:
    """Say whether a scan taken at a pose (3,) is what the map lets one expect there."""
    returned = np.flatnonzero(np.isfinite(view.ranges))
    if len(returned) == 0:
        return False
    chosen = returned[:: max(1, len(returned) // params.beams)]
    measured = view.ranges[chosen]
    first, step = view.angles
    laser = se2.compose(map_from_base, view.mount)
    reach = float(measured.max()) + params.tolerance
    excess = measured - cast_scan(world, laser, first + step * chosen, reach)
    agreeing = np.abs(excess) <= params.tolerance
    through = excess > params.tolerance
    return bool(agreeing.mean() >= params.least_agreeing and through.mean() <= params.most_through)
