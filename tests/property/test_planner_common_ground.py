"""Laws of the ground on which a robot may drive wherever it is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from naive import active as naive
from naive.path_search import neighbours
from pilotage.core import se2
from pilotage.core.grid import FREE, OCCUPIED, UNKNOWN, GridGeometry, OccupancyMap
from pilotage.core.laser_view import View
from pilotage.planner.common_ground import RESOLUTION, Clearance, GroundParams, common_ground
from pilotage.planner.situation import Hypotheses
from planner_world import NOTHING

PARAMS = GroundParams(reach=1.2)
NEEDED = PARAMS.radius + PARAMS.gap
seeds = st.integers(0, 2**32 - 1)


@st.composite
def floors(draw: st.DrawFn) -> OccupancyMap:
    """A walled floor of 2 to 3 m with boxes in it, lying anyhow."""
    rng = np.random.default_rng(draw(seeds))
    cells = np.full(rng.integers(14, 20, 2), FREE, np.int8)
    for value in (UNKNOWN, OCCUPIED, OCCUPIED)[: draw(st.integers(0, 3))]:
        row, col = rng.integers(0, cells.shape)
        cells[row : row + rng.integers(1, 3), col : col + rng.integers(1, 3)] = value
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    x, y, theta = (float(value) for value in rng.uniform(-3.0, 3.0, 3))
    geometry = GridGeometry(len(cells), len(cells[0]), 0.15, (x, y, theta))
    return OccupancyMap(geometry, cells)


def somewhere(world: OccupancyMap, seed: int, most: int = 4) -> Hypotheses:
    """Return a few places on a floor, at any heading, heaviest first."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, most + 1))
    wide, tall = world.geometry.size_m
    in_grid = rng.uniform((0.3, 0.3), (wide - 0.3, tall - 0.3), (count, 2))
    points = se2.transform_points(world.geometry.origin, in_grid)
    weights = np.sort(rng.dirichlet(np.full(count, 0.5)))[::-1] + 1e-6
    poses = np.column_stack([points, rng.uniform(-np.pi, np.pi, count)])
    return Hypotheses(poses, weights / weights.sum())


