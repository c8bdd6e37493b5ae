"""The library of topological maps, and what a run keeps."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from pilotage.topology.routes.floors import Floor, Link
from pilotage.topology.routes.geojson import to_geojson
from pilotage.topology.routes.strict_json import JsonError
from pilotage.topology.storage import LibraryError, RunFolder, TopologyLibrary, packed, parsed
from topology_maps import CORRIDOR, graph

OFFICE = Floor(CORRIDOR, "office", "ground floor")
TOP = Floor(graph([(0.0, 0.0), (6.0, 0.0)], [(0, 1)], "4567"), "top")


@pytest.fixture
def library(tmp_path: Path) -> TopologyLibrary:
    return TopologyLibrary(tmp_path / "topologies")


def test_a_saved_map_is_there_again_with_its_floor(library: TopologyLibrary) -> None:
    path = library.save(OFFICE)
    assert path.name == "office.geojson"
    assert json.loads(path.read_text())["type"] == "FeatureCollection"
    again = TopologyLibrary(path.parent).load("office")
    assert (again.name, again.label, again.map.map_id) == ("office", "ground floor", "0123")
    assert len(again.map.edges) == 4


def test_saving_again_replaces_it(library: TopologyLibrary) -> None:
    library.save(OFFICE)
    assert library.load("office").label == "ground floor"
    library.save(replace(OFFICE, label="cellar"))
    assert library.load("office").label == "cellar"
    assert library.names() == ["office"]


def test_all_maps_are_listed_by_name_but_for_damaged_ones(library: TopologyLibrary) -> None:
    folder = library.save(TOP).parent
    library.save(OFFICE)
    (folder / "broken.geojson").write_text("{", encoding="utf-8")
    (folder / "notes.txt").write_text("?", encoding="utf-8")
    assert [stored.floor.name for stored in library.all()] == ["office", "top"]
    with pytest.raises(LibraryError, match="'broken' is damaged: it is not JSON"):
        library.load("broken")


def test_a_file_that_somebody_put_there_goes_by_the_name_of_the_file(
    library: TopologyLibrary,
) -> None:
    folder = library.save(TOP).parent
    (folder / "copy.geojson").write_bytes((folder / "top.geojson").read_bytes())
    assert library.load("copy").name == "copy"


def test_a_deleted_map_is_gone(library: TopologyLibrary) -> None:
    library.save(OFFICE)
    library.delete("office")
    with pytest.raises(LibraryError, match="no topological map 'office'; there is none yet"):
        library.load("office")
    with pytest.raises(LibraryError, match="no topological map"):
        library.delete("office")


@pytest.mark.parametrize("name", ["", "../office", "a/b", ".hidden", "x" * 65, "a\nb", "ä"])
def test_a_name_that_could_lead_elsewhere_is_refused(library: TopologyLibrary, name: str) -> None:
    for wish in (
        lambda: library.save(replace(OFFICE, name=name)),
        lambda: library.load(name),
        lambda: library.delete(name),
        lambda: library.store(name, packed(OFFICE)),
    ):
        with pytest.raises(LibraryError, match="cannot name a map"):
            wish()


def test_without_a_folder_there_is_no_library() -> None:
    library = TopologyLibrary(None)
    assert list(library.all()) == []
    with pytest.raises(LibraryError, match="topologies_dir"):
        library.save(OFFICE)


def test_the_newest_map_of_an_occupancy_map_is_found(library: TopologyLibrary) -> None:
    os.utime(library.save(OFFICE), ns=(1, 1))
    os.utime(library.save(replace(OFFICE, name="newer")), ns=(2, 2))
    library.save(TOP)
    found = library.of_map("0123")
    assert found is not None
    assert found.name == "newer"
    assert library.of_map("8888") is None


def test_a_link_joins_two_maps_both_ways(library: TopologyLibrary) -> None:
    library.save(OFFICE)
    library.save(TOP)
    library.link(("office", 4), ("top", 1), 12.0)
    assert library.load("office").links == (Link(4, "top", 1, 12.0),)
    assert library.load("top").links == (Link(1, "office", 4, 12.0),)


def test_a_link_needs_two_maps_and_two_nodes(library: TopologyLibrary) -> None:
    library.save(OFFICE)
    library.save(TOP)
    with pytest.raises(LibraryError, match="joins two maps"):
        library.link(("office", 4), ("office", 1), 1.0)
    with pytest.raises(LibraryError, match="'top' has no node 9"):
        library.link(("office", 4), ("top", 9), 1.0)
    with pytest.raises(LibraryError, match="no topological map 'cellar'; there is office, top"):
        library.link(("office", 4), ("cellar", 1), 1.0)
    assert library.load("office").links == ()


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "it is not JSON"),
        (b"\xff\xfe\x00", "it is not JSON"),
        (b"[" * 100_000, "nested too deeply"),
        (b'{"type": "FeatureCollection", "type": 1}', "stands twice"),
        (b'{"type": "FeatureCollection", "x": NaN}', "NaN is not JSON"),
        (b'{"type": "FeatureCollection"}', "features is missing"),
    ],
)
def test_what_is_no_map_is_not_taken_in(
    library: TopologyLibrary, content: bytes, reason: str
) -> None:
    with pytest.raises(LibraryError, match=f"this is no topological map: .*{reason}"):
        library.store("office", content)
    assert library.names() == []


def test_map_without_nodes_is_not_taken_in(library: TopologyLibrary) -> None:
    nothing = json.dumps({"type": "FeatureCollection", "features": []}).encode()
    with pytest.raises(LibraryError, match="it has no nodes"):
        library.store("nothing", nothing)
    assert library.names() == []


def test_what_is_taken_in_goes_by_its_new_name(library: TopologyLibrary) -> None:
    library.store("copy", packed(OFFICE))
    assert library.load("copy").label == "ground floor"
    library.store("bare", json.dumps(to_geojson(CORRIDOR)).encode())
    assert library.load("bare").name == "bare"


def test_a_full_disk_leaves_the_old_map(
    library: TopologyLibrary, monkeypatch: pytest.MonkeyPatch
) -> None:
    library.save(OFFICE)

    def full(_descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(LibraryError, match="'office' could not be saved: No space left"):
        library.save(replace(OFFICE, label="cellar"))
    assert library.load("office").label == "ground floor"


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(LibraryError, match="no library at"):
        TopologyLibrary(tmp_path / "file" / "topologies").save(OFFICE)


def test_a_file_too_large_for_the_bus_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pilotage.topology.storage.LARGEST", 10)
    with pytest.raises(JsonError, match="10 are taken at most"):
        parsed(packed(OFFICE))


def test_a_run_keeps_the_map_in_use(tmp_path: Path) -> None:
    warnings: list[str] = []
    folder = RunFolder(tmp_path, warnings.append)
    assert folder.load() is None
    folder.save(OFFICE)
    kept = RunFolder(tmp_path, warnings.append).load()
    assert kept is not None
    assert (kept.name, len(kept.map.nodes)) == ("office", 5)
    assert warnings == []


def test_a_damaged_memory_costs_the_memory_only(tmp_path: Path) -> None:
    warnings: list[str] = []
    folder = RunFolder(tmp_path, warnings.append)
    folder.save(OFFICE)
    (tmp_path / "topology.geojson").write_text("half", encoding="utf-8")
    assert folder.load() is None
    assert "topology.geojson is ignored: it is not JSON" in warnings[0]
    RunFolder(tmp_path / "missing", warnings.append).save(OFFICE)
    assert "not kept" in warnings[-1]


def test_without_a_run_folder_nothing_is_kept() -> None:
    folder = RunFolder(None, pytest.fail)
    folder.save(OFFICE)
    assert folder.load() is None
