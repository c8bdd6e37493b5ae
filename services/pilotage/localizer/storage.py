"""What a localizer keeps on disk, so that a crash costs it no more than a second of its memory.

A file is the checksum of its content and then the content: one that was damaged, or written by
half when the power went, is told from a whole one before it is read.
"""

import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Literal

import numpy as np

from pilotage.localizer.estimate import Memory
from pilotage.localizer.pose_grid import PoseGridParams
from pilotage.localizer.range_model import RangeTable
from pilotage.localizer.visibility import VisibilityParams

MEMORY_FILE = "localizer.memory"
CHOICE_FILE = "localizer.choice"


class DamagedError(ValueError):
    """A file of the run folder cannot be used; the text says which and why."""


@dataclass(frozen=True)
class Snapshot:
    """A memory, the map it is of, and the number of the newest odometry then."""

    map_id: str
    odometry_seq: int
    memory: Memory


@dataclass(frozen=True)
class Choice:
    """What queries chose in place of the settings.

    `settings`: those it was chosen under; edited ones are newer and count instead. `map_file` is
    empty for the mapper's map; `served_id`: the map that the mapper served when it was chosen.
    """

    settings: str
    method: str
    algorithm: Literal["m1", "m2"]
    recovery_weight: float
    map_file: str = ""
    served_id: str = ""


@dataclass(frozen=True)
class SightKey:
    """What a map's table of optimistic ranges depends on."""

    map_id: str
    cells: PoseGridParams
    visibility: VisibilityParams


class RunFolder:
    """Keeps and finds a localizer's files. Faults are told to `warn`: they cost the memory only.

    Without a folder nothing is kept and nothing found.
    """

    def __init__(self, folder: Path | None, warn: Callable[[str], None]) -> None:
        self._folder = folder
        self._warn = warn

    def save_snapshot(self, snapshot: Snapshot) -> None:
        """Keep a snapshot in place of the last one."""
        self._write(MEMORY_FILE, _packed(snapshot))

    def load_snapshot(self, map_id: str) -> Snapshot | None:
        """Return the snapshot of this map, None if there is none."""
        try:
            content = self._read(MEMORY_FILE)
            snapshot = None if content is None else _unpacked(content)
        except DamagedError as error:
            self._warn(str(error))
            return None
        return snapshot if snapshot is not None and snapshot.map_id == map_id else None

    def forget_snapshot(self) -> None:
        """Keep no snapshot: what it says was taken back."""
        try:
            if self._folder is not None:
                (self._folder / MEMORY_FILE).unlink(missing_ok=True)
        except OSError as error:
            self._warn(f"not forgotten: {error}")

    def save_choice(self, choice: Choice) -> None:
        """Keep what was chosen."""
        self._write(CHOICE_FILE, json.dumps(asdict(choice)).encode())

    def load_choice(self, settings: str) -> Choice | None:
        """Return what was chosen under these settings, None if nothing was."""
        try:
            content = self._read(CHOICE_FILE)
            choice = None if content is None else _choice(content)
        except DamagedError as error:
            self._warn(str(error))
            return None
        return choice if choice is not None and choice.settings == settings else None

    def save_sight(self, key: SightKey, table: RangeTable) -> None:
        """Keep a map's table of optimistic ranges, which takes a restart longest to make."""
        made = io.BytesIO()
        np.save(made, table.levels)
        self._write(_sight_file(key), made.getvalue())

    def load_sight(self, key: SightKey) -> RangeTable | None:
        """Return the table kept for this map and these parameters, None if there is none."""
        try:
            content = self._read(_sight_file(key))
        except DamagedError as error:
            self._warn(str(error))
            return None
        if content is None:
            return None
        levels = np.load(io.BytesIO(content), allow_pickle=False)
        return RangeTable(levels, key.visibility.reach)

    def _write(self, name: str, content: bytes) -> None:
        """Write a file so that a crash leaves the old one or the new one."""
        if self._folder is None:
            return
        temporary = self._folder / f"{name}.new"
        try:
            temporary.write_bytes(_checksum(content) + content)
            temporary.replace(self._folder / name)
        except OSError as error:
            self._warn(f"not kept: {error}")

    def _read(self, name: str) -> bytes | None:
        """Return the content of a file, None if there is none; DamagedError."""
        if self._folder is None:
            return None
        try:
            whole = (self._folder / name).read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise DamagedError(f"{name} is ignored: {error.strerror}") from error
        length = len(_checksum(b""))
        checksum, content = whole[:length], whole[length:]
        if checksum != _checksum(content):
            raise DamagedError(f"{name} is ignored: it is damaged")
        return content


def _packed(snapshot: Snapshot) -> bytes:
    archive, memory = io.BytesIO(), snapshot.memory
    np.savez(
        archive,
        map_id=np.array(snapshot.map_id),
        odometry_seq=np.array(snapshot.odometry_seq),
        poses=memory.poses,
        weights=memory.weights,
        odom_from_base=memory.odom_from_base,
        stamp_ns=np.array(memory.stamp_ns),
        was_localized=np.array(memory.was_localized),
    )
    return archive.getvalue()


def _unpacked(content: bytes) -> Snapshot:
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as kept:
            memory = Memory(
                poses=kept["poses"],
                weights=kept["weights"],
                odom_from_base=kept["odom_from_base"],
                stamp_ns=int(kept["stamp_ns"]),
                was_localized=bool(kept["was_localized"]),
            )
            return Snapshot(str(kept["map_id"]), int(kept["odometry_seq"]), memory)
    except (KeyError, ValueError, zipfile.BadZipFile) as error:
        # Whole, but of another version of Pilotage.
        raise DamagedError(f"{MEMORY_FILE} is ignored: {error}") from error


def _choice(content: bytes) -> Choice:
    values = json.loads(content)
    if set(values) != {field.name for field in fields(Choice)}:
        raise DamagedError(f"{CHOICE_FILE} is ignored: another version wrote it")
    return Choice(**values)


def _sight_file(key: SightKey) -> str:
    return f"sight-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}"


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()
