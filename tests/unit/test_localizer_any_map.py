"""The same flat from every kind of map file: the robot is found at the same place in all."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from drawing import draw
from localizer_world import PLAN, ROUND, START, error, look, poses_along
from pilotage.core import se2
from pilotage.core.grid import FREE, OCCUPIED, UNKNOWN, GridGeometry, OccupancyMap
from pilotage.core.map_files import load_map
from pilotage.localizer.markov_localizer import MarkovParams
from pilotage.localizer.methods import FINDERS, MethodSetup, make_method
from pilotage.localizer.pose_grid import PoseGridParams

MARK_M = 0.4
"""Each mark of the plan is so wide [m], in cells of any size that divides it."""

RIM_M = 0.8
"""Unknown ground around the flat, as every scanner leaves it [m]."""

SETUP = MethodSetup(markov=MarkovParams(grid=PoseGridParams(headings=36)))


@dataclass(frozen=True)
class Sheet:
    """How a map is written: shades of wall, free and unknown, and the YAML around them.

    `unknown` None: transparent, the only unknown that mode scale has.
    """

    wall: int = 0
    free: int = 254
    unknown: int | None = 205
    mode: str = "trinary"
    negate: int = 0
    free_thresh: float = 0.196
    occupied_thresh: float = 0.65
    cell: float = 0.1
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    image: str = "flat.pgm"

    def world(self) -> OccupancyMap:
        """What the file must say."""
        marks = round(MARK_M / self.cell)
        cells = np.kron(draw(PLAN).cells, np.ones((marks, marks), np.int8))
        cells = np.pad(cells, round(RIM_M / self.cell), constant_values=UNKNOWN)
        rows, cols = cells.shape
        return OccupancyMap(GridGeometry(rows, cols, self.cell, self.origin), cells)

    def write(self, folder: Path) -> Path:
        cells = self.world().cells[::-1]
        grey = np.zeros(cells.shape, np.uint8)
        for value, shade in ((OCCUPIED, self.wall), (FREE, self.free), (UNKNOWN, self.unknown)):
            grey[cells == value] = 0 if shade is None else shade
        opaque = np.where((cells == UNKNOWN) & (self.unknown is None), 0, 255).astype(np.uint8)
        is_plain = self.unknown is not None
        pixels = grey if is_plain else np.dstack([grey, grey, grey, opaque])
        Image.fromarray(pixels).save(folder / self.image)
        x, y, theta = self.origin
        file = folder / "flat.yaml"
        file.write_text(
            f"image: {self.image}\nmode: {self.mode}\nresolution: {self.cell}\n"
            f"origin: [{x}, {y}, {theta}]\nnegate: {self.negate}\n"
            f"free_thresh: {self.free_thresh}\noccupied_thresh: {self.occupied_thresh}\n"
        )
        return file


SHEETS = {
    "trinary": Sheet(),
    "trinary, as png": Sheet(image="flat.png"),
    "trinary, grey walls": Sheet(wall=60, free=230, free_thresh=0.12, occupied_thresh=0.7),
    "trinary, wide thresholds": Sheet(unknown=128, free_thresh=0.05, occupied_thresh=0.95),
    "trinary, narrow thresholds": Sheet(
        wall=120, free=140, unknown=130, free_thresh=0.47, occupied_thresh=0.51
    ),
    "trinary, transparent unknown": Sheet(unknown=None, image="flat.png", free_thresh=0.196),
    "negated": Sheet(wall=255, free=1, unknown=50, negate=1),
    "scale": Sheet(mode="scale", unknown=None, image="flat.png"),
    "scale, grey": Sheet(mode="scale", wall=70, free=220, unknown=None, image="flat.png"),
    "scale, negated": Sheet(
        mode="scale", wall=250, free=10, unknown=None, negate=1, image="flat.png"
    ),
    "raw": Sheet(mode="raw", wall=100, free=0, unknown=255),
    "raw, graded": Sheet(mode="raw", wall=65, free=30, unknown=101),
    "raw, negated": Sheet(mode="raw", wall=155, free=255, unknown=0, negate=1),
    "0.02 m": Sheet(cell=0.02),
    "0.04 m": Sheet(cell=0.04),
    "0.05 m": Sheet(cell=0.05),
    "0.08 m": Sheet(cell=0.08),
    "0.20 m": Sheet(cell=0.2),
    "shifted": Sheet(origin=(-31.7, 12.3, 0.0)),
    "turned": Sheet(origin=(4.0, -9.0, 0.7), cell=0.05),
    "upside down": Sheet(origin=(4.0, -9.0, 3.0), cell=0.2),
    "turned by more than a turn": Sheet(origin=(1.0, 1.0, -6.5)),
    "turned by a quarter": Sheet(origin=(0.0, 0.0, np.pi / 2)),
}


@pytest.mark.parametrize("kind", SHEETS)
def test_the_file_says_what_was_drawn(kind: str, tmp_path: Path) -> None:
    sheet = SHEETS[kind]
    drawn, loaded = sheet.world(), load_map(sheet.write(tmp_path))
    if kind == "trinary, transparent unknown":
        # map_server's trinary mode does not look at transparency: black is a wall.
        assert np.array_equal(loaded.is_wall, drawn.is_wall | (drawn.cells == UNKNOWN))
    else:
        assert np.array_equal(loaded.is_wall, drawn.is_wall)
    assert np.array_equal(loaded.is_free, drawn.is_free)


def localized(world: OccupancyMap, sheet: Sheet, method: str) -> tuple[float, float, str]:
    """Drive through the flat with an exact laser; how far off [m], [rad] and what is said."""
    params = SETUP.markov
    localizer = make_method(method, world, SETUP, np.random.default_rng(3))
    corner = se2.compose(sheet.origin, [RIM_M, RIM_M, 0.0])
    true_world = Sheet(cell=0.02, origin=sheet.origin).world()
    truth = list(poses_along(se2.compose(corner, START), ROUND))
    for count, pose in enumerate(truth):
        odom = se2.between(truth[0], pose)
        localizer.update(count * 1_000_000_000, odom, look(true_world, pose, params))
    return *error(localizer.estimate.pose, truth[-1]), localizer.estimate.state


@pytest.mark.parametrize("kind", SHEETS)
def test_the_robot_is_found_on_it(kind: str, tmp_path: Path) -> None:
    sheet = SHEETS[kind]
    away, turn, state = localized(load_map(sheet.write(tmp_path)), sheet, "markov")
    assert state == "localized"
    assert away < max(0.05, 0.4 * sheet.cell)
    assert turn < 0.01


@pytest.mark.parametrize("kind", ["trinary", "scale, grey", "raw, graded", "0.20 m", "turned"])
@pytest.mark.parametrize("method", [name for name in FINDERS if name != "markov"])
def test_it_is_found_by_other_methods_too(kind: str, method: str, tmp_path: Path) -> None:
    sheet = SHEETS[kind]
    away, turn, state = localized(load_map(sheet.write(tmp_path)), sheet, method)
    assert state == "localized"
    assert away < 0.1
    assert turn < 0.03


def test_walls_of_one_fine_cell_are_not_lost_on_coarser_ones() -> None:
    """A sheet drawn by a CAD program: lines of 2 cm."""
    fine = Sheet(cell=0.02).world()
    inner = np.zeros(fine.cells.shape, bool)
    walls = fine.cells == OCCUPIED
    for axis in (0, 1):
        for step in (1, -1):
            inner |= np.roll(fine.cells == FREE, step, axis)
    lines = np.where(walls & ~inner, UNKNOWN, fine.cells).astype(np.int8)
    world = OccupancyMap(fine.geometry, lines)
    away, turn, state = localized(world, Sheet(cell=0.02), "markov")
    assert state == "localized"
    assert away < 0.05
    assert turn < 0.01
