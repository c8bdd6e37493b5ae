"""What a localizer keeps on disk, so that a crash costs it no more than a second of its memory."""

import zipfile
from pathlib import Path

import numpy as np

from pilotage.localizer.markov_localizer import Memory

MEMORY_FILE = "localizer.npz"


def save_memory(folder: Path, map_id: str, memory: Memory) -> None:
    """Write the memory so that a crash leaves the old one or the new one."""
    temporary = folder / (MEMORY_FILE + ".new")
    with temporary.open("wb") as file:
        np.savez(
            file,
            map_id=np.array(map_id),
            poses=memory.poses,
            weights=memory.weights,
            odom_from_base=memory.odom_from_base,
            stamp_ns=np.array(memory.stamp_ns),
            was_localized=np.array(memory.was_localized),
        )
    temporary.replace(folder / MEMORY_FILE)


def load_memory(folder: Path, map_id: str) -> Memory | None:
    """Return the memory kept for this map, or None if there is none or it is damaged."""
    try:
        with np.load(folder / MEMORY_FILE, allow_pickle=False) as kept:
            if str(kept["map_id"]) != map_id:
                return None
            return Memory(
                poses=kept["poses"],
                weights=kept["weights"],
                odom_from_base=kept["odom_from_base"],
                stamp_ns=int(kept["stamp_ns"]),
                was_localized=bool(kept["was_localized"]),
            )
    except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile):
        return None
