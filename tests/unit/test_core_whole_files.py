from pathlib import Path

import pytest

from pilotage.core.whole_files import temporary_of, write_whole


def test_files_are_written_and_nothing_is_left_over(tmp_path: Path) -> None:
    write_whole(tmp_path, {"a": b"1", "b": b"2"})
    write_whole(tmp_path, {"a": b"3"})
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == {"a": b"3", "b": b"2"}


def test_old_files_stay_where_a_new_one_cannot_be_written(tmp_path: Path) -> None:
    write_whole(tmp_path, {"a": b"old", "b": b"old"})
    temporary_of(tmp_path / "b").mkdir()
    with pytest.raises(IsADirectoryError):
        write_whole(tmp_path, {"a": b"new", "b": b"new"})
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes() == b"old"


def test_missing_folder_is_told(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        write_whole(tmp_path / "no", {"a": b"1"})
