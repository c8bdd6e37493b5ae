import gzip
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from drawing import draw
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.map_files import MapFileError, load_map, map_digest, save_map

YAML = """
image: {image}
resolution: 0.05
origin: [-1.5, 2.0, 0.25]
occupied_thresh: 0.65
free_thresh: 0.196
negate: 0
"""
SHADES = np.array([[0, 100, 205], [254, 255, 88]], np.uint8)
"""Two rows, the first on top; occupancies 1.0, 0.61, 0.196 | 0.004, 0.0, 0.655."""


def write_map(folder: Path, shades: np.ndarray, yaml_text: str = YAML, name: str = "m.png") -> Path:
    Image.fromarray(shades).save(folder / name)
    file = folder / "m.yaml"
    file.write_text(yaml_text.format(image=name))
    return file


def test_image_row_zero_is_the_top_of_the_map(tmp_path: Path) -> None:
    world = load_map(write_map(tmp_path, SHADES))
    assert world.cells.tolist() == [[0, 0, 100], [100, -1, -1]]
    assert world.geometry == GridGeometry(2, 3, 0.05, (-1.5, 2.0, 0.25))


def test_scale_mode_grades_what_lies_between_the_thresholds(tmp_path: Path) -> None:
    world = load_map(write_map(tmp_path, SHADES, YAML + "mode: scale\n"))
    between = int(1 + 98 * ((155 / 255 - 0.196) / (0.65 - 0.196)))
    assert world.cells.tolist() == [[0, 0, 100], [100, between, 1]]


def test_raw_mode_takes_the_grey_level_itself(tmp_path: Path) -> None:
    world = load_map(write_map(tmp_path, SHADES, YAML + "mode: raw\n"))
    assert world.cells.tolist() == [[-1, -1, 88], [0, 100, -1]]


def test_negate_makes_white_the_wall(tmp_path: Path) -> None:
    world = load_map(write_map(tmp_path, SHADES, YAML.replace("negate: 0", "negate: 1")))
    assert world.cells.tolist() == [[100, 100, -1], [0, -1, 100]]


def test_mode_and_negate_may_be_left_out(tmp_path: Path) -> None:
    world = load_map(write_map(tmp_path, SHADES, YAML.replace("negate: 0\n", "")))
    assert world.cells[1, 0] == 100


@pytest.mark.parametrize("threshold", ["0.25", "0.197"])
def test_a_higher_free_threshold_turns_shade_205_into_free(tmp_path: Path, threshold: str) -> None:
    world = load_map(write_map(tmp_path, SHADES, YAML.replace("0.196", threshold)))
    assert world.cells[1, 2] == 0


@pytest.mark.parametrize("name", ["m.png", "m.pgm", "m.bmp"])
def test_formats_of_images_give_the_same_map(tmp_path: Path, name: str) -> None:
    world = load_map(write_map(tmp_path, SHADES, name=name))
    assert world.cells.tolist() == [[0, 0, 100], [100, -1, -1]]


def test_plain_pgm_with_a_comment_is_read(tmp_path: Path) -> None:
    file = write_map(tmp_path, SHADES, name="m.pgm")
    (tmp_path / "m.pgm").write_text("P2\n# drawn by hand\n3 2\n255\n0 100 205\n254 255 88\n")
    assert load_map(file).cells.tolist() == [[0, 0, 100], [100, -1, -1]]


@pytest.mark.parametrize("name", ["m.png", "m.pgm"])
def test_images_of_16_bits_have_the_same_shades(tmp_path: Path, name: str) -> None:
    world = load_map(write_map(tmp_path, SHADES.astype(np.uint16) * 257, name=name))
    assert world.cells.tolist() == [[0, 0, 100], [100, -1, -1]]


def test_black_and_white_image_has_no_unknown(tmp_path: Path) -> None:
    file = write_map(tmp_path, SHADES)
    Image.fromarray(SHADES > 150).save(tmp_path / "m.png")
    assert load_map(file).cells.tolist() == [[0, 0, 100], [100, 100, 0]]


def test_colours_are_averaged(tmp_path: Path) -> None:
    colours = np.array([[[255, 0, 0], [255, 255, 255]]], np.uint8)
    assert load_map(write_map(tmp_path, colours)).cells.tolist() == [[100, 0]]


