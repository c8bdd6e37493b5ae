"""What a localizer keeps on disk, so that a crash costs it no more than a second of its memory.

A file is the checksum of a numpy archive and then the archive: one that was damaged, or written
by half when the power went, is told from a whole one before it is read.
"""

import hashlib
import io
from pathlib import Path

import numpy as np

from pilotage.localizer.estimate import Memory
from pilotage.localizer.markov_localizer import MarkovParams
from pilotage.localizer.range_model import RangeTable

MEMORY_FILE = "localizer.memory"


def save_memory(folder: Path, map_id: str, memory: Memory) -> None:
    """Write the memory so that a crash leaves the old one or the new one; OSError."""
    archive = io.BytesIO()
    np.savez(
        archive,
        map_id=np.array(map_id),
        poses=memory.poses,
        weights=memory.weights,
        odom_from_base=memory.odom_from_base,
        stamp_ns=np.array(memory.stamp_ns),
        was_localized=np.array(memory.was_localized),
    )
    _write(folder / MEMORY_FILE, archive.getvalue())


def load_memory(folder: Path, map_id: str) -> Memory | None:
    """Return the memory kept for this map, or None if there is none or it is damaged."""
    archive = _read(folder / MEMORY_FILE)
    if archive is None:
        return None
    with np.load(io.BytesIO(archive), allow_pickle=False) as kept:
        if str(kept["map_id"]) != map_id:
            return None
        return Memory(
            poses=kept["poses"],
            weights=kept["weights"],
            odom_from_base=kept["odom_from_base"],
            stamp_ns=int(kept["stamp_ns"]),
            was_localized=bool(kept["was_localized"]),
        )


def save_sight(folder: Path, map_id: str, params: MarkovParams, table: RangeTable) -> None:
    """Keep a map's table of optimistic ranges, which takes a restart longest to make; OSError."""
    made = io.BytesIO()
    np.save(made, table.levels)
    _write(_sight_file(folder, map_id, params), made.getvalue())


def load_sight(folder: Path, map_id: str, params: MarkovParams) -> RangeTable | None:
    """Return the table kept for this map and these parameters, None if there is none."""
    archive = _read(_sight_file(folder, map_id, params))
    if archive is None:
        return None
    levels = np.load(io.BytesIO(archive), allow_pickle=False)
    return RangeTable(levels, params.visibility.reach)


def _sight_file(folder: Path, map_id: str, params: MarkovParams) -> Path:
    words = f"{map_id} {params.grid} {params.visibility}"
    return folder / f"sight-{hashlib.sha256(words.encode()).hexdigest()[:16]}"


def _write(file: Path, archive: bytes) -> None:
    temporary = file.with_name(file.name + ".new")
    temporary.write_bytes(_checksum(archive) + archive)
    temporary.replace(file)


def _read(file: Path) -> bytes | None:
    """Return the archive in a file, or None if there is none or it is damaged."""
    try:
        content = file.read_bytes()
    except OSError:
        return None
    length = len(_checksum(b""))
    checksum, archive = content[:length], content[length:]
    return archive if checksum == _checksum(archive) else None


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()
