"""Answers what the mapper is asked: to make a map, to keep it, to use another one."""

from pathlib import Path

import numpy as np

from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.core.map_files import MapFileError
from pilotage.mapper.map_choice import WORK_S, MapChoice
from pilotage.mapper.map_library import SESSION_FILE, About, LibraryError
from pilotage_schemas.commands import (
    Done,
    LoadMap,
    MapDelete,
    MapFetch,
    MapFile,
    MapList,
    MapLoaded,
    MapSave,
    MapSaved,
    MapStart,
    MapStore,
    Nothing,
    StoredMap,
)
from pilotage_schemas.mapping import OccupancyGrid


class Queries:
    """Answers the mapper's queries; whatever is refused leaves everything as it was."""

    def __init__(self, node: Node, at: MapChoice) -> None:
        self._node = node
        self._at = at
        node.answer("map_start", self.start)
        node.answer("map_stop", self.stop)
        node.answer("map_reset", self.reset)
        node.answer("map_save", self.save)
        node.answer("map_load", lambda request: self.load(request.map))
        node.answer("load_map", self.load_path)
        node.answer("map_list", self.list)
        node.answer("map_delete", self.delete)
        node.answer("map_fetch", self.fetch)
        node.answer("map_store", self.store)

    def start(self, request: MapStart) -> Done:
        """Begin a map, or go on with the present one."""
        if request.go_on:
            self._at.go_on(request.sensor)
        else:
            self._at.start(request.sensor)
        return Done(detail=f"mapping by {request.sensor}")

    def stop(self, _request: Nothing) -> MapLoaded:
        """Finish the map and use it."""
        return _loaded(self._at.stop())

    def reset(self, _request: Nothing) -> Done:
        """Begin the map in the making anew."""
        self._at.reset()
        return Done(detail="mapping anew")

    def save(self, request: MapSave) -> MapSaved:
        """Keep the present map."""
        try:
            path = self._at.save(request.name)
            return self._saved(request.name, path)
        except LibraryError as error:
            raise RefusedError(str(error)) from error

    def load(self, wanted: str) -> MapLoaded:
        """Use a map of the library, or a file."""
        try:
            with self._node.busy(WORK_S):
                if self._at.library.has(wanted):
                    grid = self._at.use_stored(wanted)
                else:
                    grid = self._at.use_file(_path(wanted))
                self._at.keep()
        except (LibraryError, MapFileError) as error:
            raise RefusedError(str(error)) from error
        return _loaded(grid)

    def load_path(self, request: LoadMap) -> MapLoaded:
        """Use a map: the older name of `map_load`."""
        return self.load(request.path)

    def list(self, _request: Nothing) -> MapList:
        """Say what the library has."""
        return MapList(maps=tuple(_stored(about) for about in self._at.library.all()))

    def delete(self, request: MapDelete) -> Done:
        """Delete a map of the library."""
        try:
            self._at.library.delete(request.name)
        except LibraryError as error:
            raise RefusedError(str(error)) from error
        return Done(detail=f"deleted {request.name}")

    def fetch(self, request: MapFetch) -> MapFile:
        """Return a file of a map."""
        try:
            content = self._at.library.read(request.name, request.file)
        except LibraryError as error:
            raise RefusedError(str(error)) from error
        return MapFile(content=np.frombuffer(content, np.int8))

    def store(self, request: MapStore) -> MapSaved:
        """Take a map into the library."""
        files = {file.name: file.content.tobytes() for file in request.files}
        try:
            with self._node.busy(WORK_S):
                path = self._at.library.save(request.name, files, self._node.clock.now_ns())
            return self._saved(request.name, path)
        except LibraryError as error:
            raise RefusedError(str(error)) from error

    def _saved(self, name: str, path: Path) -> MapSaved:
        return MapSaved(name=name, map_id=self._at.library.about(name).map_id, path=str(path))


def _path(wanted: str) -> Path:
    if not wanted.strip():
        raise RefusedError("the path is empty: name a map of the library or a map file")
    return Path(wanted)


def _loaded(grid: OccupancyGrid) -> MapLoaded:
    rows, cols = grid.cells.shape
    return MapLoaded(map_id=grid.map_id, rows=rows, cols=cols)


def _stored(about: About) -> StoredMap:
    return StoredMap(
        name=about.name,
        map_id=about.map_id,
        rows=about.rows,
        cols=about.cols,
        resolution=about.resolution,
        saved_ns=about.saved_ns,
        files=about.files,
        can_go_on=SESSION_FILE in about.files,
    )
