"""What a localizer keeps on disk, so that a crash costs it no more than a second of its memory.

The file is the checksum of an npz archive and then the archive: a file that was damaged, or
written by half when the power went, is told from a whole one before it is read.
"""

import hashlib
import io
from pathlib import Path

import numpy as np

from pilotage.localizer.estimate import Memory

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
    temporary = folder / (MEMORY_FILE + ".new")
    temporary.write_bytes(_checksum(archive.getvalue()) + archive.getvalue())
    temporary.replace(folder / MEMORY_FILE)


def load_memory(folder: Path, map_id: str) -> Memory | None:
    """Return the memory kept for this map, or None if there is none or it is damaged."""
    try:
        content = (folder / MEMORY_FILE).read_bytes()
    except OSError:
        return None
    checksum, archive = content[: len(_checksum(b""))], content[len(_checksum(b"")) :]
    if checksum != _checksum(archive):
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


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()
