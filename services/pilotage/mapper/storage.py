"""What a mapper keeps on disk, so that a crash costs it no more than some seconds of mapping.

State is a JSON-like `facts` and arrays by name. A mapping run only adds to most of them: scans to
the scans, poses to the poses. So a large array is kept in chunks of its rows, files that are named
by the checksum of their content and never change; of an array that grew only the new rows are
written, and what a loop closure moved is written anew from the first row that moved. Small arrays
and the list of chunks form the one file `mapper.state`, which is replaced as a whole, last of all:
a reader finds the old state or the new one. Chunks that no state names are removed then.
"""

import hashlib
import io
import json
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilotage.core.whole_files import write_whole

STATE_FILE = "mapper.state"
CHUNK_FOLDER = "mapper.chunks"
FACTS = "facts"
LISTS = "chunks"

SMALL = 1 << 16
"""Arrays of fewer bytes go into the state file: files of their own would wait for the disk."""

MOST_CHUNKS = 24
"""An array in more chunks is written anew in one: so files stay few."""

Arrays = dict[str, NDArray[Any]]
Chunks = list[tuple[str, int]]
"""Checksum and number of rows of each chunk, first rows first."""


class DamagedError(ValueError):
    """The state cannot be used; the text says why."""


@dataclass(frozen=True, eq=False)
class State:
    """What is kept: `facts` as JSON can hold them, `arrays` by name."""

    facts: dict[str, Any]
    arrays: Arrays


class StateFolder:
    """Keeps and finds a mapper's state. Faults are told to `warn`: they cost the memory only.

    Without a folder nothing is kept and nothing found.
    """

    def __init__(self, folder: Path | None, warn: Callable[[str], None]) -> None:
        self._folder = folder
        self._warn = warn
        self._lists: dict[str, Chunks] = {}

    def save(self, state: State) -> None:
        """Keep a state in place of the last one."""
        if self._folder is None:
            return
        try:
            self._save(self._folder, state)
        except OSError as error:
            self._warn(f"not kept: {error.strerror or error}")

    def load(self) -> State | None:
        """Return the state that was kept, None if there is none or if it is damaged."""
        if self._folder is None or not (self._folder / STATE_FILE).exists():
            return None
        try:
            return self._load(self._folder)
        except (OSError, DamagedError) as error:
            self._warn(f"{STATE_FILE} is ignored: {error}")
            return None

    def forget(self) -> None:
        """Keep nothing."""
        if self._folder is None:
            return
        try:
            (self._folder / STATE_FILE).unlink(missing_ok=True)
            self._lists = {}
            self._remove_unnamed(self._folder / CHUNK_FOLDER)
        except OSError as error:
            self._warn(f"not forgotten: {error.strerror or error}")

    def _save(self, folder: Path, state: State) -> None:
        chunks = folder / CHUNK_FOLDER
        chunks.mkdir(exist_ok=True)
        small = {name: a for name, a in state.arrays.items() if a.nbytes < SMALL or a.ndim == 0}
        lists: dict[str, Chunks] = {}
        new: Arrays = {}
        for name, array in state.arrays.items():
            if name not in small:
                lists[name] = _chunked(array, self._lists.get(name, []))
                new |= dict(_rows_of(array, lists[name]))
        absent = {key: rows for key, rows in new.items() if not (chunks / key).exists()}
        write_whole(chunks, {key: rows.tobytes() for key, rows in absent.items()})
        shapes = {name: _described(state.arrays[name], found) for name, found in lists.items()}
        write_whole(folder, {STATE_FILE: _packed(state.facts, shapes, small)})
        self._lists = lists
        self._remove_unnamed(chunks)

    def _load(self, folder: Path) -> State:
        facts, shapes, arrays = _unpacked((folder / STATE_FILE).read_bytes())
        self._lists = {
            name: [tuple(one) for one in told["chunks"]] for name, told in shapes.items()
        }
        for name, told in shapes.items():
            parts = [_checked(folder / CHUNK_FOLDER / key, key) for key, _ in self._lists[name]]
            flat = np.frombuffer(b"".join(parts), told["dtype"])
            try:
                arrays[name] = flat.reshape(told["shape"])
            except ValueError as error:
                raise DamagedError(f"{name}: {error}") from error
        return State(facts, arrays)

    def _remove_unnamed(self, chunks: Path) -> None:
        named = {key for found in self._lists.values() for key, _ in found}
        if chunks.is_dir():
            for file in chunks.iterdir():
                if file.name not in named:
                    file.unlink(missing_ok=True)


def _chunked(array: NDArray[Any], old: Chunks) -> Chunks:
    """Return the chunks of an array: the old ones as far as they still hold, then one more."""
    kept: Chunks = []
    row = 0
    for key, rows in old:
        if row + rows > len(array) or _checksum(array[row : row + rows]) != key:
            break
        kept.append((key, rows))
        row += rows
    if len(kept) >= MOST_CHUNKS:
        kept, row = [], 0
    rest = array[row:]
    return [*kept, (_checksum(rest), len(rest))] if len(rest) else kept


def _rows_of(array: NDArray[Any], chunks: Chunks) -> Iterator[tuple[str, NDArray[Any]]]:
    row = 0
    for key, rows in chunks:
        yield key, array[row : row + rows]
        row += rows


def _described(array: NDArray[Any], chunks: Chunks) -> dict[str, Any]:
    return {"dtype": array.dtype.str, "shape": array.shape, "chunks": chunks}


def _checksum(rows: NDArray[Any]) -> str:
    return hashlib.sha256(np.ascontiguousarray(rows).data).hexdigest()


def _checked(file: Path, key: str) -> bytes:
    content = file.read_bytes()
    if hashlib.sha256(content).hexdigest() != key:
        raise DamagedError(f"{file.name} is damaged")
    return content


def _packed(facts: dict[str, Any], shapes: dict[str, Any], small: Arrays) -> bytes:
    made = io.BytesIO()
    told = np.array(json.dumps({FACTS: facts, LISTS: shapes}))
    arrays: dict[str, Any] = {FACTS: told} | {f"/{name}": a for name, a in small.items()}
    np.savez(made, **arrays)
    content = made.getvalue()
    return hashlib.sha256(content).digest() + content


def _unpacked(whole: bytes) -> tuple[dict[str, Any], dict[str, Any], Arrays]:
    length = hashlib.sha256().digest_size
    content = whole[length:]
    if hashlib.sha256(content).digest() != whole[:length]:
        raise DamagedError("it is damaged")
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as kept:
            told = json.loads(str(kept[FACTS]))
            arrays = {name[1:]: kept[name] for name in kept.files if name != FACTS}
            return told[FACTS], told[LISTS], arrays
    except (KeyError, ValueError, TypeError, zipfile.BadZipFile) as error:
        # Whole, but of another version of Pilotage.
        raise DamagedError(f"another version wrote it ({error})") from error
