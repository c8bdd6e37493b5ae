import math

import pytest

from drawing import draw
from pilotage.core.grid import OccupancyMap
from pilotage.core.grid_resampling import resample

FINE = draw(
    """
    #.....
    ......
    ....??
    ??..??
    """,
    resolution=0.05,
    origin=(1.0, 2.0, 0.5),
)


def picture(world: OccupancyMap) -> list[str]:
    marks = {100: "#", 0: ".", -1: "?"}
    return ["".join(marks[cell] for cell in row) for row in reversed(world.cells.tolist())]


def test_a_single_wall_cell_makes_the_coarse_cell_a_wall() -> None:
    assert picture(resample(FINE, 0.1)) == ["#..", "..?"]


def test_origin_stays_and_the_resolution_is_the_one_asked_for() -> None:
    coarse = resample(FINE, 0.1)
    assert coarse.geometry.origin == FINE.geometry.origin
    assert coarse.geometry.resolution == 0.1


def test_cells_that_do_not_fill_a_coarse_cell_still_count() -> None:
    assert resample(draw("...#", resolution=0.05), 0.15).cells.tolist() == [[0, 100]]


def test_wall_in_a_cell_that_two_coarse_cells_share_is_in_both() -> None:
    assert picture(resample(draw("..#..."), 2.5)) == ["##."]


def test_same_resolution_changes_nothing_but_probabilities() -> None:
    assert (resample(FINE, 0.05).cells == FINE.cells).all()


def test_a_third_of_a_metre_in_floating_point_is_no_extra_cell() -> None:
    assert resample(draw("." * 9, resolution=0.1), 0.3).geometry.cols == 3


def test_finer_cells_repeat_the_map() -> None:
    assert picture(resample(draw("#.", resolution=1.0), 0.5)) == ["##..", "##.."]


@pytest.mark.parametrize("resolution", [0.0, -1.0, math.nan])
def test_a_resolution_that_is_no_length_is_refused(resolution: float) -> None:
    with pytest.raises(ValueError, match="resolution must be positive"):
        resample(FINE, resolution)