def test_palette_counts_by_its_colours(tmp_path: Path) -> None:
    file = write_map(tmp_path, SHADES)
    Image.fromarray(SHADES).convert("RGB").quantize(6).save(tmp_path / "m.png")
    assert load_map(file).cells.tolist() == [[0, 0, 100], [100, -1, -1]]


def test_transparency_means_unknown_in_scale_mode_only(tmp_path: Path) -> None:
    pixels = [(150, 255), (150, 10), (0, 10), (255, 0), (0, 255)]
    with_alpha = np.array([[[grey, grey, grey, alpha] for grey, alpha in pixels]], np.uint8)
    scaled = load_map(write_map(tmp_path, with_alpha, YAML + "mode: scale\n"))
    assert scaled.cells[0, 0] > 0
    assert scaled.cells[0, 1:].tolist() == [-1, -1, -1, 100]
    assert load_map(write_map(tmp_path, with_alpha)).cells.tolist() == [[-1, -1, 100, 0, 100]]


def test_numbers_may_be_written_as_yaml_takes_for_text(tmp_path: Path) -> None:
    world = load_map(write_map(tmp_path, SHADES, YAML.replace("0.05", "5e-2")))
    assert world.geometry.resolution == 0.05


def test_image_is_looked_for_beside_the_yaml_or_at_its_absolute_path(tmp_path: Path) -> None:
    elsewhere = tmp_path / "images"
    elsewhere.mkdir()
    Image.fromarray(SHADES).save(elsewhere / "m.png")
    for name in ("images/m.png", str(elsewhere / "m.png")):
        file = tmp_path / "m.yaml"
        file.write_text(YAML.format(image=name))
        assert load_map(file).geometry.shape == (2, 3)


def test_image_that_was_packed_as_png_is_found_by_its_old_name(tmp_path: Path) -> None:
    file = write_map(tmp_path, SHADES, YAML.replace("{image}", "m.pgm"))
    assert load_map(file).geometry.shape == (2, 3)


REFUSED = {
    "no YAML": ("a: [1", "not readable as YAML"),
    "no mapping": ("- 1\n- 2\n", "neither the YAML of a map nor a Wean Hall map"),
    "empty": ("", "neither the YAML of a map"),
    "image missing": (YAML.replace("image: {image}", ""), "'image' is missing"),
    "resolution missing": (YAML.replace("resolution: 0.05", ""), "'resolution' is missing"),
    "origin missing": (YAML.replace("origin", "start"), "'origin' is missing"),
    "threshold missing": (YAML.replace("free_thresh", "free"), "'free_thresh' is missing"),
    "resolution no number": (YAML.replace("0.05", "fine"), "resolution must be a finite number"),
    "resolution NaN": (YAML.replace("0.05", ".nan"), "resolution must be a finite number"),
    "resolution a switch": (YAML.replace("0.05", "true"), "resolution must be a finite number"),
    "resolution zero": (YAML.replace("0.05", "0.0"), "resolution must be positive"),
    "resolution negative": (YAML.replace("0.05", "-0.05"), "resolution must be positive"),
    "origin too short": (YAML.replace(", 0.25]", "]"), "origin must be a list"),
    "origin no list": (YAML.replace("[-1.5, 2.0, 0.25]", "7"), "origin must be a list"),
    "origin infinite": (YAML.replace("-1.5", ".inf"), "origin must be a finite number"),
    "thresholds swapped": (YAML.replace("0.196", "0.7"), "thresholds must satisfy"),
    "threshold above one": (YAML.replace("0.65", "65"), "thresholds must satisfy"),
    "negate no switch": (YAML.replace("negate: 0", "negate: often"), "negate must be 0 or 1"),
    "unknown mode": (YAML + "mode: fuzzy\n", "mode must be one of trinary, scale, raw"),
    "image no name": (YAML.replace("{image}", "[m.png]"), "image must be a file name"),
    "image not there": (
        YAML.replace("{image}", "other.png"),
        "other.png: the map's image",
    ),
}


@pytest.mark.parametrize(("text", "reason"), REFUSED.values(), ids=REFUSED.keys())
def test_wrong_yaml_is_refused_with_its_reason(tmp_path: Path, text: str, reason: str) -> None:
    file = write_map(tmp_path, SHADES, text)
    with pytest.raises(MapFileError, match=reason) as refusal:
        load_map(file)
    assert str(tmp_path) in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MapFileError, match=r"no\.yaml: the map file does not exist"):
        load_map(tmp_path / "no.yaml")


