"""The map as files for browsers and map_server."""

import asyncio
import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from gateway_world import grid
from pilotage.core.map_files import load_map
from pilotage.gateway.map_files import MapFiles
from pilotage.gateway.map_image import pgm, png, shades, yaml
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.mapping import OccupancyGrid

CORNER = """
    #??
    #..
"""


def test_the_top_line_of_the_drawing_is_the_top_row_of_the_image() -> None:
    expected = [[0, 205, 205], [0, 254, 254]]
    assert shades(grid(CORNER).cells).tolist() == expected


@pytest.mark.parametrize(
    ("cell", "shade"), [(-1, 205), (0, 254), (19, 254), (20, 205), (64, 205), (65, 0), (100, 0)]
)
def test_probabilities_are_cut_where_map_server_cuts(cell: int, shade: int) -> None:
    assert shades(np.array([[cell]], np.int8)).tolist() == [[shade]]


def test_the_png_holds_the_shades() -> None:
    with Image.open(io.BytesIO(png(grid(CORNER)))) as image:
        assert image.mode == "L"
        np.testing.assert_array_equal(np.asarray(image), shades(grid(CORNER).cells))


def test_the_pgm_is_binary_with_the_width_first() -> None:
    assert pgm(grid(CORNER)) == b"P5\n3 2\n255\n" + bytes([0, 205, 205, 0, 254, 254])


@pytest.mark.parametrize("resolution", [0.05, 0.1, 1 / 3])
def test_the_files_load_back_as_the_same_map(tmp_path: Path, resolution: float) -> None:
    rng = np.random.default_rng(7)
    cells = rng.choice(np.array([-1, 0, 100], np.int8), (31, 17))
    origin = Pose2(x=-3.25, y=1e-7, theta=0.5)
    world = OccupancyGrid(
        stamp_ns=1,
        frame_id="map",
        map_id="m",
        name="m",
        resolution=resolution,
        origin=origin,
        cells=cells,
    )
    (tmp_path / "map.pgm").write_bytes(pgm(world))
    (tmp_path / "map.yaml").write_bytes(yaml(world))
    loaded = load_map(tmp_path / "map.yaml")
    np.testing.assert_array_equal(loaded.cells, cells)
    assert loaded.geometry.resolution == resolution
    np.testing.assert_array_equal(loaded.geometry.origin, (-3.25, 1e-7, 0.5))


def test_a_map_is_drawn_once_for_all_who_ask() -> None:
    drawn: list[OccupancyGrid] = []

    def draw(world: OccupancyGrid) -> bytes:
        drawn.append(world)
        return world.map_id.encode()

    async def ask() -> list[bytes]:
        files, old, new = MapFiles(), grid("#"), grid(".", map_id="new")
        first = await asyncio.gather(files.get(old, draw), files.get(old, draw))
        return [*first, await files.get(new, draw), await files.get(new, draw)]

    assert asyncio.run(ask()) == [b"abc", b"abc", b"new", b"new"]
    assert [world.map_id for world in drawn] == ["abc", "new"]
