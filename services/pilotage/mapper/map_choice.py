"""Which map is in use, or in the making, and how one becomes the other."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.map_files import load_map, map_documents
from pilotage.mapper.map_library import MAP_FILE, SESSION_FILE, MapLibrary
from pilotage.mapper.map_products import decided, finish, products
from pilotage.mapper.map_show import MapShow
from pilotage.mapper.mapping_session import MappingSession
from pilotage.mapper.messages import pose_of
from pilotage.mapper.method import MappingMethod
from pilotage.mapper.methods import NoMethodError
from pilotage.mapper.session_file import packed_session, resume_session, unpacked_session
from pilotage.mapper.storage import State, StateFolder
from pilotage.mapper.warm_up import warm_up
from pilotage_schemas.mapping import Handover, MappingSensor, MappingStatus, OccupancyGrid

WORK_S = 60.0
"""Limit for drawing, keeping or loading a map."""

HANDOVER_S = 60.0
"""A localizer that has not taken over by then is not waited for any more."""

Mode = Literal["idle", "mapping", "handing_over"]
Pose = NDArray[np.float64]


class MapChoice:
    """The map in use or in the making.

    Attributes:
        mode: see MappingStatus.
        session: the run that made, or makes, the map; None for a map from a file.
        localized: the pose (3,) where the localizer says that the robot is, None unless it is sure.
    """

    def __init__(
        self,
        node: Node,
        kept: StateFolder,
        library: MapLibrary,
        make: Callable[[str], MappingMethod],
    ) -> None:
        self.mode: Mode = "idle"
        self.session: MappingSession | None = None
        self.sensor: MappingSensor | None = None
        self.localized: Pose | None = None
        self.library = library
        self.show = MapShow(node)
        self._node = node
        self._kept = kept
        self._make = make
        self._world: OccupancyMap | None = None
        self._name = ""
        self._since_ns = 0
        self._handover: Handover | None = None
        self._handed_at = 0.0
        self._others: set[str] = set()
        node.watch_presence(self._see_presence)

    def start(self, sensor: MappingSensor) -> None:
        """Begin a new map; RefusedError while another one is made."""
        self._require_idle()
        self._begin_session(sensor)
        self._begin_mapping()

    def go_on(self, sensor: MappingSensor) -> None:
        """Go on with the present map from where the localizer says that the robot is."""
        self._require_idle()
        if self.session is None:
            raise RefusedError("the present map was not made here: only a new one can be begun")
        if sensor != self.sensor:
            raise RefusedError(f"the present map was made by {self.sensor}, not by {sensor}")
        if self.localized is None:
            raise RefusedError("the robot does not know where it is on the present map")
        try:
            self.session.go_on_at(self.localized)
        except ValueError as error:
            raise RefusedError(str(error)) from error
        self._begin_mapping()

    def reset(self) -> None:
        """Begin the map in the making anew."""
        if self.mode != "mapping" or self.sensor is None:
            raise RefusedError("no map is being made")
        self._begin_session(self.sensor)
        self._begin_mapping()

    def stop(self) -> OccupancyGrid:
        """Finish the map, use it, and hand over to the localizer."""
        if self.mode != "mapping" or self.session is None:
            raise RefusedError("no map is being made")
        with self._node.busy(WORK_S):
            self.session.finish()
            self._world = decided(self.session.method.map())
            if not self._world.is_free.any():
                raise RefusedError("nothing has been mapped yet: map_reset begins anew")
            self._name = "made here"
            grid = self.show.checked(self._world, self._name)
            self._hand_over(grid)
            self.show.serve(grid)
            self.show.path(self.session.method.trajectory())
            self.keep()
        self.see_to_hand_over()
        return grid

    def use_file(self, path: Path) -> OccupancyGrid:
        """Use the map of a file; MapFileError, and the old one stays."""
        self._require_idle()
        return self._use(load_map(path), path.name, None, None)

    def use_stored(self, name: str) -> OccupancyGrid:
        """Use a map of the library; LibraryError, and the old one stays."""
        self._require_idle()
        world = self.library.load(name)
        session, sensor = None, None
        if SESSION_FILE in self.library.about(name).files:
            sensor, session = self._session_of(self.library.read(name, SESSION_FILE))
        return self._use(world, name, session, sensor)

    def save(self, name: str) -> Path:
        """Keep the present map in the library; LibraryError or RefusedError, the old one stays."""
        if self.session is not None:
            with self._node.busy(WORK_S):
                files = {
                    **products(finish(self.session.method)),
                    SESSION_FILE: packed_session(self.sensor, self.session),
                }
                return self.library.save(name, files, self._node.clock.now_ns())
        if self._world is None:
            raise RefusedError("there is no map yet")
        files = map_documents(self._world, MAP_FILE)
        return self.library.save(name, files, self._node.clock.now_ns())

    def show_growth(self, *, with_path: bool) -> None:
        """Publish what is new of the map in the making, and the way if wanted."""
        if self.session is None:
            return
        before = self.show.map_id
        with self._node.busy(WORK_S):
            self.show.grow(decided(self.session.method.map()))
        if with_path or before != self.show.map_id:
            self.show.path(self.session.method.trajectory())
            self.say_status()

    def say_status(self) -> None:
        """Publish who owns the pose and how the map goes."""
        session = self.session
        self.show.status(
            MappingStatus(
                stamp_ns=self._node.clock.now_ns(),
                frame_id="map",
                mode=self.mode,
                sensor=self.sensor,
                map_id=self.show.map_id,
                since_ns=self._since_ns,
                steps=0 if session is None else session.steps,
                redraws=0 if session is None else session.redraws,
                handover=self._handover,
            )
        )

    def take_over_by(self, map_id: str) -> None:
        """End the hand-over if this is the map that the localizer believes something on."""
        if self.mode == "handing_over" and map_id == self.show.map_id:
            self._end_hand_over()

    def see_to_hand_over(self) -> None:
        """End a hand-over that nobody is there for."""
        waited = self._node.clock.monotonic() - self._handed_at
        is_vain = "localizer" not in self._others or waited > HANDOVER_S
        if self.mode == "handing_over" and is_vain:
            self._end_hand_over()

    def keep(self) -> None:
        """Let the present state outlive a crash."""
        if self.mode == "idle" and self._world is None:
            return
        arrays = {} if self.session is None else self.session.remember()
        facts: dict[str, Any] = {"mode": self.mode, "sensor": self.sensor, "name": self._name}
        if self.mode != "mapping" and self._world is not None:
            geometry = self._world.geometry
            facts["resolution"], facts["origin"] = geometry.resolution, geometry.origin
            arrays["cells"] = self._world.cells
        self._kept.save(State(facts | {"since_ns": self._since_ns}, arrays))

    def go_on_after_crash(self) -> bool:
        """Go on from what a crashed mapper kept, if there is anything; say whether there was."""
        state = self._kept.load()
        if state is None:
            return False
        try:
            self._go_on_from(state)
        except (KeyError, TypeError, ValueError, NoMethodError) as error:
            self._node.warn("memory", f"begins anew: what was kept does not fit ({error})")
            return False
        return True

    def _go_on_from(self, state: State) -> None:
        facts, sensor = state.facts, state.facts["sensor"]
        session = None
        if sensor is not None:
            with self._node.busy(WORK_S):
                session = MappingSession(self._make(sensor))
                resume_session(session, state.arrays)
        self._since_ns = int(facts["since_ns"])
        if facts["mode"] == "mapping":
            self.session, self.sensor = session, sensor
            self._begin_mapping(is_new=False)
            return
        cells = state.arrays["cells"].astype(np.int8)
        x, y, theta = (float(value) for value in facts["origin"])
        rows, cols = cells.shape
        geometry = GridGeometry(rows, cols, float(facts["resolution"]), (x, y, theta))
        self._use(OccupancyMap(geometry, cells), str(facts["name"]), session, sensor)

    def _begin_session(self, sensor: MappingSensor) -> None:
        try:
            with self._node.busy(WORK_S):
                self.session = MappingSession(self._make(sensor))
        except NoMethodError as error:
            raise RefusedError(str(error)) from error
        self.sensor = sensor

    def _begin_mapping(self, *, is_new: bool = True) -> None:
        with self._node.busy(WORK_S):
            warm_up()
        if is_new:
            self._since_ns = self._node.clock.now_ns()
        self._handover, self.mode = None, "mapping"
        self.show.begin()
        self.say_status()
        self.keep()

    def _use(
        self,
        world: OccupancyMap,
        name: str,
        session: MappingSession | None,
        sensor: MappingSensor | None,
    ) -> OccupancyGrid:
        grid = self.show.checked(world, name)
        self._world, self._name = world, name
        self.session, self.sensor = session, sensor
        self._handover = None
        self.show.serve(grid)
        self.say_status()
        return grid

    def _hand_over(self, grid: OccupancyGrid) -> None:
        """Say with what the localizer shall begin on the finished map."""
        self.mode, self._handed_at = "handing_over", self._node.clock.monotonic()
        self._handover = self._last_word(grid.map_id)
        self.show.map_id = grid.map_id
        self.say_status()

    def _end_hand_over(self) -> None:
        if self.session is not None:
            self._handover = self._last_word(self.show.map_id)
        self.mode = "idle"
        self.say_status()
        self.keep()

    def _last_word(self, map_id: str) -> Handover | None:
        session = self.session
        if session is None or session.newest is None:
            return None
        pose, covariance = session.pose(), session.covariance()
        if pose is None or covariance is None:
            return None
        return Handover(
            map_id=map_id,
            pose=pose_of(pose),
            covariance=covariance,
            odom_from_base=pose_of(session.newest.pose),
            stamp_ns=session.newest.stamp_ns,
        )

    def _session_of(self, content: bytes) -> tuple[MappingSensor | None, MappingSession | None]:
        """Return the run that a stored map was made by; without it the map can still be used."""
        try:
            sensor, arrays = unpacked_session(content)
            session = MappingSession(self._make(sensor))
            resume_session(session, arrays)
        except (ValueError, NoMethodError) as error:
            self._node.warn("library", f"mapping cannot go on with this map: {error}")
            return None, None
        session.newest = None
        return sensor, session

    def _require_idle(self) -> None:
        if self.mode == "mapping":
            raise RefusedError("a map is being made: stop that first (map_stop)")
        if self.mode == "handing_over":
            raise RefusedError("the localizer is about to take over: try again in a moment")

    def _see_presence(self, service: str, is_present: bool) -> None:  # noqa: FBT001 - the node's signature
        (self._others.add if is_present else self._others.discard)(service)