def test_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MapFileError, match="cannot be read"):
        load_map(tmp_path)


@pytest.mark.parametrize("name", ["m.png", "m.pgm"])
def test_truncated_image_is_refused(tmp_path: Path, name: str) -> None:
    file = write_map(tmp_path, np.tile(SHADES, (20, 20)), name=name)
    whole = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(whole[: len(whole) // 2])
    with pytest.raises(MapFileError, match="image"):
        load_map(file)


def test_image_that_is_none_is_refused(tmp_path: Path) -> None:
    file = write_map(tmp_path, SHADES)
    (tmp_path / "m.png").write_text("a picture of a map")
    with pytest.raises(MapFileError, match="not a PGM, PNG or BMP image"):
        load_map(file)


def test_image_too_large_for_memory_is_refused_before_it_is_read(tmp_path: Path) -> None:
    file = write_map(tmp_path, SHADES, name="m.pgm")
    (tmp_path / "m.pgm").write_bytes(b"P5\n100000 100000\n255\n")
    with pytest.raises(MapFileError, match="too large"):
        load_map(file)


ROOM = draw(
    """
    ####
    #.?#
    ####
    """,
    resolution=0.07,
    origin=(-3.3, 1.0 / 3.0, -2.0),
)


def test_saved_map_loads_back_exactly(tmp_path: Path) -> None:
    save_map(ROOM, tmp_path / "room.yaml")
    again = load_map(tmp_path / "room.yaml")
    assert again.geometry == ROOM.geometry
    assert (again.cells == ROOM.cells).all()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["room.pgm", "room.yaml"]


def test_probabilities_load_back_exactly_too(tmp_path: Path) -> None:
    cells = np.arange(-1, 101, dtype=np.int8).reshape(6, 17)
    save_map(OccupancyMap(GridGeometry(6, 17, 0.1), cells), tmp_path / "m.yaml")
    assert (load_map(tmp_path / "m.yaml").cells == cells).all()


def test_saving_replaces_the_old_map(tmp_path: Path) -> None:
    save_map(draw("....#"), tmp_path / "m.yaml")
    save_map(ROOM, tmp_path / "m.yaml")
    assert load_map(tmp_path / "m.yaml").geometry.shape == (3, 4)


@pytest.mark.parametrize("renames", [0, 1, 2])
def test_power_cut_while_saving_leaves_the_old_or_the_new_map(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, renames: int
) -> None:
    old = draw("....#")
    save_map(old, tmp_path / "m.yaml")
    _cut_power_after(renames, monkeypatch)
    if renames < 2:
        with pytest.raises(PowerCutError):
            save_map(ROOM, tmp_path / "m.yaml")
    else:
        save_map(ROOM, tmp_path / "m.yaml")
    found = load_map(tmp_path / "m.yaml")
    assert map_digest(found) == map_digest(ROOM if renames else old)


class PowerCutError(Exception):
    pass


def test_power_cut_during_the_first_save_leaves_the_map_or_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _cut_power_after(1, monkeypatch)
    with pytest.raises(PowerCutError):
        save_map(ROOM, tmp_path / "m.yaml")
    assert np.array_equal(load_map(tmp_path / "m.yaml").cells, ROOM.cells)


@pytest.mark.parametrize("renames", [0, 1, 2])
def test_second_power_cut_in_a_row_leaves_a_whole_map(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, renames: int
) -> None:
    """The first leaves a new YAML beside an old image, and the new image under another name."""
    save_map(draw("....#"), tmp_path / "m.yaml")
    for world, cut in ((ROOM, 1), (draw("#####"), renames)):
        with monkeypatch.context() as patch:
            _cut_power_after(cut, patch)
            with pytest.raises(PowerCutError):
                save_map(world, tmp_path / "m.yaml")
    expected = ROOM if renames < 2 else draw("#####")
    assert map_digest(load_map(tmp_path / "m.yaml")) == map_digest(expected)


def _cut_power_after(renames: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rename = Path.replace
    done: list[Path] = []

    def rename_or_die(self: Path, target: Path) -> Path:
        if len(done) >= renames:
            raise PowerCutError
        done.append(target)
        return rename(self, target)

    monkeypatch.setattr(Path, "replace", rename_or_die)


def test_image_edited_after_saving_is_used_as_it_is(tmp_path: Path) -> None:
    save_map(ROOM, tmp_path / "m.yaml")
    with Image.open(tmp_path / "m.pgm") as image:
        edited = np.array(image)
    edited[1, 2] = 254
    Image.fromarray(edited).save(tmp_path / "m.pgm")
    assert load_map(tmp_path / "m.yaml").cells[1, 2] == 0


def test_saving_into_a_missing_folder_says_so(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        save_map(ROOM, tmp_path / "nowhere" / "m.yaml")


def test_digest_tells_maps_apart_by_cells_and_place() -> None:
    moved = OccupancyMap(GridGeometry(3, 4, 0.07, (-3.3, 0.0, -2.0)), ROOM.cells)
    changed = ROOM.cells.copy()
    changed[1, 1] = 100
    digests = {map_digest(world) for world in (ROOM, moved, OccupancyMap(ROOM.geometry, changed))}
    assert len(digests) == 3
    assert all(len(digest) == 16 for digest in digests)


WEAN = """robot_specifications->global_mapsize_x                 30
robot_specifications->resolution                       10
global_map[0]: 2 3
-1.0 1.0 0.0
0.9 0.5 0.1
"""


def test_wean_map_runs_along_x_first_and_says_how_free_a_cell_is(tmp_path: Path) -> None:
    (tmp_path / "wean.dat").write_text(WEAN)
    world = load_map(tmp_path / "wean.dat")
    assert world.geometry == GridGeometry(3, 2, 0.1)
    assert world.cells.tolist() == [[-1, 10], [0, -1], [100, 90]]


def test_wean_map_may_be_packed_under_any_name(tmp_path: Path) -> None:
    (tmp_path / "map").write_bytes(gzip.compress(WEAN.encode()))
    assert load_map(tmp_path / "map").geometry.shape == (3, 2)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (WEAN.replace("0.9 ", ""), "5 cells instead of 2 x 3"),
        (WEAN + "1.0\n", "7 cells instead of 2 x 3"),
        (WEAN.replace("0.9", "free"), "not numbers"),
        (WEAN.replace("0.9", "nan"), "not probabilities"),
        (WEAN.replace("0.9", "1.5"), "not probabilities"),
        (WEAN.replace("0.9", "-inf"), "not probabilities"),
        (WEAN.replace("global_map[0]: 2 3", "global_map[0]:"), "lacks the map's size"),
        (WEAN.replace("robot_specifications->resolution", "#"), "lacks the map's size or res"),
        (WEAN.replace("       10\n", "       0\n"), "positive number of cm"),
        (WEAN.replace("       10\n", "       ten\n"), "positive number of cm"),
    ],
)
def test_wrong_wean_map_is_refused_with_its_reason(tmp_path: Path, text: str, reason: str) -> None:
    (tmp_path / "wean.dat").write_text(text)
    with pytest.raises(MapFileError, match=reason):
        load_map(tmp_path / "wean.dat")


@pytest.mark.parametrize("keep", [10, -8])
def test_damaged_gzip_is_refused(tmp_path: Path, keep: int) -> None:
    (tmp_path / "wean.dat.gz").write_bytes(gzip.compress(WEAN.encode())[:keep])
    with pytest.raises(MapFileError, match="damaged or cut off"):
        load_map(tmp_path / "wean.dat.gz")


def test_file_named_gz_that_is_not_packed_is_refused(tmp_path: Path) -> None:
    (tmp_path / "wean.dat.gz").write_text(WEAN)
    with pytest.raises(MapFileError, match=r"named \.gz but is not gzip"):
        load_map(tmp_path / "wean.dat.gz")


def test_resolution_in_the_map_is_a_length(tmp_path: Path) -> None:
    (tmp_path / "wean.dat").write_text(WEAN.replace("       10\n", "       2.5\n"))
    assert math.isclose(load_map(tmp_path / "wean.dat").geometry.resolution, 0.025)


@pytest.mark.parametrize("path", ["", " "])
def test_an_empty_path_is_no_map(path: str) -> None:
    with pytest.raises(MapFileError, match="no map file is named"):
        load_map(path)


def test_a_folder_is_no_map_and_told_without_a_number(tmp_path: Path) -> None:
    with pytest.raises(MapFileError, match=r"cannot be read \(Is a directory\)"):
        load_map(tmp_path)
