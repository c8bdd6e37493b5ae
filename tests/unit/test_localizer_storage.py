"""What a localizer keeps on disk."""

from pathlib import Path

import numpy as np
import pytest

from pilotage.localizer.estimate import Memory
from pilotage.localizer.storage import MEMORY_FILE, load_memory, save_memory

MEMORY = Memory(
    poses=np.array([[1.0, 2.0, 0.5], [-3.0, 0.0, -3.1]]),
    weights=np.array([0.7, 0.2]),
    odom_from_base=np.array([4.0, 5.0, 1.0]),
    stamp_ns=1_700_000_000_123_456_789,
    was_localized=True,
)


def test_memory_comes_back_as_it_was_kept(tmp_path: Path) -> None:
    save_memory(tmp_path, "abcd", MEMORY)
    back = load_memory(tmp_path, "abcd")
    assert back is not None
    assert np.array_equal(back.poses, MEMORY.poses)
    assert np.array_equal(back.weights, MEMORY.weights)
    assert np.array_equal(back.odom_from_base, MEMORY.odom_from_base)
    assert (back.stamp_ns, back.was_localized) == (MEMORY.stamp_ns, True)


def test_the_newest_memory_replaces_the_last_and_leaves_nothing_else(tmp_path: Path) -> None:
    save_memory(tmp_path, "abcd", MEMORY)
    save_memory(tmp_path, "efgh", MEMORY)
    assert load_memory(tmp_path, "abcd") is None
    assert load_memory(tmp_path, "efgh") is not None
    assert [file.name for file in tmp_path.iterdir()] == [MEMORY_FILE]


def test_memory_of_another_map_is_none(tmp_path: Path) -> None:
    save_memory(tmp_path, "abcd", MEMORY)
    assert load_memory(tmp_path, "efgh") is None


def test_without_a_file_there_is_no_memory(tmp_path: Path) -> None:
    assert load_memory(tmp_path, "abcd") is None
    assert load_memory(tmp_path / "missing", "abcd") is None


def test_a_folder_in_place_of_the_file_is_no_memory(tmp_path: Path) -> None:
    (tmp_path / MEMORY_FILE).mkdir()
    assert load_memory(tmp_path, "abcd") is None


@pytest.mark.parametrize("content", [b"", b"x", b"x" * 32, b"PK\x03\x04" * 50])
def test_a_foreign_file_is_no_memory(tmp_path: Path, content: bytes) -> None:
    (tmp_path / MEMORY_FILE).write_bytes(content)
    assert load_memory(tmp_path, "abcd") is None


def test_a_file_with_any_byte_changed_is_no_memory(tmp_path: Path) -> None:
    save_memory(tmp_path, "abcd", MEMORY)
    whole = (tmp_path / MEMORY_FILE).read_bytes()
    for place in range(0, len(whole), 5):
        damaged = bytearray(whole)
        damaged[place] ^= 0x5A
        (tmp_path / MEMORY_FILE).write_bytes(damaged)
        assert load_memory(tmp_path, "abcd") is None


def test_a_file_cut_off_anywhere_is_no_memory(tmp_path: Path) -> None:
    save_memory(tmp_path, "abcd", MEMORY)
    whole = (tmp_path / MEMORY_FILE).read_bytes()
    for length in range(0, len(whole), 11):
        (tmp_path / MEMORY_FILE).write_bytes(whole[:length])
        assert load_memory(tmp_path, "abcd") is None


def test_memory_cannot_be_kept_in_a_folder_that_is_gone(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="missing"):
        save_memory(tmp_path / "missing", "abcd", MEMORY)
