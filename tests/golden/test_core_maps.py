from pathlib import Path

import numpy as np
import pytest

from pilotage.core.map_files import load_map, map_digest, save_map

pytestmark = pytest.mark.data

SQUARE_METRES = {
    "freiburg": (198, 38),
    "g4s": (383, 37),
    "gdc2": (1181, 74),
    "hospital": (1127, 141),
    "small_house": (158, 9),
    "stata_basement": (788, 47),
    "thickwean": (148, 49),
    "willow": (1092, 5),
}
"""Free floor and wall cells, counted once and compared with the drawings."""


@pytest.mark.parametrize("name", SQUARE_METRES)
def test_building_has_its_floor_and_its_walls(data_dir: Path, name: str) -> None:
    world = load_map(data_dir / "maps" / f"{name}.yaml")
    cell = world.geometry.resolution**2
    free, wall = SQUARE_METRES[name]
    assert world.is_free.sum() * cell == pytest.approx(free, abs=1.0)
    assert world.is_wall.sum() * cell == pytest.approx(wall, abs=1.0)


@pytest.mark.parametrize("name", SQUARE_METRES)
def test_building_survives_being_saved(data_dir: Path, tmp_path: Path, name: str) -> None:
    world = load_map(data_dir / "maps" / f"{name}.yaml")
    save_map(world, tmp_path / "again.yaml")
    assert map_digest(load_map(tmp_path / "again.yaml")) == map_digest(world)


def test_map_whose_image_was_packed_loads(data_dir: Path) -> None:
    world = load_map(data_dir / "birmingham" / "newlowerground.yaml")
    assert world.geometry.shape == (4000, 4000)
    assert world.is_wall.sum() == 6640


def test_doors_of_gdc2_lie_on_its_floor(data_dir: Path) -> None:
    """Corners of two doors by the map frame: orientation and origin are right."""
    world = load_map(data_dir / "maps" / "gdc2.yaml")
    middles = np.array([[1.15, 19.55], [7.3, 17.45], [5.15, 30.85], [-9.05, 17.65]])
    rows, cols = world.geometry.cells_of(middles).T
    assert world.is_free[rows, cols].all()


def test_wean_hall_has_its_long_corridor_along_x(data_dir: Path) -> None:
    world = load_map(data_dir / "wean_hall" / "wean.dat.gz")
    assert world.geometry.shape == (800, 800)
    assert world.geometry.resolution == 0.1
    along = np.stack([np.arange(12.0, 56.0, 0.5), np.linspace(42.5, 38.5, 88)], axis=1)
    rows, cols = world.geometry.cells_of(along).T
    assert world.is_free[rows, cols].mean() > 0.97
    assert world.is_wall.sum() * 0.01 == pytest.approx(202, abs=1.0)
