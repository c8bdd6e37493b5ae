"""Laws of searching the space of a map, and the kernels beside their plain twins."""

import itertools

import networkx as nx
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from naive import topology as naive
from pilotage.core.distance_field import distance_to_walls, nearest_walls
from pilotage.topology.from_map.chords import opposite_walls, widenings
from pilotage.topology.from_map.ways import (
    DETOUR,
    Way,
    _without_detours,
    spread,
    straightened,
    trace,
)

Mask = NDArray[np.bool_]
Ground = tuple[NDArray[np.float32], NDArray[np.int64]]
FEW = settings(max_examples=30, deadline=None)


@st.composite
def spaces(draw: st.DrawFn) -> Mask:
    """Free cells, walled in all round: specks, or halls and alleys of larger blocks."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shape = draw(st.integers(1, 6)), draw(st.integers(1, 6))
    blocks = rng.random(shape) > draw(st.sampled_from([0.0, 0.3, 0.6]))
    size = draw(st.integers(1, 5))
    free = np.kron(blocks, np.ones((size, size), bool)).astype(bool)
    free &= rng.random(free.shape) >= draw(st.sampled_from([0.0, 0.05]))
    return np.pad(free, 1)


@st.composite
def grounds(draw: st.DrawFn) -> Ground:
    """Costs over a space, and up to three places to start from in it."""
    free = draw(spaces())
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    dearest = draw(st.sampled_from([0.0, 3.0, 50.0]))
    costs = np.where(free, 1.0 + dearest * rng.random(free.shape), np.inf)
    sources = rng.permutation(np.argwhere(free))[:3]
    return costs.astype(np.float32), sources.astype(np.int64).reshape(-1, 2)


@given(free=spaces(), without_rim=st.booleans())
@FEW
def test_nearest_wall_is_as_near_as_any(*, free: Mask, without_rim: bool) -> None:
    is_wall = ~free[1:-1, 1:-1] if without_rim else ~free
    nearest = nearest_walls(is_wall)
    for cell in np.ndindex(is_wall.shape):
        row, col = nearest[cell]
        assert (row, col) in naive.walls_as_near(is_wall, (cell[0], cell[1]))


@given(spaces())
@FEW
def test_nearest_wall_lies_as_far_as_the_distance_field_says(free: Mask) -> None:
    away = nearest_walls(~free) - np.moveaxis(np.indices(free.shape), 0, -1)
    distance = distance_to_walls(~free, 1.0)
    np.testing.assert_allclose(np.hypot(away[..., 0], away[..., 1]), distance, rtol=1e-6)


@given(spaces(), st.floats(0.0, 4.0), st.floats(0.0, 8.0), st.sampled_from([110.0, 140.0]))
@FEW
def test_walls_face_each_other_where_the_twin_says(
    free: Mask, least: float, more: float, angle: float
) -> None:
    nearest = nearest_walls(~free)
    limits = np.array([least, least + more, np.cos(np.deg2rad(angle))])
    found = opposite_walls(free, nearest, limits)
    expected = naive.opposite_walls(free, nearest, limits)
    assert [(int(row), int(col)) for row, col in found[:, :2]] == list(expected)
    for cell, one, other in zip(found[:, :2], found[:, 2:4], found[:, 4:], strict=True):
        assert not free[tuple(one)]
        assert not free[tuple(other)]
        angled = naive.cosine(one - cell, other - cell)
        np.testing.assert_allclose(angled, expected[cell[0], cell[1]], atol=1e-9)


@given(spaces(), st.integers(0, 2**32 - 1), st.floats(0.0, 12.0), st.sampled_from([0.0, 0.5]))
@FEW
def test_space_widens_beside_a_chord_as_the_twin_says(
    free: Mask, seed: int, reach: float, askew: float
) -> None:
    rng = np.random.default_rng(seed)
    walls = np.array(list(itertools.pairwise(rng.permutation(np.argwhere(~free))[:9])))
    chords = walls.reshape(-1, 4).astype(np.int64)
    clearance = distance_to_walls(~free, 0.1)
    scale = np.array([reach, 0.1])
    expected = naive.widenings(clearance, chords, scale, askew)
    found = widenings(clearance, chords, scale, askew)
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@given(spaces())
@FEW
def test_a_chord_looked_at_from_its_other_end_has_its_sides_exchanged(free: Mask) -> None:
    walls = np.argwhere(~free)
    # Odd middles are rounded the same way from either end, so both look at the same cells.
    chords = np.hstack([walls[:-1], walls[1:]]).astype(np.int64)
    clearance, scale = distance_to_walls(~free, 0.1), np.array([5.0, 0.1])
    there = widenings(clearance, chords, scale, 0.5)
    back = widenings(clearance, np.roll(chords, 2, axis=1), scale, 0.5)
    np.testing.assert_allclose(there, back[:, ::-1])


@given(grounds())
@FEW
def test_getting_anywhere_costs_what_the_twin_says(ground: Ground) -> None:
    costs, sources = ground
    spent, owner, _ = spread(costs, sources)
    alone = [naive.spent_from(costs, (int(row), int(col))) for row, col in sources]
    least = np.min([np.full(costs.shape, np.inf), *alone], axis=0)
    np.testing.assert_allclose(spent, least, rtol=1e-5)
    assert ((owner >= 0) == np.isfinite(least)).all()
    for cell in np.argwhere(owner >= 0):
        own = alone[owner[tuple(cell)]][tuple(cell)]
        np.testing.assert_allclose(own, least[tuple(cell)], rtol=1e-5)


@given(grounds())
@FEW
def test_a_detour_over_another_place_is_never_cheaper(ground: Ground) -> None:
    costs, sources = ground
    fields = [spread(costs, source[None])[0] for source in sources]
    for (i, one), (_, other) in itertools.permutations(enumerate(fields), 2):
        over = other[tuple(sources[i])] + one
        assert (other <= over * (1.0 + 1e-5)).all()


@given(grounds())
@FEW
def test_there_and_back_cost_the_same(ground: Ground) -> None:
    costs, sources = ground
    fields = [spread(costs, source[None])[0] for source in sources]
    for i, j in itertools.combinations(range(len(sources)), 2):
        there, back = fields[i][tuple(sources[j])], fields[j][tuple(sources[i])]
        np.testing.assert_allclose(there, back, rtol=1e-5)


@given(grounds())
@FEW
def test_the_way_back_leads_over_free_cells_to_the_owner_and_costs_what_was_spent(
    ground: Ground,
) -> None:
    costs, sources = ground
    spent, owner, came_from = spread(costs, sources)
    for flat in np.flatnonzero(owner.ravel() >= 0):
        way = trace(came_from.ravel(), int(flat))
        assert way.tolist() == naive.trace(came_from.ravel(), int(flat))
        cells = np.stack(np.divmod(way, costs.shape[1]), axis=1)
        assert (cells[-1] == sources[owner.ravel()[flat]]).all()
        there = costs[tuple(cells.T)].astype(float)
        assert np.isfinite(there).all()
        steps = np.hypot(*np.diff(cells, axis=0).T)
        assert (steps < 1.5).all()
        total = float(np.sum(steps * (there[1:] + there[:-1]) / 2.0))
        np.testing.assert_allclose(total, spent.ravel()[flat], rtol=1e-5, atol=1e-6)


@given(grounds())
@FEW
def test_a_straightened_way_keeps_its_ends_and_crosses_no_blocked_cell(ground: Ground) -> None:
    costs, sources = ground
    _, owner, came_from = spread(costs, sources)
    for flat in np.flatnonzero(owner.ravel() >= 0)[::7]:
        way = trace(came_from.ravel(), int(flat))
        cells = np.stack(np.divmod(way, costs.shape[1]), axis=1)
        straight = straightened(cells, costs)
        assert straight[[0, -1]].tolist() == cells[[0, -1]].tolist()
        for one, other in itertools.pairwise(straight):
            if np.abs(other - one).max() <= 1:
                continue  # a step of the way as it was: it may pass a corner, but no cell
            shares = np.linspace(0.0, 1.0, 2 * int(np.abs(other - one).max()) + 1)
            at = np.rint(one + shares[:, None] * (other - one)).astype(int)
            assert np.isfinite(costs[tuple(at.T)]).all()


@given(st.lists(st.tuples(st.integers(0, 8), st.integers(0, 8), st.floats(0.5, 9.0)), max_size=40))
@FEW
def test_what_is_dropped_leaves_no_detour_above_the_factor(
    links: list[tuple[int, int, float]],
) -> None:
    nowhere = np.zeros((2, 2))
    ways = [Way(start, end, nowhere, length) for start, end, length in links if start != end]
    kept = _without_detours(ways)
    assert all(any(way is one for one in ways) for way in kept)
    graph: nx.Graph[int] = nx.Graph()
    for way in sorted(kept, key=lambda way: -way.length):  # the shortest of several stays
        graph.add_edge(way.start, way.end, length=way.length)
    for way in ways:
        around = nx.dijkstra_path_length(graph, way.start, way.end, "length")
        assert around <= DETOUR * way.length * (1.0 + 1e-9)
