"""Topological maps on disk: the library of them by name, and what a run must not lose.

A map is one GeoJSON file, `topologies/NAME.geojson`, which other programs can read as it stands;
it is replaced as a whole. The library lies beside the mapper's library of maps.
"""

import hashlib
import io
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pilotage.core.whole_files import write_whole
from pilotage.topology.drive import Arrays
from pilotage.topology.routes.floors import Floor, Link
from pilotage.topology.routes.geojson import floor_from_geojson, floor_to_geojson
from pilotage.topology.routes.strict_json import JsonError

SUFFIX = ".geojson"
DRIVE_FILE = "topology.drive"
RUN_FILE = f"topology{SUFFIX}"
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")

LARGEST = 60 * 2**20
"""Bytes of a file: what a message of the bus can carry."""


class LibraryError(ValueError):
    """What was asked of the library cannot be done; the text says why, in one sentence."""


@dataclass(frozen=True)
class Stored:
    """A topological map of the library and when it was kept, Unix ns."""

    floor: Floor
    saved_ns: int


class TopologyLibrary:
    """The topological maps below `folder`; without one every wish is refused."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._known: dict[str, tuple[tuple[int, int], Stored]] = {}

    def save(self, floor: Floor) -> Path:
        """Keep a map under its name, in place of what was there; return its file.

        Raises:
            LibraryError: bad name, no space, read-only; the old map stays.
        """
        return self._write([floor])[0]

    def store(self, name: str, content: bytes) -> Floor:
        """Take in a GeoJSON file under a name; LibraryError if it is no map."""
        _require_name(name)
        try:
            floor = replace(parsed(content), name=name)
        except JsonError as error:
            raise LibraryError(f"this is no topological map: {error}") from error
        if not floor.map.nodes:
            raise LibraryError("this is no topological map: it has no nodes")
        self.save(floor)
        return floor

    def load(self, name: str) -> Floor:
        """Return a map; LibraryError if it is not there or damaged."""
        return self.about(name).floor

    def about(self, name: str) -> Stored:
        """Return a map and when it was kept; LibraryError if it is not there or damaged."""
        file = self._file(name)
        try:
            state = _state(file)
            if self._known.get(name, (None,))[0] != state:
                floor = replace(parsed(file.read_bytes()), name=name)
                self._known[name] = (state, Stored(floor, state[0]))
        except JsonError as error:
            raise LibraryError(f"the topological map '{name}' is damaged: {error}") from error
        except OSError as error:
            reason = error.strerror or str(error)
            raise LibraryError(f"the topological map '{name}': {reason}") from error
        return self._known[name][1]

    def read(self, name: str) -> bytes:
        """Return the file of a map as it is; LibraryError if it is not there or damaged."""
        self.about(name)
        try:
            return self._file(name).read_bytes()
        except OSError as error:
            reason = error.strerror or str(error)
            raise LibraryError(f"the topological map '{name}': {reason}") from error

    def all(self) -> Iterator[Stored]:
        """Yield the maps by name, but for damaged ones."""
        for name in self.names():
            try:
                yield self.about(name)
            except LibraryError:
                continue

    def names(self) -> list[str]:
        """Return the names of all maps, damaged ones too."""
        if self._folder is None or not self._folder.is_dir():
            return []
        files = (file for file in self._folder.glob(f"*{SUFFIX}") if file.is_file())
        return sorted(file.stem for file in files if NAME.fullmatch(file.stem))

    def of_map(self, map_id: str) -> Floor | None:
        """Return the map kept last of an occupancy map, None if there is none."""
        found = [stored for stored in self.all() if stored.floor.map.map_id == map_id]
        return max(found, key=lambda stored: stored.saved_ns).floor if found else None

    def link(self, start: tuple[str, int], end: tuple[str, int], cost: float) -> list[Floor]:
        """Join nodes of two maps, given by name and id, both ways; return both maps.

        Raises:
            LibraryError: a map or a node is not there, or they are the same map.
        """
        if start[0] == end[0]:
            raise LibraryError("a link joins two maps; within one there are edges")
        floors = [
            self._with_node(name, node).linked(Link(node, other, there, cost))
            for (name, node), (other, there) in ((start, end), (end, start))
        ]
        self._write(floors)
        return floors

    def delete(self, name: str) -> None:
        """Delete a map; LibraryError if it is not there or cannot be."""
        file = self._file(name)
        try:
            file.unlink()
        except OSError as error:
            reason = error.strerror or str(error)
            raise LibraryError(f"'{name}' was not deleted: {reason}") from error
        self._known.pop(name, None)

    def _with_node(self, name: str, node: int) -> Floor:
        floor = self.load(name)
        if all(one.id != node for one in floor.map.nodes):
            raise LibraryError(f"the topological map '{name}' has no node {node}")
        return floor

    def _write(self, floors: list[Floor]) -> list[Path]:
        folder = self._own_folder()
        for floor in floors:
            _require_name(floor.name)
        files = {f"{floor.name}{SUFFIX}": packed(floor) for floor in floors}
        try:
            write_whole(folder, files)
        except OSError as error:
            names = " and ".join(f"'{floor.name}'" for floor in floors)
            reason = error.strerror or str(error)
            raise LibraryError(f"{names} could not be saved: {reason}") from error
        written = [folder / file for file in files]
        for floor, file in zip(floors, written, strict=True):
            state = _state(file)
            self._known[floor.name] = (state, Stored(floor, state[0]))
        return written

    def _file(self, name: str) -> Path:
        _require_name(name)
        file = self._own_folder() / f"{name}{SUFFIX}"
        if not file.is_file():
            known = ", ".join(self.names()) or "none yet"
            raise LibraryError(f"there is no topological map '{name}'; there is {known}")
        return file

    def _own_folder(self) -> Path:
        if self._folder is None:
            raise LibraryError("there is no library: set topologies_dir of the topology service")
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise LibraryError(f"no library at {self._folder}: {error.strerror}") from error
        return self._folder


class RunFolder:
    """Keeps the map in use, and the drive that one grows by, for a restart.

    Faults are told to `warn`: they cost the memory only. Without a folder nothing is kept.
    """

    def __init__(self, folder: Path | None, warn: Callable[[str], None]) -> None:
        self._folder = folder
        self._warn = warn

    def save(self, floor: Floor) -> None:
        """Keep a map in place of the last one."""
        if self._folder is None:
            return
        try:
            write_whole(self._folder, {RUN_FILE: packed(floor)})
        except OSError as error:
            self._warn(f"not kept: {error.strerror or error}")

    def load(self) -> Floor | None:
        """Return the map that was kept, None if there is none or if it is damaged."""
        try:
            return None if self._folder is None else parsed((self._folder / RUN_FILE).read_bytes())
        except FileNotFoundError:
            return None
        except (OSError, JsonError) as error:
            self._warn(f"{RUN_FILE} is ignored: {error}")
            return None

    def save_drive(self, arrays: Arrays) -> None:
        """Keep a drive in place of the last one."""
        if self._folder is None:
            return
        made = io.BytesIO()
        named: dict[str, Any] = dict(arrays)
        np.savez(made, **named)
        content = made.getvalue()
        try:
            write_whole(self._folder, {DRIVE_FILE: hashlib.sha256(content).digest() + content})
        except OSError as error:
            self._warn(f"not kept: {error.strerror or error}")

    def load_drive(self) -> Arrays | None:
        """Return the drive that was kept, None if there is none or if it is damaged."""
        try:
            whole = None if self._folder is None else (self._folder / DRIVE_FILE).read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            self._warn(f"{DRIVE_FILE} is ignored: {error.strerror}")
            return None
        if whole is None:
            return None
        length = hashlib.sha256().digest_size
        if hashlib.sha256(whole[length:]).digest() != whole[:length]:
            self._warn(f"{DRIVE_FILE} is ignored: it is damaged")
            return None
        with np.load(io.BytesIO(whole[length:]), allow_pickle=False) as kept:
            return {name: kept[name] for name in kept.files}

    def forget_drive(self) -> None:
        """Keep no drive."""
        if self._folder is None:
            return
        try:
            (self._folder / DRIVE_FILE).unlink(missing_ok=True)
        except OSError as error:
            self._warn(f"not forgotten: {error.strerror}")


def packed(floor: Floor) -> bytes:
    """Return a map as the bytes of a GeoJSON file."""
    return json.dumps(floor_to_geojson(floor), allow_nan=False).encode()


def parsed(content: bytes) -> Floor:
    """Return the map of a GeoJSON file; JsonError names the first fault."""
    if len(content) > LARGEST:
        raise JsonError(f"it has {len(content)} bytes; {LARGEST} are taken at most")
    try:
        document = json.loads(content, parse_constant=_refuse, object_pairs_hook=_unique)
    except RecursionError as error:
        raise JsonError("it is nested too deeply") from error
    except JsonError:
        raise
    except ValueError as error:
        raise JsonError(f"it is not JSON: {error}") from error
    return floor_from_geojson(document)


def _state(file: Path) -> tuple[int, int]:
    """Return what tells whether a file has changed: its time, Unix ns, and its size."""
    told = file.stat()
    return told.st_mtime_ns, told.st_size


def _refuse(name: str) -> None:
    raise JsonError(f"{name} is not JSON")


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    fields = dict(pairs)
    if len(fields) != len(pairs):
        raise JsonError("a member stands twice in an object")
    return fields


def _require_name(name: str) -> None:
    if not NAME.fullmatch(name):
        raise LibraryError(
            f"'{name[:64]}' cannot name a map: letters, digits, _ . - (64 at most, no . first)"
        )
