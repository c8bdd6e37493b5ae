"""What was seen and the map lacks, for a while: furniture, parcels, people; pure."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.laser_view import View
from pilotage.planner.ground import Ground

Cells = NDArray[np.int64]
Points = NDArray[np.float64]

FARTHEST = 6.0
"""m: what is farther away is seen too badly to be told from the walls."""
HEADING_ERROR = 0.02
"""rad by which the heading may be wrong: what is seen far away is displaced by so much."""
BESIDE = 0.10
"""m to the sides of a direction within which nothing may stand for it to be free."""
BEYOND = 0.20
"""m by which one must see farther than a place for it to be free."""


class Obstacles:
    """Cells of a map in which something was seen that it lacks, and when.

    They are forgotten as soon as something is seen behind them, or after `memory` s unseen.
    """

    def __init__(self, ground: Ground, memory: float) -> None:
        self._ground = ground
        self._memory = memory
        self._numbers = np.zeros(0, np.int64)
        self._times = np.zeros(0)

    @property
    def points(self) -> Points:
        """Their centres (n, 2), map frame."""
        return self._ground.geometry.centres_of(self._cells)

    def look(self, map_from_base: ArrayLike, view: View, now: float, margin: float) -> None:
        """Remember what is in view, and forget what is not there any more.

        Args:
            map_from_base: (3,).
            view: what is seen, in base_link; by a laser, or the echoes of a sonar ring.
            now: s.
            margin: distance in m to what the map has from which on something near counts as new.
        """
        self._keep(~self._is_free(map_from_base, view) & (now - self._times <= self._memory))
        distances = np.hypot(view.points[:, 0], view.points[:, 1])
        near = distances <= FARTHEST
        seen = se2.transform_points(map_from_base, view.points[near])
        is_new = self._ground.gaps_at(seen) > margin + HEADING_ERROR * distances[near]
        numbers = self._numbers_of(seen[is_new])
        self._keep(~np.isin(self._numbers, numbers))
        self._numbers = np.concatenate([self._numbers, numbers])
        self._times = np.concatenate([self._times, np.full(len(numbers), now)])

    def forget(self) -> None:
        """Forget everything: it was remembered in the wrong place."""
        self._keep(np.zeros(len(self._numbers), bool))

    @property
    def _cells(self) -> Cells:
        return np.stack(np.divmod(self._numbers, self._ground.geometry.cols), axis=1)

    def _numbers_of(self, points_map: Points) -> NDArray[np.int64]:
        """Return the numbers of the cells that hold points (n, 2), each once."""
        cells = self._ground.geometry.cells_of(points_map)
        return np.unique(cells[:, 0] * self._ground.geometry.cols + cells[:, 1])

    def _keep(self, is_kept: NDArray[np.bool_]) -> None:
        self._numbers, self._times = self._numbers[is_kept], self._times[is_kept]

    def _is_free(self, map_from_base: ArrayLike, view: View) -> NDArray[np.bool_]:
        """Say which remembered cells (n,) one sees through."""
        places = se2.transform_points(se2.inverse(map_from_base), self.points)
        far = np.hypot(places[:, 0], places[:, 1])
        along = places @ view.points.T / np.maximum(far, 1e-6)[:, None]
        across = np.hypot(view.points[:, 0], view.points[:, 1]) ** 2 - along**2
        # Seen by a ray if it leads by at most so far beside the place, on its way to its end.
        share = np.maximum(along, 1e-6) / np.maximum(far, 1e-6)[:, None]
        passes = (along > 0.0) & (np.sqrt(np.maximum(across, 0.0)) / share <= BESIDE)
        hides = passes & (along <= far[:, None] + BEYOND)
        free: NDArray[np.bool_] = np.any(passes, axis=1) & ~np.any(hides, axis=1)
        return free
