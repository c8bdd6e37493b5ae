"""A map's files in one ZIP archive, as people carry maps about."""

import io
import zipfile
import zlib

import numpy as np

from pilotage_schemas.commands import NamedFile

LARGEST = 60 * 2**20
"""Bytes of all files of a map together, unpacked: what a message of the bus can carry."""

MOST_FILES = 16

UNREADABLE = (
    *(zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, EOFError, OSError),
    # Encrypted, or with names and sizes that are none.
    *(RuntimeError, ValueError),
)


class ArchiveError(ValueError):
    """The archive cannot be used; the text says why."""


def packed(files: dict[str, bytes]) -> bytes:
    """Return the files as an archive."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for name, content in files.items():
            # Of no date, so that the same map is the same archive.
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)
    return made.getvalue()


def unpacked(content: bytes) -> tuple[NamedFile, ...]:
    """Return the files of an archive, whichever folder they stand in; ArchiveError."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            entries = [entry for entry in archive.infolist() if not entry.is_dir()]
            _require_bounded(entries)
            return tuple(_file(archive, entry) for entry in entries)
    except ArchiveError:
        raise
    except NotImplementedError as error:
        raise ArchiveError(f"the archive is packed in a way unknown here: {error}") from error
    except UNREADABLE as error:
        raise ArchiveError(f"the body is no ZIP archive that can be read: {error}") from error


def _require_bounded(entries: list[zipfile.ZipInfo]) -> None:
    if not 0 < len(entries) <= MOST_FILES:
        raise ArchiveError(f"the archive has {len(entries)} files; 1 to {MOST_FILES} are taken")
    size = sum(entry.file_size for entry in entries)
    if size > LARGEST:
        raise ArchiveError(f"unpacked it has {size} bytes; {LARGEST} are taken at most")


def _file(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NamedFile:
    name = entry.filename.rsplit("/", 1)[-1]
    with archive.open(entry) as stream:
        # An entry may be larger than it says.
        content = stream.read(LARGEST + 1)
    if len(content) != entry.file_size:
        raise ArchiveError(f"{name} is not as large as the archive says")
    return NamedFile(name=name[:64], content=np.frombuffer(content, np.int8))
