"""`pilotage topology`: a map in; a GeoJSON and a picture out."""

import io
import json
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np
import pytest
from geojson_pydantic import FeatureCollection
from PIL import Image

from drawing import draw
from floor_plans import FLAT, floor_plan
from naive.routes import read_as_nav2_route
from pilotage import cli
from pilotage.core.map_files import load_map, map_digest, save_map
from pilotage.topology.routes.geojson import floor_from_geojson


class Desk:
    """The files of one test, and the command run on them."""

    def __init__(self, folder: Path) -> None:
        self.map, self.out = folder / "flat.yaml", folder / "out" / "flat.geojson"
        save_map(floor_plan(FLAT, origin=(1.0, 2.0, 0.0)), self.map)

    def run(self, *more: str) -> int:
        return cli.run(["topology", str(self.map), "--out", str(self.out), *more])

    @property
    def document(self) -> dict[str, Any]:
        document: dict[str, Any] = json.loads(self.out.read_text("utf-8"))
        return document

    @property
    def picture(self) -> Image.Image:
        return Image.open(io.BytesIO(self.out.with_suffix(".png").read_bytes()))


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Desk:
    """What the command writes when all is well; to be read only."""
    desk = Desk(tmp_path_factory.mktemp("made"))
    assert desk.run() == 0
    return desk


def assert_one_line(capsys: pytest.CaptureFixture[str], reason: str) -> None:
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("pilotage: ")
    assert told.err.count("\n") == 1
    assert reason in told.err


def test_a_geojson_and_a_picture_are_written_and_nothing_else(made: Desk) -> None:
    assert sorted(file.name for file in made.out.parent.iterdir()) == ["flat.geojson", "flat.png"]


def test_nothing_is_said_where_all_is_well(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    assert desk.run() == 0
    assert capsys.readouterr() == ("", "")


def test_the_file_is_geojson(made: Desk) -> None:
    collection: FeatureCollection[Any] = FeatureCollection.model_validate_json(
        made.out.read_text("utf-8")
    )
    kinds = [feature.geometry.type for feature in collection.features if feature.geometry]
    assert kinds.count("Point") == 9
    assert set(kinds) == {"Point", "MultiLineString"}


def test_networkx_finds_a_way_from_each_room_to_each_other(made: Desk) -> None:
    graph = read_as_nav2_route(made.document)
    assert nx.is_strongly_connected(graph)
    assert all(edge["cost"] > 0.0 for _, _, edge in graph.edges(data=True))


def test_the_file_says_of_which_map_it_is_and_how_it_was_made(desk: Desk) -> None:
    assert desk.run("--spacing", "equal", "--distance", "2.5") == 0
    floor = floor_from_geojson(desk.document)
    assert floor.map.map_id == map_digest(load_map(desk.map))
    assert (floor.name, floor.spacing, floor.built_from) == ("flat", "equal", "map")


def test_doors_lie_where_the_origin_of_the_map_puts_them(made: Desk) -> None:
    nodes = floor_from_geojson(made.document).map.nodes
    doors = np.array([node.pose[:2] for node in nodes if node.kind == "door"])
    assert np.sort(doors[:, 0]) == pytest.approx([3.25, 7.45, 11.95], abs=0.06)
    assert doors[:, 1] == pytest.approx([3.95] * 3, abs=0.16)


def test_closer_nodes_are_more_nodes(desk: Desk) -> None:
    counts = []
    for distance in ("4.0", "1.0"):
        assert desk.run("--spacing", "equal", "--distance", distance) == 0
        counts.append(len(floor_from_geojson(desk.document).map.nodes))
    assert counts[1] > 1.5 * counts[0]


def test_the_same_map_gives_the_same_file(made: Desk, desk: Desk) -> None:
    assert desk.run() == 0
    assert desk.out.read_bytes() == made.out.read_bytes()


def test_the_picture_is_a_png_of_a_decent_size_with_all_its_colours(made: Desk) -> None:
    assert made.picture.format == "PNG"
    assert 300 < min(made.picture.size) <= max(made.picture.size) < 5000
    shown = np.asarray(made.picture.convert("RGB")).reshape(-1, 3)
    for colour in ((0xC0, 0x39, 0x2B), (0x19, 0x66, 0x59)):  # doors, nodes
        assert (np.abs(shown - np.array(colour, int)).max(axis=1) <= 8).sum() > 100


def test_picture_of_a_map_that_lies_askew_shows_its_rooms(desk: Desk) -> None:
    save_map(floor_plan(FLAT, origin=(-3.0, 5.0, 0.5)), desk.map)
    assert desk.run() == 0
    shown = np.asarray(desk.picture.convert("RGB")).reshape(-1, 3)
    tinted = np.abs(shown - np.array((0xE6, 0xF4, 0xDD), int)).max(axis=1) <= 4
    assert tinted.mean() > 0.01


def test_missing_map_ends_with_2_and_one_line(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.map.unlink()
    assert desk.run() == 2
    assert_one_line(capsys, str(desk.map))
    assert not desk.out.parent.exists()


@pytest.mark.parametrize("content", [b"", b"\x00\xff\x1f", b"- 1\n- 2\n", b"image: gone.png\n"])
def test_damaged_map_ends_with_2_and_one_line(
    desk: Desk, capsys: pytest.CaptureFixture[str], content: bytes
) -> None:
    desk.map.write_bytes(content)
    assert desk.run() == 2
    assert_one_line(capsys, "flat.yaml")
    assert not desk.out.parent.exists()


def test_wrong_suffix_ends_with_2_and_one_line(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.out = desk.out.with_suffix(".yaml")
    assert desk.run() == 2
    assert_one_line(capsys, "must end in .geojson or .json")
    assert not desk.out.parent.exists()


@pytest.mark.parametrize("mark", ["#", "?"])
def test_map_without_space_ends_with_2_and_one_line(
    desk: Desk, capsys: pytest.CaptureFixture[str], mark: str
) -> None:
    save_map(draw((mark * 9 + "\n") * 9, resolution=0.3), desk.map)
    assert desk.run() == 2
    assert_one_line(capsys, "nothing in it is large enough")
    assert not desk.out.parent.exists()


@pytest.mark.parametrize("arguments", ["--distance 0.1", "--distance nan", "--spacing odd"])
def test_bad_arguments_end_with_2(desk: Desk, arguments: str) -> None:
    assert desk.run(*arguments.split()) == 2
    assert not desk.out.parent.exists()


def test_out_in_a_place_that_is_a_file_ends_with_2_and_one_line(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.out.parent.write_text("mine")
    assert desk.run() == 2
    assert_one_line(capsys, "out")
    assert desk.out.parent.read_text() == "mine"


def test_old_files_stay_where_the_new_map_is_damaged(desk: Desk) -> None:
    assert desk.run() == 0
    before = {file.name: file.read_bytes() for file in desk.out.parent.iterdir()}
    desk.map.write_bytes(b"")
    assert desk.run() == 2
    assert {file.name: file.read_bytes() for file in desk.out.parent.iterdir()} == before


def test_folder_in_place_of_the_file_to_write_ends_with_2_and_leaves_nothing(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.out.mkdir(parents=True)
    assert desk.run() == 2
    assert_one_line(capsys, "that is a folder")
    assert list(desk.out.parent.iterdir()) == [desk.out]
