"""Where it may be worth going: the candidate targets of Liu et al. 2008, eq. 4; pure.

    Q = M u S u R u {P0}

M: where the window potential has a local maximum (over place and heading), S: where the
environment potential has one, R: places at random, P0: where the robot seems to be. Maxima are
sought on the discretised field, as in the paper.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.planner.potential_field import Sources, environment_potential, window_potential

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TargetParams:
    """What is offered.

    `half_view`: half the sensor's field of view [rad]; `headings`: in which the window potential
    is computed; `clear`: nobody is sent nearer to a landmark than this, for it may be solid, and
    on it there is no bearing to it [m]; `apart`: maxima nearer to a higher one than this are left
    out [m]; `most_window`, `most_environment`: so many maxima are kept, the highest.
    """

    half_view: float
    headings: int = 24
    clear: float = 0.3
    apart: float = 0.3
    most_window: int = 8
    most_environment: int = 4


@dataclass(frozen=True)
class Field:
    """The potentials of landmarks over the cells where a robot may be.

    `environment` (rows, cols) and `window` (rows, cols, headings), zero where no robot may be;
    `is_clear` (rows, cols): where one may be sent; `window_maxima` (k, 3): x, y [m] and heading,
    `environment_maxima` (k, 2), of what is clear, both highest first and in the map frame.
    """

    geometry: GridGeometry
    is_clear: NDArray[np.bool_]
    environment: Array
    window: Array
    window_maxima: Array
    environment_maxima: Array

    def around(self, here: Array, count: int, rng: np.random.Generator) -> Array:
        """Return the candidates Q (n, 2): M, S, `count` places of R, and P0 = `here`, last."""
        return np.concatenate(
            [self.window_maxima[:, :2], self.environment_maxima, self._random(count, rng), [here]]
        )

    def _random(self, count: int, rng: np.random.Generator) -> Array:
        cells = np.argwhere(self.is_clear)
        return self.geometry.centres_of(cells[rng.integers(len(cells), size=count)])


def survey(sources: Sources, world: OccupancyMap, params: TargetParams) -> Field:
    """Return the potentials over a map's free cells, and their maxima."""
    geometry, is_free = world.geometry, world.is_free
    is_clear = is_free & ~_near_landmarks(sources, geometry, params.clear)
    places = geometry.centres_of(np.argwhere(is_free))
    headings = np.arange(params.headings) * (2.0 * np.pi / params.headings) - np.pi
    environment = np.zeros(geometry.shape)
    environment[is_free] = environment_potential(sources, places)
    window = np.zeros((*geometry.shape, params.headings))
    window[is_free] = window_potential(sources, places, headings, params.half_view)
    at_window = local_maxima(window * is_clear[:, :, None], is_cyclic=True)
    m = np.column_stack([geometry.centres_of(at_window[:, :2]), headings[at_window[:, 2]]])
    at_whole = local_maxima((environment * is_clear)[:, :, None], is_cyclic=False)
    s = geometry.centres_of(at_whole[:, :2])
    return Field(
        geometry,
        is_clear,
        environment,
        window,
        _spread(m, params.apart, params.most_window),
        _spread(s, params.apart, params.most_environment),
    )


def _near_landmarks(sources: Sources, geometry: GridGeometry, clear: float) -> NDArray[np.bool_]:
    """Return the cells (rows, cols) whose centre is nearer to a landmark than `clear`."""
    is_near = np.zeros(geometry.shape, bool)
    centres = geometry.centres_of(np.argwhere(~is_near))
    for landmark in sources.positions:
        is_near |= (np.hypot(*(centres - landmark).T) < clear).reshape(geometry.shape)
    return is_near


def local_maxima(values: Array, *, is_cyclic: bool) -> NDArray[np.int64]:
    """Return the cells (k, 3) of values (rows, cols, layers) above all neighbours, highest first.

    Of a plateau one cell counts, the first. Zero is no maximum. `is_cyclic`: the last layer is
    next to the first.
    """
    layers = values.shape[2]
    padded = np.pad(values, ((1, 1), (1, 1), (0, 0)), constant_values=-np.inf)
    is_top = values > 0.0
    reach = (-1, 0, 1) if is_cyclic and layers > 1 else (0,)
    for row, col, layer in product((-1, 0, 1), (-1, 0, 1), reach):
        if (row, col, layer) == (0, 0, 0):
            continue
        turned = np.roll(padded, -layer, axis=2)
        rows, cols = values.shape[:2]
        beside = turned[1 + row : 1 + row + rows, 1 + col : 1 + col + cols]
        is_before = (row, col, layer) < (0, 0, 0)
        is_top &= values > beside if is_before else values >= beside
    tops = np.argwhere(is_top)
    return tops[np.argsort(-values[is_top], kind="stable")]


def _spread(places: Array, apart: float, most: int) -> Array:
    """Return the first of places (k, 2 or 3), leaving out what is close to one before it."""
    kept: list[Array] = []
    for place in places:
        if all(np.hypot(*(place[:2] - other[:2])) >= apart for other in kept):
            kept.append(place)
        if len(kept) == most:
            break
    return np.array(kept).reshape(-1, places.shape[1])
