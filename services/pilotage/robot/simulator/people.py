"""People as discs who walk about, turn before walls and let the robot pass; pure."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.robot.simulator.walls import Walls

RADIUS = 0.22
SPEED = 0.8
"""m/s: an unhurried walk indoors."""
PERSONAL_SPACE = 0.7
"""m between centres at which a person waits for the robot to pass."""


class People:
    """`count` people at free places of a world."""

    def __init__(self, walls: Walls, count: int, rng: np.random.Generator) -> None:
        self._walls = walls
        places = walls.places(RADIUS + 0.1) if count else np.empty((0, 2))
        chosen = places[rng.integers(len(places), size=count)] if count else places
        self._poses = np.column_stack([chosen, rng.uniform(-np.pi, np.pi, count)])

    @property
    def discs(self) -> NDArray[np.float64]:
        """Their bodies (n, 3): x, y, radius in m, map frame."""
        bodies = self._poses.copy()
        bodies[:, 2] = RADIUS
        return bodies

    def walk(self, robot: NDArray[np.float64], dt: float, rng: np.random.Generator) -> None:
        """Go on for `dt` s; `robot` is its pose (3,)."""
        for pose in self._poses:
            ahead = pose[:2] + SPEED * dt * np.array([np.cos(pose[2]), np.sin(pose[2])])
            comes_closer = np.hypot(*(ahead - robot[:2])) < np.hypot(*(pose[:2] - robot[:2]))
            if comes_closer and np.hypot(*(ahead - robot[:2])) < PERSONAL_SPACE:
                pose[2] = wrap(pose[2] + rng.normal(0.0, 0.5))
            elif self._walls.overlaps(ahead[0], ahead[1], RADIUS + 0.05):
                pose[2] = wrap(pose[2] + rng.uniform(-1.5, 1.5))
            else:
                pose[:2] = ahead
                pose[2] = wrap(pose[2] + rng.normal(0.0, 0.3 * np.sqrt(dt)))


def ranges_to_discs(
    origin: NDArray[np.float64], bearings: NDArray[np.float64], discs: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how far beams (n,) from a pose (3,) travel to the nearest disc, infinite if none.

    A beam that starts inside a disc does not see that disc.
    """
    directions = origin[2] + bearings
    offset = discs[:, :2] - origin[:2]
    along = np.outer(np.cos(directions), offset[:, 0]) + np.outer(np.sin(directions), offset[:, 1])
    squared_miss = (offset**2).sum(axis=1) - along**2
    half_chord_squared = discs[:, 2] ** 2 - squared_miss
    entry = along - np.sqrt(np.maximum(half_chord_squared, 0.0))
    ranges = np.where((half_chord_squared >= 0.0) & (entry >= 0.0), entry, np.inf)
    nearest: NDArray[np.float64] = ranges.min(axis=1, initial=np.inf)
    return nearest
