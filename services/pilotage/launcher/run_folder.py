"""The folder of a run: its effective deployment, and what must survive a crash of a service."""

import fcntl
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import yaml

from pilotage.bus.deployment import ConfigError, Deployment
from pilotage.launcher.effective import plain

LOCK = "lock"


def state_folder() -> Path:
    """Return where Pilotage keeps what is not configuration, by the XDG rules."""
    if own := os.environ.get("PILOTAGE_STATE"):
        return Path(own)
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else Path.home() / ".local" / "state") / "pilotage"


@contextmanager
def run_folder(state: Path, keep: int) -> Iterator[Path]:
    """Create the folder of this run under `state`, locked while it lasts; old ones go.

    The newest `keep` stay, and any whose run still lasts. ConfigError: it cannot be written.
    """
    runs = state / "runs"
    folder = runs / f"{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}"
    try:
        folder.mkdir(parents=True, mode=0o700, exist_ok=True)
        lock = (folder / LOCK).open("w", encoding="utf-8")
    except OSError as error:
        raise ConfigError(
            f"cannot write to {runs} (PILOTAGE_STATE chooses another): {error.strerror}"
        ) from error
    with lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        prune(runs, keep)
        yield folder


def prune(runs: Path, keep: int) -> None:
    """Remove all but the newest `keep` folders, never one that is locked."""
    folders = sorted(path for path in runs.iterdir() if path.is_dir())
    for folder in folders[:-keep]:
        if not _is_locked(folder):
            shutil.rmtree(folder, ignore_errors=True)


def write_deployment(deployment: Deployment, folder: Path) -> Path:
    """Write the effective deployment into the folder of its run; return the file.

    Only its owner may read it: it may hold the router's password and the gateway's tokens.
    """
    path = folder / "deployment.yaml"
    said = {key: value for key, value in deployment.model_dump().items() if value is not None}
    text = yaml.safe_dump(plain(said), sort_keys=False)
    path.touch(mode=0o600)
    path.write_text(text, encoding="utf-8")
    return path


def _is_locked(folder: Path) -> bool:
    try:
        with (folder / LOCK).open("r", encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False
