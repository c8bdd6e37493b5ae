import math

import numpy as np
import pytest

from drawing import draw
from pilotage.core.grid import GridGeometry
from pilotage.core.raycast import cast_rays, expected_ranges

FLOOR = draw(
    """
    ##############
    #......#.....#
    #......#..#..#
    #.??......#..#
    #......#..##.#
    #......#.....#
    #####..##..###
    #............#
    ##############
    """,
    resolution=0.5,
    origin=(1.0, -2.0, 0.0),
)
HEADINGS = 7
"""An odd number: no direction but the first runs along boundaries or through corners."""


def cast_each(geometry: GridGeometry, range_max: float) -> np.ndarray:
    centres = geometry.centres_of(np.argwhere(np.ones(geometry.shape, bool)))
    rows = []
    for k in range(HEADINGS):
        heading = np.full((len(centres), 1), k * 2.0 * math.pi / HEADINGS)
        ranges = cast_rays(FLOOR, np.hstack([centres, heading]), range_max)
        rows.append(np.minimum(ranges, range_max).reshape(geometry.shape))
    return np.array(rows)


GEOMETRIES = {
    "the map's own": FLOOR.geometry,
    "twice as coarse, shifted": GridGeometry(4, 6, 1.0, (1.15, -1.8, 0.0)),
    "three times as coarse": GridGeometry(3, 5, 1.5, (1.0, -2.0, 0.0)),
    "larger than the map": GridGeometry(14, 20, 0.5, (-0.5, -3.5, 0.0)),
    "not a whole number of cells": GridGeometry(5, 8, 0.8, (1.0, -2.0, 0.0)),
    "finer than the map": GridGeometry(9, 9, 0.2, (2.0, -1.0, 0.0)),
    "turned": GridGeometry(4, 4, 1.0, (2.0, -1.5, 0.3)),
}


@pytest.mark.parametrize("geometry", GEOMETRIES.values(), ids=GEOMETRIES.keys())
@pytest.mark.parametrize("range_max", [2.2, 50.0])
def test_table_holds_what_single_rays_measure(geometry: GridGeometry, range_max: float) -> None:
    table = expected_ranges(FLOOR, geometry, HEADINGS, range_max)
    assert table.shape == (HEADINGS, *geometry.shape)
    assert table.dtype == np.float32
    assert table == pytest.approx(cast_each(geometry, range_max), abs=1e-5)


def test_headings_count_from_the_axes_of_the_map_frame() -> None:
    turned = draw("...#", origin=(0.0, 0.0, math.pi / 2.0))
    table = expected_ranges(turned, turned.geometry, 4, 9.0)
    assert table[:, 0, 1] == pytest.approx([9.0, 1.5, 9.0, 9.0], abs=1e-6)


def test_a_wall_cell_expects_no_range_at_all() -> None:
    table = expected_ranges(FLOOR, FLOOR.geometry, HEADINGS, 5.0)
    assert (table[:, FLOOR.is_wall] == 0.0).all()


def test_table_of_an_empty_map_is_the_maximum_range_everywhere() -> None:
    world = draw("...")
    assert (expected_ranges(world, world.geometry, 8, 3.0) == 3.0).all()
