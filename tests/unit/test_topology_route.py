"""Routes through a topological map."""

import time

import numpy as np
import pytest

from naive.routes import route_cost
from pilotage.topology.routes.route import Graph, NoRouteError, RouteCosts, Router, way_along
from pilotage.topology.topological_map import Edge, TopologicalMap
from topology_maps import CORRIDOR, graph

SHORT_AND_DOORED = graph(
    [(0.0, 0.0), (2.0, 0.0, "door"), (4.0, 0.0), (2.0, 2.0)],
    [(0, 1, "door"), (1, 2, "door"), (0, 3), (3, 2)],
)
"""Straight on through a door, or round it."""


def test_the_way_goes_from_node_to_node_by_the_edges_between() -> None:
    route = Router(CORRIDOR).route(0, 3)
    assert route.nodes == (0, 1, 2, 3)
    assert route.edges == (5, 6, 7)


def test_a_way_costs_its_metres_and_its_doors() -> None:
    assert Router(CORRIDOR).route(0, 4).cost == pytest.approx(8.0)
    assert Router(CORRIDOR, RouteCosts(door=3.0)).route(0, 3).cost == pytest.approx(9.0 + 3.0)


def test_who_ends_in_a_door_has_paid_half_of_it() -> None:
    assert Router(CORRIDOR, RouteCosts(door=3.0)).route(1, 2).cost == pytest.approx(2.0 + 1.5)


def test_an_edge_through_a_door_without_a_node_pays_for_it() -> None:
    world = graph([(0.0, 0.0), (2.0, 0.0)], [(0, 1, "door")])
    assert Router(world, RouteCosts(door=3.0)).route(0, 1).cost == pytest.approx(5.0)


def test_a_door_is_driven_round_if_that_is_cheaper() -> None:
    assert Router(SHORT_AND_DOORED, RouteCosts(door=0.5)).route(0, 2).nodes == (0, 1, 2)
    assert Router(SHORT_AND_DOORED, RouteCosts(door=5.0)).route(0, 2).nodes == (0, 3, 2)


def test_of_two_edges_between_the_same_nodes_the_shorter_is_taken() -> None:
    world = graph([(0.0, 0.0), (2.0, 0.0)], [(0, 1), (0, 1)])
    long = Edge(2, 0, 1, "corridor", 7.0, world.edges[0].way)
    world = TopologicalMap("0123", world.nodes, (long, world.edges[1]))
    route = Router(world).route(1, 0)
    assert (route.edges, route.cost) == ((3,), 2.0)


def test_who_stays_where_he_is_pays_nothing() -> None:
    route = Router(CORRIDOR).route(1, 1)
    assert (route.nodes, route.edges, route.cost) == ((1,), (), 0.0)
    np.testing.assert_array_equal(way_along(CORRIDOR, route), [[4.0, 0.0]])


def test_where_no_way_leads_that_is_said() -> None:
    world = graph([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)], [(0, 1)])
    with pytest.raises(NoRouteError, match="no way leads from node 0 to node 2"):
        Router(world).route(0, 2)
    with pytest.raises(NoRouteError, match="there is no node 7"):
        Router(world).route(0, 7)


def test_the_nearest_node_is_told_with_its_distance() -> None:
    nearest, metres = Router(CORRIDOR).nearest((4.3, 2.4))
    assert nearest == 2
    assert metres == pytest.approx(0.5)


def test_a_map_without_nodes_has_no_nearest_one() -> None:
    router = Router(graph([], []))
    with pytest.raises(NoRouteError, match="no nodes"):
        router.nearest((0.0, 0.0))
    with pytest.raises(NoRouteError, match="there is no node 0"):
        router.route(0, 0)


def test_a_map_without_edges_leads_nowhere() -> None:
    with pytest.raises(NoRouteError, match="no way leads"):
        Router(graph([(0.0, 0.0), (1.0, 0.0)], [])).route(0, 1)


def test_the_way_is_the_polyline_of_its_edges_each_in_the_direction_driven() -> None:
    bent = np.array([[4.0, 0.0], [2.0, 1.0], [0.0, 0.0]])
    world = graph([(0.0, 0.0), (4.0, 0.0), (6.0, 0.0)], [(1, 2)])
    world = TopologicalMap("0123", world.nodes, (Edge(9, 1, 0, "room", 4.5, bent), *world.edges))
    way = way_along(world, Router(world).route(0, 2))
    np.testing.assert_array_equal(way, [[0.0, 0.0], [2.0, 1.0], [4.0, 0.0], [6.0, 0.0]])


def test_what_all_ways_from_a_node_cost_can_be_had_at_once() -> None:
    ways = Graph(4, [(0, 1, 2.0), (1, 2, 1.0), (0, 2, 5.0)], landmarks=0)
    assert ways.costs_from(2).tolist() == [3.0, 1.0, 0.0, np.inf]


def drawn(rng: np.random.Generator, side: int, share: float) -> TopologicalMap:
    """A town of crooked streets, some of them missing."""
    offsets = rng.uniform(-0.4, 0.4, (side * side, 2))
    places = [
        (float(i % side + dx), float(i // side + dy), "door" if rng.random() < 0.1 else "node")
        for i, (dx, dy) in enumerate(offsets)
    ]
    ways = [(i, i + 1) for i in range(side * side - 1) if (i + 1) % side and rng.random() < share]
    ways += [(i, i + side) for i in range(side * (side - 1)) if rng.random() < share]
    return graph(places, ways)  # type: ignore[arg-type]  # mypy widens the kinds to str


@pytest.mark.parametrize("seed", range(6))
def test_routes_cost_what_networkx_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world, costs = drawn(rng, 9, rng.uniform(0.4, 1.0)), RouteCosts(rng.uniform(0.0, 5.0))
    router = Router(world, costs)
    for start, end in rng.integers(0, 81, (25, 2)):
        expected = route_cost(world, int(start), int(end), costs)
        if expected is None:
            with pytest.raises(NoRouteError):
                router.route(int(start), int(end))
        else:
            route = router.route(int(start), int(end))
            assert route.cost == pytest.approx(expected)
            steps = zip(route.nodes, route.edges, route.nodes[1:], strict=False)
            ends = {edge.id: {edge.start, edge.end} for edge in world.edges}
            assert all(ends[edge] == {node, after} for node, edge, after in steps)


def test_a_search_among_ten_thousand_nodes_takes_a_millisecond_at_most() -> None:
    rng = np.random.default_rng(1)
    router = Router(drawn(rng, 100, 0.9))
    router.route(5050, 5050)
    taken = []
    for start, end in rng.integers(0, 10_000, (60, 2)):
        began = time.thread_time()
        try:
            router.route(int(start), int(end))
        except NoRouteError:
            continue
        taken.append(time.thread_time() - began)
    assert np.percentile(taken, 90) <= 1e-3
