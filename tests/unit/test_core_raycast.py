import math

import numpy as np
import pytest

from drawing import draw
from pilotage.core.raycast import cast_ray_in_grid, cast_rays, cast_scan

ROOM = draw("""
    #######
    #.....#
    #..?..#
    #.....#
    #######
""")
HALF_TURN = math.pi


def test_beam_stops_at_the_first_wall() -> None:
    world = draw("""
        .....
        ..#.#
        .....
    """)
    assert cast_rays(world, [[0.5, 1.5, 0.0]], 10.0) == pytest.approx([1.5])


def test_ranges_are_in_metres_whatever_the_cell_size() -> None:
    world = draw("..#", resolution=0.25)
    assert cast_rays(world, [[0.1, 0.1, 0.0]], 10.0) == pytest.approx([0.4])


def test_room_is_measured_in_the_four_directions() -> None:
    ranges = cast_scan(ROOM, [2.5, 1.75, 0.0], np.array([0, 0.5, 1, -0.5]) * math.pi, 10.0)
    assert ranges == pytest.approx([3.5, 2.25, 1.5, 0.75])


def test_unknown_cells_are_transparent() -> None:
    assert cast_rays(ROOM, [[1.5, 2.5, 0.0]], 10.0) == pytest.approx([4.5])


def test_beam_that_leaves_the_map_measures_infinity() -> None:
    assert np.isinf(cast_rays(draw("#..."), [[1.5, 0.5, 0.0]], 10.0)).all()


def test_wall_beyond_the_range_limit_is_not_seen() -> None:
    world = draw("....#")
    pose = [[0.5, 0.5, 0.0]]
    assert np.isinf(cast_rays(world, pose, 3.4)).all()
    assert cast_rays(world, pose, 3.5) == pytest.approx([3.5])


def test_beam_that_starts_in_a_wall_measures_zero() -> None:
    assert cast_rays(ROOM, [[0.5, 0.5, 1.0]], 10.0) == pytest.approx([0.0])


def test_beam_that_starts_outside_the_map_measures_infinity() -> None:
    poses = [[-0.5, 0.5, 0.0], [99.0, 0.5, HALF_TURN], [0.5, -1e300, 0.0]]
    assert np.isinf(cast_rays(draw("#"), poses, 100.0)).all()


def test_oblique_beam_ends_on_the_cell_boundary() -> None:
    angle = math.atan2(1.5, 2.0)
    world = draw("""
        .....
        .....
        ..#..
        .....
    """)
    assert cast_rays(world, [[0.5, 0.0, angle]], 10.0) == pytest.approx([1.5 / math.cos(angle)])


def test_beam_does_not_slip_between_two_walls_that_touch_at_a_corner() -> None:
    world = draw("""
        #.
        .#
    """)
    pose = [[0.5, 0.5, math.pi / 4.0]]
    assert cast_rays(world, pose, 10.0) == pytest.approx([math.sqrt(0.5)])


def test_beam_from_a_boundary_looks_into_the_cell_it_points_to() -> None:
    world = draw("#.#")
    assert cast_rays(world, [[1.0, 0.5, 0.0]], 10.0) == pytest.approx([1.0])
    assert cast_rays(world, [[1.0, 0.5, HALF_TURN]], 10.0) == pytest.approx([0.0])


def test_map_with_a_turned_origin_is_seen_turned() -> None:
    turned = draw("...#", resolution=0.5, origin=(3.0, -2.0, math.pi / 2.0))
    # The drawing's +x points to +y of the map frame, its +y to -x.
    assert cast_rays(turned, [[2.75, -1.75, math.pi / 2.0]], 10.0) == pytest.approx([1.25])


def test_scan_turns_with_the_robot() -> None:
    bearings = np.linspace(-1.5, 1.5, 7)
    turned = cast_scan(ROOM, [2.3, 2.2, 0.4], bearings, 10.0)
    assert turned == pytest.approx(cast_scan(ROOM, [2.3, 2.2, 0.0], bearings + 0.4, 10.0))


def test_no_poses_give_no_ranges() -> None:
    assert cast_rays(ROOM, np.empty((0, 3)), 10.0).shape == (0,)
    assert cast_scan(ROOM, [2.5, 2.5, 0.0], [], 10.0).shape == (0,)


def test_kernel_measures_in_cells() -> None:
    assert cast_ray_in_grid(draw("..#").is_wall, 0.25, 0.5, 0.0, 10.0) == pytest.approx(1.75)
