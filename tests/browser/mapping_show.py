"""A scripted mapper in the show's building: what the robot has passed appears on the map."""

import math
import threading
from typing import Self

import numpy as np
from numpy.typing import NDArray

from browser.live_gateway import LiveGateway
from browser.show import (
    Script,
    belief,
    building,
    deployment,
    description,
    health,
    heartbeat,
    status,
)
from pilotage.bus.fabric import RefusedError
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.mapper.map_show import MapShow
from pilotage_schemas.commands import (
    Done,
    MapList,
    MapLoad,
    MapLoaded,
    MapSave,
    MapSaved,
    MapStart,
    Nothing,
    StoredMap,
)
from pilotage_schemas.mapping import MappingStatus
from pilotage_schemas.message import Part

SIGHT = 4.0
PERIOD_S = 0.1


class MappingShow:
    """Drives along the corridor and maps it; `turn` closes a loop that turns the whole map."""

    def __init__(self, gateway: LiveGateway) -> None:
        self.gateway = gateway
        self.asked: list[tuple[str, Part]] = []
        self.refusal = ""
        self.mode = "idle"
        self._told = "idle"
        self.turned = 0.0
        self.redraws = 0
        self._show = MapShow(gateway.other("mapper"))
        self._way: list[NDArray[np.float64]] = []
        self._ticks = 0
        self._since_ns = 0
        self._saved: list[StoredMap] = []
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)
        grid = building(1)
        rows, cols = grid.cells.shape
        geometry = GridGeometry(rows, cols, grid.resolution, (grid.origin.x, grid.origin.y, 0.0))
        self._true = OccupancyMap(geometry, grid.cells)
        self._seen = np.zeros(grid.cells.shape, bool)
        for name in ("map_start", "map_stop", "map_reset", "map_save", "map_load", "map_list"):
            gateway.answer("mapper", name, getattr(self, name))

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *reason: object) -> None:
        self._ended.set()
        self._thread.join(10.0)

    def close_loop(self, turned: float) -> None:
        """Let the whole map turn by an angle, as after a loop closure."""
        self.turned, self.redraws = turned, self.redraws + 1

    def map_start(self, request: MapStart) -> Done:
        self._note("map_start", request)
        self.mode, self._since_ns = "mapping", self.gateway.clock.now_ns()
        return Done()

    def map_stop(self, request: Nothing) -> MapLoaded:
        self._note("map_stop", request)
        self.mode = "idle"
        return MapLoaded(map_id="made", rows=1, cols=1)

    def map_reset(self, request: Nothing) -> Done:
        self._note("map_reset", request)
        return Done()

    def map_save(self, request: MapSave) -> MapSaved:
        self._note("map_save", request)
        kept = StoredMap(
            name=request.name,
            map_id="made",
            rows=300,
            cols=560,
            resolution=0.05,
            saved_ns=1,
            files=("map.yaml", "map.pgm"),
            can_go_on=False,
        )
        self._saved.append(kept)
        return MapSaved(name=request.name, map_id="made", path="maps")

    def map_load(self, request: MapLoad) -> MapLoaded:
        self._note("map_load", request)
        return MapLoaded(map_id="made", rows=1, cols=1)

    def map_list(self, _request: Nothing) -> MapList:
        return MapList(maps=tuple(self._saved))

    def _note(self, name: str, request: Part) -> None:
        self.asked.append((name, request))
        if self.refusal:
            raise RefusedError(self.refusal)

    def _run(self) -> None:
        while not self._ended.is_set():
            self.tick()
            self._ended.wait(PERIOD_S)

    def tick(self) -> None:
        """Publish one round."""
        now, script = self.gateway.clock.now_ns(), Script(state="localized", confidence=0.99)
        if self._ticks % 10 == 0:
            self.gateway.publish("robot", "description", description(now, script))
            self.gateway.publish("launcher", "deployment", deployment(now, script))
            for service in ("robot", "mapper", "localizer"):
                self.gateway.publish(service, "health", health(now, service))
                self.gateway.publish(service, "heartbeat", heartbeat(now, service))
        if self._ticks % 5 == 0:
            self.gateway.publish("robot", "status", status(now, script))
            self._tell_map(now)
        if self._told == "mapping":
            self._move(now)
        elif self._ticks % 5 == 0:
            self.gateway.publish("localizer", "belief", belief(now, ((0.9, 3.0, 6.5, 0.0),)))
        self._ticks += 1

    def _move(self, now: int) -> None:
        x = 2.0 + min(20.0, 0.12 * len(self._way))
        y = 6.5 + 0.3 * math.sin(x)
        self._way.append(np.array([x, y, 0.3 * math.cos(x)]))
        centres = self._true.geometry.centres_of(np.argwhere(self._true.cells >= -1))
        near = np.hypot(centres[:, 0] - x, centres[:, 1] - y) < SIGHT
        self._seen |= near.reshape(self._seen.shape)
        self._show.pose(self._turned(self._way[-1]), np.eye(3) * 1e-3, now)

    def _turned(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        return se2.compose([0.0, 0.0, self.turned], poses)

    def _tell_map(self, now: int) -> None:
        message = MappingStatus.model_validate(
            {
                "stamp_ns": now,
                "frame_id": "map",
                "mode": self.mode,
                "sensor": "laser",
                "since_ns": self._since_ns,
                "steps": len(self._way),
                "redraws": self.redraws,
            }
        )
        self._show.status(message)
        self._told = message.mode
        if self._told != "mapping" or not self._way:
            return
        x, y, theta = self._turned(np.array(self._true.geometry.origin)).tolist()
        shape = self._true.geometry
        geometry = GridGeometry(shape.rows, shape.cols, shape.resolution, (x, y, theta))
        cells = np.where(self._seen, self._true.cells, -1).astype(np.int8)
        self._show.grow(OccupancyMap(geometry, cells))
        stamps = now / 1e9 - np.arange(len(self._way), dtype=np.float64)[::-1]
        self._show.path((stamps, self._turned(np.array(self._way))))
