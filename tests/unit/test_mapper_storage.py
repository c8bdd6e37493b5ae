"""What a mapper keeps on disk: exact, small to renew, and never half."""

import os
from pathlib import Path

import numpy as np
import pytest

from pilotage.mapper.storage import (
    CHUNK_FOLDER,
    MOST_CHUNKS,
    STATE_FILE,
    Arrays,
    State,
    StateFolder,
)

ROWS = 500
RNG = np.random.default_rng(3)
SCANS = RNG.random((ROWS, 361)).astype(np.float32)
POSES = RNG.random((ROWS, 3))


@pytest.fixture
def warned() -> list[str]:
    return []


@pytest.fixture
def folder(tmp_path: Path, warned: list[str]) -> StateFolder:
    return StateFolder(tmp_path, warned.append)


def state(rows: int, **facts: object) -> State:
    arrays: Arrays = {
        "scans": SCANS[:rows],
        "poses": POSES[:rows],
        "one": np.array(7),
        "none": POSES[:0],
    }
    return State({"mode": "mapping"} | facts, arrays)


def loaded(path: Path) -> State:
    troubles: list[str] = []
    found = StateFolder(path, troubles.append).load()
    assert troubles == []
    assert found is not None
    return found


def chunks(path: Path) -> dict[str, int]:
    return {file.name: file.stat().st_mtime_ns for file in (path / CHUNK_FOLDER).iterdir()}


def test_a_state_comes_back_as_it_was(folder: StateFolder, tmp_path: Path) -> None:
    folder.save(state(300, since_ns=17, name="Hälle"))
    found = loaded(tmp_path)
    assert found.facts == {"mode": "mapping", "since_ns": 17, "name": "Hälle"}
    for name, array in state(300).arrays.items():
        assert found.arrays[name].dtype == array.dtype
        assert np.array_equal(found.arrays[name], array)


def test_only_the_new_rows_of_what_grew_are_written(folder: StateFolder, tmp_path: Path) -> None:
    folder.save(state(300))
    before = chunks(tmp_path)
    folder.save(state(310))
    after = chunks(tmp_path)
    assert before.items() <= after.items()
    (new,) = set(after) - set(before)
    assert (tmp_path / CHUNK_FOLDER / new).stat().st_size == 10 * 361 * 4
    assert np.array_equal(loaded(tmp_path).arrays["scans"], SCANS[:310])


def test_what_moved_is_written_anew_from_there(folder: StateFolder, tmp_path: Path) -> None:
    folder.save(state(200))
    folder.save(state(300))
    kept = set(chunks(tmp_path))
    moved = SCANS[:300].copy()
    moved[250:] += 1.0
    folder.save(State({}, {"scans": moved}))
    assert np.array_equal(loaded(tmp_path).arrays["scans"], moved)
    assert len(kept & set(chunks(tmp_path))) == 1


def test_a_run_after_a_crash_goes_on_adding(folder: StateFolder, tmp_path: Path) -> None:
    folder.save(state(300))
    before = chunks(tmp_path)
    second = StateFolder(tmp_path, print)
    assert second.load() is not None
    second.save(state(310))
    assert before.items() <= chunks(tmp_path).items()


def test_files_stay_few_however_long_it_runs(folder: StateFolder, tmp_path: Path) -> None:
    for rows in range(60, 300, 2):
        folder.save(state(rows))
        assert len(chunks(tmp_path)) <= MOST_CHUNKS + 1
    assert np.array_equal(loaded(tmp_path).arrays["scans"], SCANS[:298])


def test_an_array_that_shrank_leaves_nothing_behind(folder: StateFolder, tmp_path: Path) -> None:
    folder.save(state(400))
    folder.save(state(100))
    assert np.array_equal(loaded(tmp_path).arrays["scans"], SCANS[:100])
    assert len(chunks(tmp_path)) == 1
    folder.save(State({}, {}))
    assert chunks(tmp_path) == {}
    assert loaded(tmp_path).arrays == {}


def test_what_is_forgotten_does_not_come_back(folder: StateFolder, tmp_path: Path) -> None:
    folder.save(state(300))
    folder.forget()
    assert folder.load() is None
    assert chunks(tmp_path) == {}


def test_nothing_is_found_where_nothing_was_kept(folder: StateFolder, warned: list[str]) -> None:
    assert folder.load() is None
    folder.forget()
    assert warned == []


def test_without_a_folder_nothing_is_kept(warned: list[str]) -> None:
    nowhere = StateFolder(None, warned.append)
    nowhere.save(state(10))
    nowhere.forget()
    assert nowhere.load() is None
    assert warned == []


@pytest.mark.parametrize("which", [STATE_FILE, CHUNK_FOLDER])
def test_damage_is_told_and_nothing_is_used(
    folder: StateFolder, tmp_path: Path, warned: list[str], which: str
) -> None:
    folder.save(state(300))
    file = tmp_path / which
    file = file if file.is_file() else next(file.iterdir())
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    file.write_bytes(content)
    assert folder.load() is None
    assert len(warned) == 1
    assert "damaged" in warned[0]


def test_a_chunk_that_is_missing_is_told(
    folder: StateFolder, tmp_path: Path, warned: list[str]
) -> None:
    folder.save(state(300))
    for name in chunks(tmp_path):
        (tmp_path / CHUNK_FOLDER / name).unlink()
    assert folder.load() is None
    assert "is ignored" in warned[0]


@pytest.mark.parametrize("content", [b"", b"x", b"\0" * 5000])
def test_any_content_whatsoever_is_no_state(
    folder: StateFolder, tmp_path: Path, warned: list[str], content: bytes
) -> None:
    (tmp_path / STATE_FILE).write_bytes(content)
    assert folder.load() is None
    assert len(warned) == 1


def full(*_: object) -> None:
    raise OSError(28, os.strerror(28))


def test_a_full_disk_leaves_the_old_state(
    folder: StateFolder, tmp_path: Path, warned: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder.save(state(200))
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        folder.save(state(300))
    assert warned == ["not kept: No space left on device"]
    assert np.array_equal(loaded(tmp_path).arrays["scans"], SCANS[:200])
    folder.save(state(310))
    assert np.array_equal(loaded(tmp_path).arrays["scans"], SCANS[:310])


def test_a_crash_between_chunks_and_state_leaves_the_old_state(
    folder: StateFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder.save(state(200))

    class Killed(BaseException):
        pass

    def killed(self: Path, target: Path) -> None:
        if target.name == STATE_FILE:
            raise Killed
        os.replace(self, target)  # noqa: PTH105 - Path.replace is what is patched

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", killed)
        with pytest.raises(Killed):
            folder.save(state(300))
    assert np.array_equal(loaded(tmp_path).arrays["scans"], SCANS[:200])
    fresh = StateFolder(tmp_path, print)
    fresh.load()
    fresh.save(state(310))
    assert np.array_equal(loaded(tmp_path).arrays["scans"], SCANS[:310])
    assert len(chunks(tmp_path)) == 2
