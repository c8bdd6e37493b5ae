"""Files that may be packed with gzip, told by their first bytes."""

import gzip
import zlib
from pathlib import Path

MAGIC = b"\x1f\x8b"


def read_maybe_gzip(file: Path, limit: int) -> bytes:
    """Return the content of a file, unpacked if it is gzip.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is named .gz and is not gzip, is damaged, is longer than `limit` bytes, or
            is a pipe or a device, which might never end.
    """
    if file.exists() and not (file.is_file() or file.is_dir()):
        raise ValueError("it is a pipe or a device, not a file")
    with file.open("rb") as stream:
        is_packed = stream.read(len(MAGIC)) == MAGIC
    if file.suffix == ".gz" and not is_packed:
        raise ValueError("it is named .gz but is not gzip")
    try:
        with gzip.open(file) if is_packed else file.open("rb") as stream:
            content = stream.read(limit + 1)
    except (EOFError, zlib.error, gzip.BadGzipFile):
        raise ValueError("the gzip data are damaged or cut off") from None
    if len(content) > limit:
        raise ValueError(f"it holds more than {limit} bytes")
    return content
