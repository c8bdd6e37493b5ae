"""The topology service on a fake bus: its map, its library, its answers."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pilotage.bus.fabric import RefusedError
from pilotage.topology.config import TopologySettings
from pilotage.topology.routes.floors import Floor
from pilotage.topology.routes.geojson import floor_to_geojson
from pilotage.topology.storage import TopologyLibrary, packed, parsed
from pilotage_schemas import topology as t
from pilotage_schemas.commands import Nothing
from topology_bench import FLAT, TopologyBench
from topology_maps import CORRIDOR

TOP = Floor(replace(CORRIDOR, map_id="top"))


@pytest.fixture
def bench(tmp_path: Path) -> TopologyBench:
    bench = TopologyBench(tmp_path)
    bench.describe()
    return bench


def newest(bench: TopologyBench) -> t.TopologicalMap:
    message = bench.heard["topology"][-1]
    assert isinstance(message, t.TopologicalMap)
    return message


def node_of(bench: TopologyBench, x: float, y: float) -> int:
    found = bench.ask("nearest_node", t.NearestNode(x=x, y=y))
    return int(found.node)


def test_a_map_is_followed_by_its_places_and_ways(bench: TopologyBench) -> None:
    grid = bench.put_map()
    world = newest(bench)
    assert world.map_id == grid.map_id
    assert [node.kind for node in world.nodes].count("door") == 2
    assert {edge.kind for edge in world.edges} >= {"corridor", "door"}
    ends = {node.id: (node.pose.x, node.pose.y) for node in world.nodes}
    for edge in world.edges:
        np.testing.assert_allclose(edge.way[[0, -1]], [ends[edge.start], ends[edge.end]], atol=0.1)


def test_the_same_map_again_changes_nothing(bench: TopologyBench) -> None:
    bench.put_map()
    bench.put_map()
    assert len(bench.heard["topology"]) == 1


def test_the_way_from_room_to_room_leads_through_both_doors(bench: TopologyBench) -> None:
    bench.put_map()
    route = bench.ask(
        "topology_route", t.TopologyRoute(start=t.Point(x=2.7, y=10.7), end=t.Point(x=8.9, y=3.3))
    )
    names = {node.id: node.kind for node in newest(bench).nodes}
    assert [names[node] for node in route.nodes].count("door") == 2
    assert len(route.edges) == len(route.nodes) - 1
    length = float(np.hypot(*np.diff(route.way, axis=0).T).sum())
    assert route.cost == pytest.approx(length + 2 * 2.0, abs=0.5)
    (floor,) = route.floors
    assert (floor.nodes, floor.points) == (len(route.nodes), len(route.way))


def test_the_nearest_node_is_named(bench: TopologyBench) -> None:
    bench.put_map()
    found = bench.ask("nearest_node", t.NearestNode(x=2.5, y=8.2))
    assert found.name.startswith("door")
    assert found.distance < 0.2


def test_what_cannot_be_answered_is_refused(bench: TopologyBench) -> None:
    for query, request in (
        ("nearest_node", t.NearestNode(x=0.0, y=0.0)),
        ("topology_route", t.TopologyRoute(start=0, end=1)),
        ("topology_save", t.TopologySave(name="flat")),
        ("topology_fetch", t.TopologyFetch()),
    ):
        with pytest.raises(RefusedError, match="there is no topological map yet"):
            bench.ask(query, request)
    with pytest.raises(RefusedError, match="there is no map yet"):
        bench.ask("topology_build", t.TopologyBuild())
    with pytest.raises(RefusedError, match="map_start begins one"):
        bench.ask("topology_build", t.TopologyBuild(source="drive"))
    bench.put_map()
    with pytest.raises(RefusedError, match="there is no node 99"):
        bench.ask("topology_route", t.TopologyRoute(start=99, end=1))


def test_route_from_a_point_off_the_map_is_refused() -> None:
    bench = TopologyBench()
    bench.put_map()
    far = t.Point(x=-500.0, y=-500.0)
    with pytest.raises(RefusedError, match=r"\(-500\.00, -500\.00\) is off the map: node \d+, "):
        bench.ask("topology_route", t.TopologyRoute(start=far, end=1))


def test_nodes_of_equal_spacing_can_be_had(bench: TopologyBench) -> None:
    bench.put_map()
    wide = bench.ask("topology_build", t.TopologyBuild(spacing="equal", metres=4.0))
    close = bench.ask("topology_build", t.TopologyBuild(spacing="equal", metres=1.5))
    assert close.nodes > wide.nodes
    assert newest(bench).spacing == "equal"
    assert len(newest(bench).nodes) == close.nodes


def test_a_saved_map_is_used_again_with_the_names_that_people_gave(bench: TopologyBench) -> None:
    grid = bench.put_map()
    saved = bench.ask("topology_save", t.TopologySave(name="flat", floor="second floor"))
    assert (saved.name, saved.map_id) == ("flat", grid.map_id)
    assert (newest(bench).name, newest(bench).floor) == ("flat", "second floor")
    (listed,) = bench.ask("topology_list", Nothing()).topologies
    assert (listed.name, listed.floor, listed.nodes) == (
        "flat",
        "second floor",
        len(newest(bench).nodes),
    )


def test_a_kept_map_is_used_in_place_of_a_new_one(tmp_path: Path) -> None:
    first = TopologyBench(tmp_path)
    first.put_map()
    floor = parsed(first.ask("topology_fetch", t.TopologyFetch()).content.tobytes())
    renamed = replace(floor.map.nodes[0], name="kitchen door")
    world = replace(floor.map, nodes=(renamed, *floor.map.nodes[1:]))
    TopologyLibrary(tmp_path / "library").save(replace(floor, name="flat", map=world))
    later = TopologyBench(settings=TopologySettings(topologies_dir=tmp_path / "library"))
    later.put_map()
    assert newest(later).nodes[0].name == "kitchen door"
    assert newest(later).name == "flat"


def test_a_map_of_another_floor_is_not_used_on_this_one(bench: TopologyBench) -> None:
    bench.put_map()
    content = np.frombuffer(json.dumps(floor_to_geojson(TOP)).encode(), np.int8)
    bench.ask("topology_store", t.TopologyStore(name="top", content=content))
    with pytest.raises(RefusedError, match="'top' is of map top"):
        bench.ask("topology_load", t.TopologyLoad(name="top"))
    assert newest(bench).name == ""


def test_a_map_of_the_library_can_be_used_and_deleted(bench: TopologyBench) -> None:
    bench.put_map()
    bench.ask("topology_save", t.TopologySave(name="flat"))
    bench.ask("topology_build", t.TopologyBuild(spacing="equal", metres=1.0))
    loaded = bench.ask("topology_load", t.TopologyLoad(name="flat"))
    assert (newest(bench).name, len(newest(bench).nodes)) == ("flat", loaded.nodes)
    assert bench.ask("topology_delete", t.TopologyDelete(name="flat")).detail == "deleted flat"
    with pytest.raises(RefusedError, match="no topological map 'flat'"):
        bench.ask("topology_load", t.TopologyLoad(name="flat"))


def test_what_is_no_map_is_not_stored(bench: TopologyBench) -> None:
    content = np.frombuffer(b"{}", np.int8)
    with pytest.raises(RefusedError, match="this is no topological map: type is missing"):
        bench.ask("topology_store", t.TopologyStore(name="flat", content=content))
    with pytest.raises(RefusedError, match="cannot name a map"):
        bench.ask("topology_delete", t.TopologyDelete(name="../flat"))


def test_a_way_takes_the_lift_to_a_floor_of_the_library(bench: TopologyBench) -> None:
    bench.put_map()
    bench.ask("topology_save", t.TopologySave(name="flat", floor="1"))
    content = np.frombuffer(packed(replace(TOP, label="2")), np.int8)
    bench.ask("topology_store", t.TopologyStore(name="top", content=content))
    lift = node_of(bench, 8.9, 3.3)
    ends = {"start": t.NodeOf(name="flat", node=lift), "end": t.NodeOf(name="top", node=4)}
    joined = bench.ask("topology_link", t.TopologyLink.model_validate(ends | {"cost": 15.0}))
    assert joined.detail == "flat and top are joined"
    assert [link.there for link in newest(bench).links] == [4]
    wish = t.TopologyRoute(start=t.Point(x=2.7, y=10.7), end=t.NodeOf(name="top", node=0))
    route = bench.ask("topology_route", wish)
    assert [(part.name, part.floor) for part in route.floors] == [("flat", "1"), ("top", "2")]
    assert route.nodes[route.floors[0].nodes - 1] == lift
    assert route.nodes[-1] == 0
    assert len(route.way) == sum(part.points for part in route.floors)
    with pytest.raises(RefusedError, match="joins two maps"):
        bench.ask("topology_link", t.TopologyLink(start=ends["start"], end=ends["start"]))


def test_after_a_crash_the_map_of_this_run_is_used(bench: TopologyBench) -> None:
    bench.put_map()
    bench.ask("topology_build", t.TopologyBuild(spacing="equal", metres=1.0))
    nodes = len(newest(bench).nodes)
    bench.crash()
    assert (newest(bench).spacing, len(newest(bench).nodes)) == ("equal", nodes)


def test_a_map_that_grows_is_shown_at_most_once_a_second(bench: TopologyBench) -> None:
    bench.put_status("mapping")
    bench.put_growing_map()
    bench.ride((10.0, 7.0), (9.0, 7.0), (9.0, 2.0), owner=bench.mapper)
    shown = bench.heard["topology"]
    assert shown[0].nodes == ()
    assert {message.built_from for message in shown} == {"drive"}
    assert {message.map_id for message in shown[1:]} == {"growing-1"}
    gaps = np.diff([message.stamp_ns for message in shown[1:]])
    assert gaps.min() >= 1_000_000_000
    assert [node.kind for node in shown[-1].nodes].count("door") == 1


def test_nothing_grows_while_nobody_knows_where_the_robot_is(bench: TopologyBench) -> None:
    bench.put_status("mapping")
    bench.put_growing_map()
    bench.ride((9.0, 7.0), owner=bench.mapper, state="unknown")
    assert all(message.nodes == () for message in bench.heard["topology"])


def test_a_finished_map_takes_the_place_of_what_grew(bench: TopologyBench) -> None:
    bench.put_status("mapping")
    bench.put_growing_map()
    bench.ride((6.0, 7.0), owner=bench.mapper)
    bench.put_status("idle")
    bench.put_map()
    assert newest(bench).built_from == "map"
    assert [node.kind for node in newest(bench).nodes].count("door") == 2


def test_who_wants_the_driven_map_keeps_it_when_mapping_ends(tmp_path: Path) -> None:
    bench = TopologyBench(tmp_path, TopologySettings(build="drive", metres=3.0))
    bench.describe()
    bench.put_status("mapping")
    bench.put_growing_map()
    bench.ride((10.0, 7.0), (9.0, 7.0), (9.0, 4.0), owner=bench.mapper)
    bench.put_status("idle")
    grid = bench.put_map()
    assert (newest(bench).built_from, newest(bench).map_id) == ("drive", grid.map_id)


def test_a_map_can_be_built_by_driving_about_on_a_finished_one(bench: TopologyBench) -> None:
    bench.put_map()
    loaded = bench.ask("topology_build", t.TopologyBuild(source="drive", spacing="equal"))
    assert loaded.nodes == 0
    bench.ride((10.0, 7.0))
    assert newest(bench).spacing == "equal"
    assert len(newest(bench).nodes) >= 2
    assert newest(bench).map_id == bench.put_map().map_id


def test_a_crash_while_the_map_grows_costs_seconds_of_it(bench: TopologyBench) -> None:
    bench.put_status("mapping")
    bench.put_growing_map()
    bench.ride((10.0, 7.0), owner=bench.mapper)
    before = len(newest(bench).nodes)
    bench.crash()
    bench.ride((9.0, 7.0), (9.0, 4.0), owner=bench.mapper)
    after = newest(bench)
    assert len(after.nodes) > before
    assert min(node.pose.x for node in after.nodes) < 2.0


def test_a_new_map_in_the_making_begins_with_nothing(bench: TopologyBench) -> None:
    bench.put_status("mapping", since_ns=5)
    bench.put_growing_map()
    bench.ride((9.0, 7.0), owner=bench.mapper)
    assert newest(bench).nodes
    bench.put_status("mapping", since_ns=6)
    assert newest(bench).nodes == ()


def test_when_a_loop_is_closed_the_places_move_along(bench: TopologyBench) -> None:
    bench.put_status("mapping")
    bench.put_growing_map()
    bench.ride((10.0, 7.0), owner=bench.mapper)
    before = newest(bench).nodes[0].pose
    bench.put_path(shift=(0.0, 1.0, 0.0))
    bench.look(owner=bench.mapper, error=(0.0, 1.0, 0.0))
    bench.ride((9.9, 7.0), owner=bench.mapper, error=(0.0, 1.0, 0.0))
    after = newest(bench).nodes[0].pose
    assert (after.x, after.y) == pytest.approx((before.x, before.y + 1.0), abs=0.05)


def test_a_damaged_drive_costs_the_drive_only(bench: TopologyBench, tmp_path: Path) -> None:
    bench.put_status("mapping")
    bench.put_growing_map()
    bench.ride((6.0, 7.0), owner=bench.mapper)
    (tmp_path / "topology.drive").write_bytes(b"half")
    bench.crash()
    assert newest(bench).nodes == ()


def test_a_map_without_floor_has_no_places(bench: TopologyBench) -> None:
    cells = np.full(FLAT.cells.shape, -1, np.int8)
    bench.put_map(replace(FLAT, cells=cells))
    assert newest(bench).nodes == ()
