"""What a building holds that its map does not: furniture, people, walls that went and came."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.robot.simulator.range_sensors import LaserParams
from pilotage.robot.simulator.walls import Walls

PIECE_SIDES = 0.3, 1.0
"""Least and most side of a piece of furniture [m]."""

PANEL_LENGTH = 1.5
"""Length of a panel that was put up [m]."""

GAP_RADIUS = 0.6
"""Radius of a piece of wall that is gone [m]."""


@dataclass(frozen=True)
class Condition:
    """How far a building differs from its map, and how badly the robot measures.

    `people` walk about; `piece_area`: [m2] of floor to one unmapped piece (infinite: none);
    `outliers`: share of beams that measure anything; `odometry`: factor on the usual odometry
    noise; `walls_gone`: share of the walls that are gone, and as much is put up elsewhere;
    `rough`: share of the cells beside walls that the map's maker did not draw.
    """

    people: int = 0
    piece_area: float = np.inf
    outliers: float = 0.0
    odometry: float = 1.0
    walls_gone: float = 0.0
    rough: float = 0.0
    laser: LaserParams = field(
        default_factory=lambda: LaserParams(share_without_return=0.0, share_too_short=0.0)
    )


CONDITIONS = {
    "clean": Condition(),
    "hard": Condition(people=4, piece_area=40.0, outliers=0.05, odometry=2.0),
    "rough": Condition(people=4, piece_area=40.0, outliers=0.05, odometry=1.5, rough=0.3),
    "extreme": Condition(
        people=10,
        piece_area=13.0,
        outliers=0.10,
        odometry=3.0,
        walls_gone=0.12,
        laser=LaserParams(
            beams=240,
            field_of_view=float(np.deg2rad(240.0)),
            range_max=5.6,
            share_without_return=0.0,
            share_too_short=0.0,
        ),
    ),
}
"""Clean, hard and extreme as in methods E; rough: as hard, and the walls are drawn badly."""


def altered(world: OccupancyMap, condition: Condition, rng: np.random.Generator) -> Walls:
    """Return what really stands in a building.

    What the map does not show as free stops beams and bodies: a real building has walls there,
    even where the map's maker did not draw them.
    """
    blocked = ~world.is_free
    if condition.walls_gone > 0.0:
        _move_walls(blocked, world, condition.walls_gone, rng)
    if condition.rough > 0.0:
        blocked |= _beside(blocked) & (rng.random(blocked.shape) < condition.rough)
    if np.isfinite(condition.piece_area):
        area = float(world.is_free.sum()) * world.geometry.resolution**2
        for _ in range(round(area / condition.piece_area)):
            sides = rng.uniform(*PIECE_SIDES, 2)
            _put_box(blocked, world, sides, rng)
    return Walls(world.geometry, blocked, blocked)


def _move_walls(
    blocked: NDArray[np.bool_], world: OccupancyMap, share: float, rng: np.random.Generator
) -> None:
    """Take a share of the walls away, and put panels of as many cells up elsewhere."""
    walls = np.argwhere(world.is_wall)
    resolution = world.geometry.resolution
    reach = round(GAP_RADIUS / resolution)
    gone, wanted = 0, share * len(walls)
    while gone < wanted:
        row, col = walls[rng.integers(len(walls))]
        window = np.s_[max(row - reach, 0) : row + reach, max(col - reach, 0) : col + reach]
        gone += int(np.count_nonzero(blocked[window] & world.is_wall[window]))
        blocked[window] &= ~world.is_wall[window]
    thickness = resolution
    for _ in range(round(wanted * resolution / PANEL_LENGTH / 2.0)):
        sides = np.array([PANEL_LENGTH, thickness])
        _put_box(blocked, world, sides if rng.random() < 0.5 else sides[::-1], rng)


def _beside(blocked: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the cells that have a blocked one above, below, left or right of them."""
    beside = np.zeros_like(blocked)
    beside[1:] |= blocked[:-1]
    beside[:-1] |= blocked[1:]
    beside[:, 1:] |= blocked[:, :-1]
    beside[:, :-1] |= blocked[:, 1:]
    return beside


def _put_box(
    blocked: NDArray[np.bool_],
    world: OccupancyMap,
    sides: NDArray[np.float64],
    rng: np.random.Generator,
) -> None:
    """Put a box of these sides (2,) [m] somewhere on the free floor."""
    free = np.argwhere(world.is_free)
    row, col = free[rng.integers(len(free))]
    height, width = np.maximum(1, np.rint(sides / world.geometry.resolution)).astype(int)
    blocked[row : row + height, col : col + width] = True
