"""The map library: a folder per map, each replaced as a whole.

`NAME` is a link to a folder below `.versions` that never changes once it is linked. A map is
saved by writing a new version, waiting until it is on the disk, and then moving the link: whoever
looks, at any moment and after any power cut, sees the old map or the new one. Versions that no
link names, of saves that were cut short, are removed by the next save.

    maps/office -> .versions/office-1f3c...    map.yaml map.pgm trajectory.tum ... about.json
"""

import hashlib
import json
import os
import re
import secrets
import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from pilotage.core.grid import OccupancyMap
from pilotage.core.map_files import MapFileError, load_map, map_digest
from pilotage.core.map_yaml import read_description

MAP_FILE = "map.yaml"
SESSION_FILE = "session.npz"
"""What mapping needs to go on from where it ended."""

ABOUT_FILE = "about.json"
VERSIONS = ".versions"
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")


class LibraryError(ValueError):
    """What was asked of the library cannot be done; the text says why, in one sentence."""


@dataclass(frozen=True)
class About:
    """What a map of the library is; `sums` are the checksums of its `files`."""

    name: str
    map_id: str
    rows: int
    cols: int
    resolution: float
    saved_ns: int
    sums: dict[str, str]

    @property
    def files(self) -> tuple[str, ...]:
        """The names of its files."""
        return tuple(self.sums)


class MapLibrary:
    """The maps below `folder`; without a folder there is no library, and every wish is refused."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder

    def save(self, name: str, files: Mapping[str, bytes], saved_ns: int) -> Path:
        """Keep the files of a map under a name, in place of what was there; return its folder.

        Raises:
            LibraryError: bad name, files that are no map, no space, read-only; the old map stays.
        """
        folder = self._own_folder()
        _require_name(name)
        _require_own_image(files)
        version = folder / VERSIONS / f"{name}-{secrets.token_hex(8)}"
        link = folder / name
        if link.exists() and not link.is_symlink():
            raise LibraryError(f"{link} was not made by the library: choose another name")
        try:
            _write_version(version, name, files, saved_ns)
            _point(link, version)
            _remove_unlinked(folder)
        except OSError as error:
            shutil.rmtree(version, ignore_errors=True)
            reason = error.strerror or str(error)
            raise LibraryError(f"the map '{name}' was not saved: {reason}") from error
        except MapFileError as error:
            shutil.rmtree(version, ignore_errors=True)
            raise LibraryError(f"'{name}' is no map: {error}") from error
        return link

    def has(self, name: str) -> bool:
        """Say whether there is a map of this name."""
        is_name = NAME.fullmatch(name) is not None
        return is_name and self._folder is not None and (self._folder / name / MAP_FILE).is_file()

    def about(self, name: str) -> About:
        """Return what a map is; LibraryError if it is not there or damaged."""
        version = self._version(name)
        try:
            told = json.loads((version / ABOUT_FILE).read_bytes())
            return About(**told)
        except FileNotFoundError:
            return self._about_foreign(name, version)
        except (OSError, ValueError, TypeError) as error:
            raise LibraryError(f"the map '{name}' is damaged: {ABOUT_FILE}: {error}") from error

    def all(self) -> list[About]:
        """Return what the maps are by name, but for damaged ones."""
        if self._folder is None or not self._folder.is_dir():
            return []
        found = []
        for name in sorted(path.name for path in self._folder.iterdir() if self.has(path.name)):
            try:
                found.append(self.about(name))
            except LibraryError:
                continue
        return found

    def read(self, name: str, file: str) -> bytes:
        """Return a file of a map; LibraryError if it is not there or not as it was saved."""
        about, version = self.about(name), self._version(name)
        if file not in about.sums:
            raise LibraryError(f"'{name}' has no {file}; it has {', '.join(about.files)}")
        try:
            content = (version / file).read_bytes()
        except OSError as error:
            raise LibraryError(f"the map '{name}' is damaged: {file}: {error.strerror}") from error
        if hashlib.sha256(content).hexdigest() != about.sums[file]:
            raise LibraryError(f"the map '{name}' is damaged: {file} is not as it was saved")
        return content

    def load(self, name: str) -> OccupancyMap:
        """Return the cells of a map; LibraryError if it is not there or damaged."""
        for file in self.about(name).files:
            self.read(name, file)
        try:
            return load_map(self._version(name) / MAP_FILE)
        except MapFileError as error:
            raise LibraryError(str(error)) from error

    def delete(self, name: str) -> None:
        """Delete a map; LibraryError if it is not there or cannot be."""
        self._version(name)
        link = self._own_folder() / name
        if not link.is_symlink():
            raise LibraryError(f"{link} was not made by the library: delete it by hand")
        try:
            link.unlink()
            _sync(link.parent)
            _remove_unlinked(link.parent)
        except OSError as error:
            raise LibraryError(f"the map '{name}' was not deleted: {error.strerror}") from error

    def _own_folder(self) -> Path:
        if self._folder is None:
            raise LibraryError("there is no map library: set maps_dir of the mapper")
        try:
            (self._folder / VERSIONS).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise LibraryError(f"no map library at {self._folder}: {error.strerror}") from error
        return self._folder

    def _version(self, name: str) -> Path:
        """Return the folder that a name stands for now: it stays as it is until it is removed."""
        _require_name(name)
        if not self.has(name):
            known = ", ".join(about.name for about in self.all()) or "none yet"
            raise LibraryError(f"the library has no map '{name}'; it has {known}")
        return (self._own_folder() / name).resolve()

    def _about_foreign(self, name: str, folder: Path) -> About:
        """Say what a map is that somebody else put into the library's folder."""
        names = sorted(path.name for path in folder.iterdir() if path.is_file())
        saved_ns = (folder / MAP_FILE).stat().st_mtime_ns
        try:
            return _about(name, folder, names, saved_ns)
        except MapFileError as error:
            raise LibraryError(f"the map '{name}' is damaged: {error}") from error


