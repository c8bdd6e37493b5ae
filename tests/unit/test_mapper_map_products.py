import io
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from dead_reckoning import DeadReckoning
from drawing import draw
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.logs import OdometryRecord, ScanRecord
from pilotage.core.map_files import load_map, save_map_files
from pilotage.map_picture import map_picture, round_length, shrunk
from pilotage.mapper.map_products import (
    decided,
    finish,
    pose_graph_document,
    products,
    trajectory_document,
)
from pilotage.mapper.method import PoseGraph
from slam_metrics import read_tum

ROOM = draw(
    """
    ??####
    ??#..#
    ###..#
    #....#
    ######
""",
    0.5,
    (-1.0, 2.0, 0.0),
)


def small_run() -> DeadReckoning:
    method = DeadReckoning()
    for k in range(3):
        pose = (0.5 * k, 0.0, 0.0)
        method.process(OdometryRecord(float(k), pose))
        method.process(
            ScanRecord(float(k), np.full(5, 2.0, np.float32), -1.0, 0.5, 10.0, pose, (0.0, 0, 0))
        )
    return method


def graph(edges: list[tuple[int, int]], closures: list[bool]) -> PoseGraph:
    count = len(edges)
    known = np.array([[4.0, 1.0, 0.5], [1.0, 5.0, 0.0], [0.5, 0.0, 9.0]])
    return PoseGraph(
        np.array([10.0, 11.5]),
        np.array([[0.0, 0.0, 0.0], [1.0, 2.0, -0.5]]),
        np.array(edges, np.int64).reshape(-1, 2),
        np.tile([1.0, 2.0, -0.5], (count, 1)),
        np.tile(known, (count, 1, 1)),
        np.array(closures, bool),
    )


def test_cells_are_decided_and_what_is_not_known_stays_unknown() -> None:
    cells = np.array([[-1, 0, 20, 49, 50, 64, 65, 100]], np.int8)
    world = decided(OccupancyMap(GridGeometry(1, 8, 0.1), cells))
    assert world.cells.tolist() == [[-1, 0, 0, 0, -1, -1, 100, 100]]


def test_products_of_a_map_load_back(tmp_path: Path) -> None:
    finished = finish(small_run())
    save_map_files(tmp_path / "map.yaml", products(finished))
    again = load_map(tmp_path / "map.yaml")
    assert again.geometry == finished.world.geometry
    assert (again.cells == finished.world.cells).all()
    assert b"mode: trinary" in (tmp_path / "map.yaml").read_bytes()
    stamps, poses = read_tum(tmp_path / "trajectory.tum")
    assert stamps.tolist() == [0.0, 1.0, 2.0]
    assert poses[:, 0].tolist() == [0.0, 0.5, 1.0]


def test_map_comes_first_so_that_a_cut_save_leaves_it_whole() -> None:
    names = list(products(finish(small_run())))
    assert names == ["map.yaml", "map.pgm", "trajectory.tum", "pose_graph.g2o"]


def test_area_and_way_are_measured() -> None:
    finished = finish(small_run())
    assert finished.way_length == pytest.approx(1.0)
    assert finished.free_area == pytest.approx(0.01 * (finished.world.cells == 0).sum())


def test_trajectory_keeps_headings_all_the_way_round(tmp_path: Path) -> None:
    headings = np.linspace(-math.pi, math.pi - 0.01, 9)
    poses = np.column_stack([np.arange(9.0), -np.arange(9.0), headings])
    (tmp_path / "t.tum").write_bytes(trajectory_document(1.6e9 + np.arange(9) / 10, poses))
    stamps, again = read_tum(tmp_path / "t.tum")
    assert stamps == pytest.approx(1.6e9 + np.arange(9) / 10, abs=1e-5)
    assert np.abs(np.angle(np.exp(1j * (again[:, 2] - headings)))).max() < 1e-8
    assert again[:, :2] == pytest.approx(poses[:, :2])


def test_pose_graph_is_written_as_g2o_reads_it() -> None:
    lines = pose_graph_document(graph([(0, 1), (1, 0)], [False, True])).decode().splitlines()
    assert lines == [
        "# STAMP 0 10.000000",
        "# STAMP 1 11.500000",
        "# CLOSURE 1 0",
        "VERTEX_SE2 0 0 0 0",
        "VERTEX_SE2 1 1 2 -0.5",
        "FIX 0",
        "EDGE_SE2 0 1 1 2 -0.5 4 1 0.5 5 0 9",
        "EDGE_SE2 1 0 1 2 -0.5 4 1 0.5 5 0 9",
    ]


def test_pose_graph_may_have_no_edges_or_no_poses() -> None:
    assert b"EDGE" not in pose_graph_document(graph([], []))
    nothing = DeadReckoning().pose_graph()
    assert pose_graph_document(nothing) == b"\n"


def test_picture_shows_walls_the_way_and_its_ends() -> None:
    way = np.array([[0.0, 3.0, 0.0], [0.5, 3.0, 0.0], [1.0, 3.2, 0.5]])
    image = Image.open(io.BytesIO(map_picture(ROOM, way, "a room")))
    colours = {colour for _, colour in image.convert("RGB").getcolors(1 << 24) or []}
    assert {(0x1D, 0x27, 0x33), (255, 255, 255), (0xDF, 0xE3, 0xE8)} <= colours
    assert (0xC0, 0x39, 0x2B) in colours


@pytest.mark.parametrize("count", [0, 1, 20_000])
def test_picture_is_drawn_of_any_way(count: int) -> None:
    way = np.zeros((count, 3))
    way[:, 0] = np.linspace(0.0, 1.0, count)
    image = Image.open(io.BytesIO(map_picture(ROOM, way, "a room")))
    assert max(image.size) < 2000


def test_thin_walls_stay_where_a_large_map_is_shrunk() -> None:
    cells = np.full((5, 7), -1, np.int8)
    cells[:, 1:5], cells[2, :] = 0, 1
    assert shrunk(cells, 2).tolist() == [[0, 0, 0, -1], [1, 1, 1, 1], [0, 0, 0, -1]]
    assert shrunk(cells, 1).tolist() == cells.tolist()


def test_large_map_is_drawn_in_little_memory() -> None:
    large = OccupancyMap(GridGeometry(6000, 200, 0.05), np.zeros((6000, 200), np.int8))
    image = Image.open(io.BytesIO(map_picture(large, np.zeros((0, 3)), "a corridor")))
    assert max(image.size) < 2000


def test_map_of_nothing_is_drawn() -> None:
    nothing = OccupancyMap(ROOM.geometry, np.full_like(ROOM.cells, -1))
    assert map_picture(nothing, np.zeros((0, 3)), "nothing").startswith(b"\x89PNG")


def test_turned_map_is_drawn_where_it_lies() -> None:
    turned = OccupancyMap(replace(ROOM.geometry, origin=(10.0, -4.0, 0.7)), ROOM.cells)
    assert map_picture(turned, np.array([[10.0, -3.0, 0.0]]), "turned").startswith(b"\x89PNG")


@pytest.mark.parametrize(("longest", "bar"), [(0.3, 0.2), (1.0, 1.0), (9.9, 5.0), (27.0, 20.0)])
def test_scale_bar_has_a_round_length(longest: float, bar: float) -> None:
    assert round_length(longest) == pytest.approx(bar)
