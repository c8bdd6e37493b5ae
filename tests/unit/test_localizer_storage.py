"""What a localizer keeps on disk."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pilotage.localizer import storage
from pilotage.localizer.estimate import Memory
from pilotage.localizer.pose_grid import PoseGridParams
from pilotage.localizer.range_model import RangeTable
from pilotage.localizer.storage import (
    CHOICE_FILE,
    MEMORY_FILE,
    Choice,
    RunFolder,
    SightKey,
    Snapshot,
)
from pilotage.localizer.visibility import VisibilityParams

MEMORY = Memory(
    poses=np.array([[1.0, 2.0, 0.5], [-3.0, 0.0, -3.1]]),
    weights=np.array([0.7, 0.2]),
    odom_from_base=np.array([4.0, 5.0, 1.0]),
    stamp_ns=1_700_000_000_123_456_789,
    was_localized=True,
)
SNAPSHOT = Snapshot("abcd", 4711, MEMORY)
CHOICE = Choice("{}", "mcl", "m1", 0.5, "maps/cellar.yaml", "abcd")
KEY = SightKey("abcd", PoseGridParams(), VisibilityParams())
TABLE = RangeTable(np.arange(24, dtype=np.uint8).reshape(2, 3, 4), KEY.visibility.reach)


class Desk:
    """A run folder and what it warned of."""

    def __init__(self, folder: Path | None) -> None:
        self.said: list[str] = []
        self.kept = RunFolder(folder, self.said.append)


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


def test_a_snapshot_comes_back_as_it_was_kept(desk: Desk) -> None:
    desk.kept.save_snapshot(SNAPSHOT)
    back = desk.kept.load_snapshot("abcd")
    assert back is not None
    assert (back.map_id, back.odometry_seq) == ("abcd", 4711)
    assert np.array_equal(back.memory.poses, MEMORY.poses)
    assert np.array_equal(back.memory.weights, MEMORY.weights)
    assert np.array_equal(back.memory.odom_from_base, MEMORY.odom_from_base)
    assert (back.memory.stamp_ns, back.memory.was_localized) == (MEMORY.stamp_ns, True)
    assert desk.said == []


def test_the_newest_snapshot_replaces_the_last_and_leaves_nothing_else(
    desk: Desk, tmp_path: Path
) -> None:
    desk.kept.save_snapshot(SNAPSHOT)
    desk.kept.save_snapshot(replace(SNAPSHOT, map_id="efgh"))
    assert desk.kept.load_snapshot("abcd") is None
    assert desk.kept.load_snapshot("efgh") is not None
    assert [file.name for file in tmp_path.iterdir()] == [MEMORY_FILE]


def test_without_a_file_there_is_no_snapshot_and_nothing_to_say(tmp_path: Path) -> None:
    for folder in (tmp_path, tmp_path / "missing", None):
        desk = Desk(folder)
        assert desk.kept.load_snapshot("abcd") is None
        assert desk.kept.load_choice("{}") is None
        assert desk.kept.load_sight(KEY) is None
        assert desk.said == []


def test_without_a_folder_nothing_is_kept() -> None:
    nowhere = Desk(None)
    nowhere.kept.save_snapshot(SNAPSHOT)
    nowhere.kept.forget_snapshot()
    assert nowhere.said == []


def test_a_snapshot_that_was_forgotten_is_none(desk: Desk) -> None:
    desk.kept.save_snapshot(SNAPSHOT)
    desk.kept.forget_snapshot()
    desk.kept.forget_snapshot()
    assert desk.kept.load_snapshot("abcd") is None
    assert desk.said == []


def test_a_folder_in_place_of_the_file_is_told_and_ignored(desk: Desk, tmp_path: Path) -> None:
    (tmp_path / MEMORY_FILE).mkdir()
    assert desk.kept.load_snapshot("abcd") is None
    assert desk.said == [f"{MEMORY_FILE} is ignored: Is a directory"]
    desk.kept.forget_snapshot()
    assert desk.said[-1].startswith("not forgotten: ")


@pytest.mark.parametrize("content", [b"", b"x", b"x" * 32, b"PK\x03\x04" * 50])
@pytest.mark.parametrize("name", [MEMORY_FILE, CHOICE_FILE])
def test_a_foreign_file_is_told_and_ignored(
    desk: Desk, tmp_path: Path, name: str, content: bytes
) -> None:
    (tmp_path / name).write_bytes(content)
    assert desk.kept.load_snapshot("abcd") is None
    assert desk.kept.load_choice("{}") is None
    assert desk.said == [f"{name} is ignored: it is damaged"]


def cut_off(whole: bytes, place: int) -> bytes:
    return whole[:place]


def changed(whole: bytes, place: int) -> bytes:
    return whole[:place] + bytes([whole[place] ^ 0x5A]) + whole[place + 1 :]


@pytest.mark.parametrize("damage", [cut_off, changed])
def test_a_file_damaged_anywhere_is_told_and_ignored(
    desk: Desk, tmp_path: Path, damage: Callable[[bytes, int], bytes]
) -> None:
    desk.kept.save_snapshot(SNAPSHOT)
    whole = (tmp_path / MEMORY_FILE).read_bytes()
    places = range(0, len(whole), 7)
    for place in places:
        (tmp_path / MEMORY_FILE).write_bytes(damage(whole, place))
        assert desk.kept.load_snapshot("abcd") is None
    assert len(desk.said) == len(places)


def test_a_whole_file_of_another_version_is_told_and_ignored(
    desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.kept._write(CHOICE_FILE, b'{"settings": "{}", "mode": 3}')
    assert desk.kept.load_choice("{}") is None
    monkeypatch.setattr(storage, "_packed", lambda _snapshot: b"no archive")
    desk.kept.save_snapshot(SNAPSHOT)
    assert desk.kept.load_snapshot("abcd") is None
    with (tmp_path / "other.npz").open("wb") as file:
        np.savez(file, map_id=np.array("abcd"))
    desk.kept._write(MEMORY_FILE, (tmp_path / "other.npz").read_bytes())
    assert desk.kept.load_snapshot("abcd") is None
    assert [line.split(" is ignored")[0] for line in desk.said] == [
        CHOICE_FILE,
        MEMORY_FILE,
        MEMORY_FILE,
    ]


def test_what_cannot_be_kept_is_told_and_no_error(tmp_path: Path) -> None:
    desk = Desk(tmp_path / "missing")
    desk.kept.save_snapshot(SNAPSHOT)
    assert len(desk.said) == 1
    assert desk.said[0].startswith("not kept: ")


def test_a_choice_comes_back_under_the_settings_it_was_made_under(desk: Desk) -> None:
    desk.kept.save_choice(CHOICE)
    assert desk.kept.load_choice("{}") == CHOICE
    assert desk.kept.load_choice('{"method": "markov"}') is None
    assert desk.said == []


def test_a_table_comes_back_for_its_map_and_parameters_only(desk: Desk) -> None:
    desk.kept.save_sight(KEY, TABLE)
    back = desk.kept.load_sight(KEY)
    assert back is not None
    assert np.array_equal(back.levels, TABLE.levels)
    assert back.range_max == TABLE.range_max
    assert desk.kept.load_sight(replace(KEY, map_id="efgh")) is None
    assert desk.kept.load_sight(replace(KEY, cells=PoseGridParams(headings=36))) is None
    assert desk.kept.load_sight(replace(KEY, visibility=VisibilityParams(reach=8.0))) is None


def test_a_damaged_table_is_told_and_made_anew(desk: Desk, tmp_path: Path) -> None:
    desk.kept.save_sight(KEY, TABLE)
    (file,) = tmp_path.iterdir()
    file.write_bytes(file.read_bytes()[:-1])
    assert desk.kept.load_sight(KEY) is None
    assert desk.said == [f"{file.name} is ignored: it is damaged"]