def _require_name(name: str) -> None:
    if not NAME.fullmatch(name):
        raise LibraryError(
            f"'{name[:64]}' cannot name a map: letters, digits, _ . - (64 at most, no . first)"
        )


def _require_own_image(files: Mapping[str, bytes]) -> None:
    """Refuse files that are no map by themselves, or would be written elsewhere."""
    if MAP_FILE not in files:
        raise LibraryError(f"a map needs its {MAP_FILE}")
    for file in files:
        if not NAME.fullmatch(file) or file == ABOUT_FILE:
            raise LibraryError(f"'{file[:64]}' cannot be a file of a map")
    try:
        image = read_description(files[MAP_FILE], Path(MAP_FILE)).image
    except MapFileError as error:
        raise LibraryError(str(error)) from error
    if image not in files:
        raise LibraryError(f"{MAP_FILE} names the image '{image[:64]}', which did not come along")


def _write_version(version: Path, name: str, files: Mapping[str, bytes], saved_ns: int) -> None:
    """Write a version whole and wait until it is on the disk."""
    version.mkdir()
    for file, content in files.items():
        _write_synced(version / file, content)
    about = _about(name, version, list(files), saved_ns)
    _write_synced(version / ABOUT_FILE, json.dumps(asdict(about), indent=2).encode())
    _sync(version)
    _sync(version.parent)


def _about(name: str, folder: Path, files: list[str], saved_ns: int) -> About:
    world = load_map(folder / MAP_FILE)
    if not world.is_free.any():
        raise MapFileError("it has no free cell: a robot can be nowhere on it")
    sums = {file: hashlib.sha256((folder / file).read_bytes()).hexdigest() for file in files}
    rows, cols = world.cells.shape
    return About(name, map_digest(world), rows, cols, world.geometry.resolution, saved_ns, sums)


def _point(link: Path, version: Path) -> None:
    """Let the link name a version from now on, in one step."""
    new = link.with_name(f".{link.name}.new")
    new.unlink(missing_ok=True)
    new.symlink_to(Path(VERSIONS) / version.name)
    new.replace(link)
    _sync(link.parent)


def _remove_unlinked(folder: Path) -> None:
    for unfinished in folder.glob(".*.new"):
        unfinished.unlink(missing_ok=True)
    linked = {path.readlink().name for path in folder.iterdir() if path.is_symlink()}
    for version in (folder / VERSIONS).iterdir():
        if version.name not in linked:
            shutil.rmtree(version, ignore_errors=True)


def _write_synced(file: Path, content: bytes) -> None:
    with file.open("wb") as stream:
        stream.write(content)
        stream.flush()
        os.fsync(stream.fileno())


def _sync(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
