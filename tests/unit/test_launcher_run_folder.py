"""Run folders: one per run, a few kept, none of a run that lasts."""

import os
from pathlib import Path

import pytest

from pilotage.bus.deployment import ConfigError
from pilotage.launcher.run_folder import prune, run_folder, state_folder


def old_runs(state: Path, count: int) -> list[Path]:
    folders = [state / "runs" / f"2020010{day}-000000-1" for day in range(1, count + 1)]
    for folder in folders:
        folder.mkdir(parents=True)
        (folder / "lock").touch()
    return folders


def test_a_run_has_a_folder_of_its_own_that_others_cannot_read(tmp_path: Path) -> None:
    with run_folder(tmp_path, keep=5) as folder:
        assert folder.parent == tmp_path / "runs"
        assert folder.stat().st_mode & 0o077 == 0
    assert folder.is_dir()


def test_old_runs_go_and_the_newest_stay(tmp_path: Path) -> None:
    old = old_runs(tmp_path, 7)
    with run_folder(tmp_path, keep=5) as folder:
        assert sorted((tmp_path / "runs").iterdir()) == [*old[3:], folder]


def test_a_run_that_lasts_is_never_removed(tmp_path: Path) -> None:
    with run_folder(tmp_path, keep=1) as lasting:
        renamed = lasting.rename(tmp_path / "runs" / "00000000-000000-1")
        old_runs(tmp_path, 3)
        prune(tmp_path / "runs", keep=1)
        assert renamed.is_dir()
        assert len(list((tmp_path / "runs").iterdir())) == 2


def test_what_is_no_run_is_left_alone(tmp_path: Path) -> None:
    old_runs(tmp_path, 3)
    (tmp_path / "runs" / "note.txt").touch()
    prune(tmp_path / "runs", keep=1)
    assert (tmp_path / "runs" / "note.txt").exists()


def test_a_place_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "runs").touch()
    with (
        pytest.raises(ConfigError, match="PILOTAGE_STATE chooses another"),
        run_folder(tmp_path, keep=5),
    ):
        pass


def test_the_state_folder_follows_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PILOTAGE_STATE", "/a")
    monkeypatch.setenv("XDG_STATE_HOME", "/b")
    assert state_folder() == Path("/a")
    monkeypatch.delenv("PILOTAGE_STATE")
    assert state_folder() == Path("/b/pilotage")
    monkeypatch.delenv("XDG_STATE_HOME")
    assert state_folder() == Path(os.path.expanduser("~")) / ".local/state/pilotage"  # noqa: PTH111 - the other way to say it