def views(seed: int) -> View:
    """Return a view of a few points on some sides."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(0, 5))
    points = rng.uniform(-1.5, 1.5, (count, 2))
    return View(points, np.linspace(-2.0, 2.0, int(rng.integers(1, 9))))


def ground(
    world: OccupancyMap, places: Hypotheses, view: View = NOTHING, params: GroundParams = PARAMS
) -> tuple[GridGeometry, NDArray[np.bool_]]:
    return common_ground(Clearance(world), places, view, params)


@given(floors(), seeds)
def test_the_ground_is_that_of_the_twin(world: OccupancyMap, seed: int) -> None:
    places, view = somewhere(world, seed), views(seed)
    geometry, passable = ground(world, places, view)
    expected = naive.common_ground(world, places, view, geometry, PARAMS)
    # A cell whose centre lies on the boundary of two of the map's may fall into either.
    assert np.mean(passable != expected) < 0.01


@given(floors(), seeds)
def test_every_passable_cell_is_connected_with_the_middle(world: OccupancyMap, seed: int) -> None:
    _, passable = ground(world, somewhere(world, seed), views(seed))
    middle = passable.shape[0] // 2, passable.shape[1] // 2
    reached, waiting = {middle}, [middle]
    while waiting:
        new = [cell for cell in neighbours(passable, waiting.pop()) if cell not in reached]
        reached.update(new)
        waiting.extend(new)
    assert passable[middle]
    assert reached == {(int(row), int(col)) for row, col in np.argwhere(passable)}


@given(floors(), seeds)
def test_beyond_what_is_seen_it_is_clear_at_every_place_that_weighs(
    world: OccupancyMap, seed: int
) -> None:
    places = somewhere(world, seed)
    geometry, passable = ground(world, places)
    points = geometry.centres_of(np.argwhere(passable))
    points = points[np.hypot(*points.T) > NEEDED + RESOLUTION]
    metres, objecting = naive.clearance(world), np.zeros(len(points))
    for pose, weight in zip(places.poses, places.weights, strict=True):
        cells = world.geometry.cells_of(se2.transform_points(pose, points))
        assert world.geometry.contains(cells).all() or weight <= PARAMS.bold
        inside = np.clip(cells, 0, np.array(world.geometry.shape) - 1)
        is_clear = metres[tuple(inside.T)] >= NEEDED - 1e-6
        assert is_clear.all() or weight <= PARAMS.bold
        objecting += weight * ~is_clear
    assert (objecting <= PARAMS.doubt + 1e-9).all()


@given(floors(), seeds)
def test_another_place_to_be_at_never_adds_ground(world: OccupancyMap, seed: int) -> None:
    """With nobody overruled: else the weight of a place that objects may fall below notice."""
    strict = GroundParams(reach=PARAMS.reach, doubt=0.0, bold=0.0)
    places, view = somewhere(world, seed), views(seed)
    fewer = Hypotheses(places.poses[:-1], places.weights[:-1])
    _, more = ground(world, fewer, view, strict)
    _, less = ground(world, places, view, strict)
    assert not (less & ~more).any()


@given(floors(), seeds)
def test_what_is_seen_is_kept_away_from(world: OccupancyMap, seed: int) -> None:
    view = views(seed)
    geometry, passable = ground(world, somewhere(world, seed), view)
    centres = geometry.centres_of(np.argwhere(passable))
    away = centres[np.hypot(*centres.T) > NEEDED + RESOLUTION]
    for point in view.points:
        if geometry.contains(geometry.cells_of(point[None]))[0]:
            gaps = np.hypot(*(away - point).T)
            # The point lies somewhere in its cell.
            assert gaps.min(initial=np.inf) >= NEEDED - RESOLUTION


@given(floors(), seeds)
def test_what_is_seen_free_is_passable_whatever_the_map_says(
    world: OccupancyMap, seed: int
) -> None:
    """A wall seen all round at 1 m leaves the ground within free."""
    angles = np.linspace(-np.pi, np.pi, 200)
    view = View(np.column_stack([np.cos(angles), np.sin(angles)]), angles)
    geometry, passable = ground(world, somewhere(world, seed), view)
    centres = geometry.centres_of(np.argwhere(np.ones(geometry.shape, bool)))
    within = np.hypot(*centres.T) < 1.0 - 1.5 * NEEDED - RESOLUTION
    cells = geometry.cells_of(centres[within])
    assert passable[tuple(cells.T)].all()
    far = geometry.cells_of(centres[np.hypot(*centres.T) > 1.0 - NEEDED + RESOLUTION])
    assert not passable[tuple(far.T)].any()


@given(floors(), seeds, st.floats(-3.0, 3.0))
def test_the_ground_moves_with_map_and_places(world: OccupancyMap, seed: int, turn: float) -> None:
    places, view = somewhere(world, seed), views(seed)
    frame = np.array([1.5, -0.3, turn])
    origin = se2.compose(frame, world.geometry.origin)
    x, y, theta = (float(value) for value in origin)
    moved = OccupancyMap(GridGeometry(*world.geometry.shape, 0.15, (x, y, theta)), world.cells)
    there = Hypotheses(se2.compose(frame, places.poses), places.weights)
    _, one = ground(world, places, view)
    _, other = ground(moved, there, view)
    assert np.mean(one != other) < 0.01


def test_a_robot_off_the_map_may_go_only_where_it_sees() -> None:
    cells = np.full((10, 10), FREE, np.int8)
    world = OccupancyMap(GridGeometry(10, 10, 0.15), cells)
    far = Hypotheses(np.array([[50.0, 50.0, 0.0]]), np.ones(1))
    geometry, passable = ground(world, far)
    centres = geometry.centres_of(np.argwhere(passable))
    assert np.hypot(*centres.T).max() < NEEDED
    assert passable.sum() == pytest.approx(np.pi * (NEEDED / RESOLUTION) ** 2, abs=8)
