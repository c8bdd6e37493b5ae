"""Routes through several floors."""

import pytest

from pilotage.topology.routes.floor_routes import FloorRouter
from pilotage.topology.routes.floors import Floor, Link
from pilotage.topology.routes.route import NoRouteError, RouteCosts
from topology_maps import CORRIDOR, graph

TOP = graph([(0.0, 0.0), (6.0, 0.0)], [(0, 1)], "4567")
LIFT = Link(4, "top", 1, 10.0)
HOUSE = {"ground": Floor(CORRIDOR, "ground", links=(LIFT,)), "top": Floor(TOP, "top")}


def test_a_way_takes_the_lift_to_another_floor() -> None:
    found = FloorRouter(HOUSE).route(("ground", 0), ("top", 0))
    below, above = found.legs
    assert (below.floor, below.route.nodes, below.route.edges) == ("ground", (0, 1, 4), (5, 8))
    assert (above.floor, above.route.nodes, above.route.edges) == ("top", (1, 0), (2,))
    assert found.cost == pytest.approx(8.0 + 10.0 + 6.0)
    assert below.route.cost + above.route.cost == pytest.approx(14.0)


def test_a_lift_goes_down_too() -> None:
    found = FloorRouter(HOUSE).route(("top", 0), ("ground", 0))
    assert [leg.floor for leg in found.legs] == ["top", "ground"]
    assert found.cost == pytest.approx(24.0)


def test_a_way_on_one_floor_is_one_leg() -> None:
    found = FloorRouter(HOUSE, RouteCosts(door=1.0)).route(("ground", 0), ("ground", 3))
    assert [leg.route.nodes for leg in found.legs] == [(0, 1, 2, 3)]
    assert found.cost == pytest.approx(10.0)


def test_two_lifts_may_be_nearer_than_the_floor_itself() -> None:
    long = graph([(0.0, 0.0), (100.0, 0.0)], [(0, 1)])
    links = (Link(0, "top", 0, 5.0), Link(1, "top", 1, 5.0))
    found = FloorRouter({"long": Floor(long, links=links), "top": Floor(TOP)}).route(
        ("long", 0), ("long", 1)
    )
    assert [leg.floor for leg in found.legs] == ["long", "top", "long"]
    assert [leg.route.nodes for leg in found.legs] == [(0,), (0, 1), (1,)]


def test_links_to_what_is_not_there_lead_nowhere() -> None:
    links = (Link(4, "cellar", 1, 1.0), Link(4, "top", 99, 1.0))
    router = FloorRouter({"ground": Floor(CORRIDOR, links=links), "top": Floor(TOP)})
    with pytest.raises(NoRouteError, match="no way leads from node 0 of ground to node 1 of top"):
        router.route(("ground", 0), ("top", 1))


def test_a_floor_or_node_that_is_not_there_is_named() -> None:
    with pytest.raises(NoRouteError, match="there is no node 1 of cellar"):
        FloorRouter(HOUSE).route(("cellar", 1), ("top", 1))
    with pytest.raises(NoRouteError, match=r"there is no node 9$"):
        FloorRouter({"": Floor(TOP)}).route(("", 9), ("", 1))


def test_a_link_replaces_the_one_between_the_same_nodes() -> None:
    floor = HOUSE["ground"].linked(Link(4, "top", 1, 3.0)).linked(Link(0, "top", 1, 2.0))
    assert floor.links == (Link(4, "top", 1, 3.0), Link(0, "top", 1, 2.0))
