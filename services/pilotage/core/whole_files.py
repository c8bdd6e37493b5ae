"""Files that survive a power cut as the old ones or the new ones, never by half."""

import os
from collections.abc import Mapping
from pathlib import Path


def write_whole(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files by name into a folder; they appear there in their order, each at once.

    All of them are first written whole under temporary names, so that a full disk changes none.

    Raises:
        OSError: the folder is missing, full or read-only; the old files are then still there.
    """
    for name, content in files.items():
        _write_synced(temporary_of(folder / name), content)
    for name in files:
        temporary_of(folder / name).replace(folder / name)
        _sync_folder(folder)


def temporary_of(file: Path) -> Path:
    """Return where a file stands until it is whole."""
    return file.with_name(file.name + ".new")


def _write_synced(file: Path, content: bytes) -> None:
    """Write a file and wait until it is on the disk."""
    with file.open("wb") as stream:
        stream.write(content)
        stream.flush()
        os.fsync(stream.fileno())


def _sync_folder(folder: Path) -> None:
    """Wait until the renames in a folder are on the disk."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
