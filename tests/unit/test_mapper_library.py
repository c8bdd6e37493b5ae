"""The map library on disk: whole maps, clear refusals, and the old map stays."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from drawing import draw
from pilotage.core.grid import OccupancyMap
from pilotage.core.map_files import load_map, map_digest, map_documents
from pilotage.mapper.map_library import LibraryError, MapLibrary

HALL = draw("####\n#..#\n#..#\n####", 0.1, (1.0, -2.0, 0.5))
OTHER = draw("#####\n#.?.#\n#####", 0.05)


def files_of(world: OccupancyMap) -> dict[str, bytes]:
    return {**map_documents(world, "map.yaml"), "trajectory.tum": b"1 0 0 0 0 0 0 1\n"}


@pytest.fixture
def library(tmp_path: Path) -> MapLibrary:
    made = MapLibrary(tmp_path / "maps")
    made.save("hall", files_of(HALL), saved_ns=17)
    return made


def test_a_map_comes_back_as_it_was_saved(library: MapLibrary) -> None:
    assert np.array_equal(library.load("hall").cells, HALL.cells)
    about = library.about("hall")
    assert (about.name, about.map_id, about.saved_ns) == ("hall", map_digest(HALL), 17)
    assert (about.rows, about.cols, about.resolution) == (4, 4, 0.1)
    assert about.files == ("map.yaml", "map.pgm", "trajectory.tum")
    assert library.read("hall", "trajectory.tum") == b"1 0 0 0 0 0 0 1\n"


def test_other_programs_find_an_ordinary_folder(library: MapLibrary, tmp_path: Path) -> None:
    assert map_digest(load_map(tmp_path / "maps" / "hall" / "map.yaml")) == map_digest(HALL)
    assert library.has("hall")


def test_saving_again_replaces_the_map_and_leaves_nothing_behind(
    library: MapLibrary, tmp_path: Path
) -> None:
    library.save("hall", files_of(OTHER), saved_ns=18)
    assert library.about("hall").map_id == map_digest(OTHER)
    assert len(list((tmp_path / "maps" / ".versions").iterdir())) == 1
    assert sorted(path.name for path in (tmp_path / "maps").iterdir()) == [".versions", "hall"]


def test_all_maps_are_listed_by_name(library: MapLibrary) -> None:
    library.save("Attic", files_of(OTHER), saved_ns=18)
    assert [about.name for about in library.all()] == ["Attic", "hall"]


def test_a_deleted_map_is_gone_with_its_files(library: MapLibrary, tmp_path: Path) -> None:
    library.delete("hall")
    assert library.all() == []
    assert list((tmp_path / "maps" / ".versions").iterdir()) == []
    with pytest.raises(LibraryError, match="has no map 'hall'; it has none yet"):
        library.load("hall")


@pytest.mark.parametrize(
    "name", ["", ".", "..", "../x", "a/b", ".hidden", "a b", "ä", "a" * 65, "a\n", "x\0y", "-a"]
)
def test_a_name_that_would_leave_the_library_is_refused(library: MapLibrary, name: str) -> None:
    for use in (library.load, library.delete, library.about):
        with pytest.raises(LibraryError, match="cannot name a map"):
            use(name)
    with pytest.raises(LibraryError, match="cannot name a map"):
        library.save(name, files_of(HALL), saved_ns=1)
    assert not library.has(name)


def test_without_a_folder_there_is_no_library() -> None:
    nowhere = MapLibrary(None)
    assert nowhere.all() == []
    with pytest.raises(LibraryError, match="set maps_dir"):
        nowhere.save("hall", files_of(HALL), saved_ns=1)


def test_files_that_are_no_map_are_refused_and_the_old_map_stays(library: MapLibrary) -> None:
    good = files_of(OTHER)
    bad: dict[str, tuple[dict[str, bytes], str]] = {
        "yaml": ({"map.pgm": b""}, "needs its map.yaml"),
        "image": ({"map.yaml": good["map.yaml"]}, "did not come along"),
        "elsewhere": (good | {"../evil": b"x"}, "cannot be a file of a map"),
        "own": (good | {"about.json": b"{}"}, "cannot be a file of a map"),
        "cut": (good | {"map.pgm": good["map.pgm"][:-3]}, "is no map"),
        "text": (good | {"map.yaml": b"hello"}, "neither the YAML of a map"),
        "walls": (files_of(draw("##\n##", 0.1)), "no free cell"),
    }
    for files, reason in bad.values():
        with pytest.raises(LibraryError, match=reason):
            library.save("hall", files, saved_ns=2)
    assert library.about("hall").map_id == map_digest(HALL)
    assert len(library.all()) == 1


def test_an_image_of_another_folder_is_never_read(library: MapLibrary, tmp_path: Path) -> None:
    (tmp_path / "secret.pgm").write_bytes(files_of(OTHER)["map.pgm"])
    yaml = files_of(OTHER)["map.yaml"].replace(b"map.pgm", b"../../../secret.pgm")
    with pytest.raises(LibraryError, match="did not come along"):
        library.save("stolen", {"map.yaml": yaml, "map.pgm": b""}, saved_ns=2)


@pytest.mark.parametrize("file", ["map.yaml", "map.pgm", "trajectory.tum"])
def test_a_file_that_changed_on_the_disk_is_told(
    library: MapLibrary, tmp_path: Path, file: str
) -> None:
    found = (tmp_path / "maps" / "hall" / file).resolve()
    content = bytearray(found.read_bytes())
    content[-2] ^= 1
    found.write_bytes(content)
    with pytest.raises(LibraryError, match=f"the map 'hall' is damaged: {file}"):
        library.load("hall")


def test_damaged_facts_are_told_and_the_others_are_still_listed(
    library: MapLibrary, tmp_path: Path
) -> None:
    library.save("other", files_of(OTHER), saved_ns=3)
    (tmp_path / "maps" / "hall" / "about.json").write_text(json.dumps({"name": "hall"}))
    with pytest.raises(LibraryError, match=r"about\.json"):
        library.load("hall")
    assert [about.name for about in library.all()] == ["other"]


def test_a_folder_that_somebody_put_there_is_a_map_too(library: MapLibrary, tmp_path: Path) -> None:
    folder = tmp_path / "maps" / "copied"
    folder.mkdir()
    for name, content in files_of(OTHER).items():
        (folder / name).write_bytes(content)
    assert library.about("copied").map_id == map_digest(OTHER)
    for use in (library.delete, lambda name: library.save(name, files_of(HALL), 1)):
        with pytest.raises(LibraryError, match="not made by the library"):
            use("copied")


def test_a_file_that_a_map_does_not_have_is_named(library: MapLibrary) -> None:
    with pytest.raises(LibraryError, match=r"'hall' has no map.png; it has map.yaml, map.pgm"):
        library.read("hall", "map.png")


def full(*_: object) -> None:
    raise OSError(28, os.strerror(28))


@pytest.mark.parametrize("step", ["fsync", "symlink", "replace"])
def test_a_full_disk_leaves_the_old_map(
    library: MapLibrary, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(os, step, full)
        with pytest.raises(LibraryError, match=r"'hall' was not saved: No space left on device"):
            library.save("hall", files_of(OTHER), saved_ns=2)
    assert np.array_equal(library.load("hall").cells, HALL.cells)
    library.save("hall", files_of(OTHER), saved_ns=3)
    assert np.array_equal(library.load("hall").cells, OTHER.cells)
    assert len(list((tmp_path / "maps" / ".versions").iterdir())) == 1


def test_a_library_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(LibraryError, match="no map library at"):
        MapLibrary(tmp_path / "file" / "maps").save("hall", files_of(HALL), saved_ns=1)


def test_a_save_that_was_cut_short_is_cleared_by_the_next(
    library: MapLibrary, tmp_path: Path
) -> None:
    left = tmp_path / "maps" / ".versions" / "hall-cut"
    left.mkdir()
    (left / "map.yaml").write_bytes(b"half")
    (tmp_path / "maps" / ".hall.new").symlink_to(".versions/hall-cut")
    assert [about.name for about in library.all()] == ["hall"]
    library.save("hall", files_of(OTHER), saved_ns=2)
    assert not left.exists()
    assert library.about("hall").map_id == map_digest(OTHER)
