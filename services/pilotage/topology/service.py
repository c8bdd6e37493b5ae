"""The topology service on the bus: a map and what the robot sees in; places, ways and poses out."""

import numpy as np

from pilotage.bus.deployment import Deployment
from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.topology import messages
from pilotage.topology.config import TopologySettings
from pilotage.topology.drive import Drive, Plan
from pilotage.topology.finding import Finder
from pilotage.topology.hearing import Glance, Hearing
from pilotage.topology.map_choice import WORK_S, MapChoice
from pilotage.topology.queries import Queries
from pilotage.topology.routes.floors import Floor
from pilotage.topology.storage import RunFolder, TopologyLibrary
from pilotage.topology.topological_map import TopologicalMap
from pilotage.topology.warm_up import warm_up
from pilotage_schemas.mapping import MappedPath, MappingStatus, OccupancyGrid
from pilotage_schemas.topology import TopologyBuild

MANY_STOPS = 2000
"""A drive of so many places takes a tenth of a second to keep; longer ones are kept less often."""


MOST_CORRECTING = 0.1
"""Share of the time that may go into moving what was built before."""


class TopologyService:
    """Owns the topological map: builds it, lets it grow, and finds the robot on it."""

    def __init__(self, settings: TopologySettings, node: Node, deployment: Deployment) -> None:
        self._settings = settings
        self._node = node
        with node.busy(WORK_S):
            warm_up()
        self._kept = RunFolder(deployment.run_dir, lambda text: node.warn("storage", text))
        library = TopologyLibrary(settings.library(deployment))
        self._at = MapChoice(node, settings, library, self._kept)
        self._plan = Plan(settings.spacing, settings.metres)
        self._drive: Drive | None = None
        self._follows = settings.build == "drive"
        self._status = MappingStatus(stamp_ns=0, frame_id="map", mode="idle")
        self._growing_id = ""
        self._has_grown = False
        self._path: MappedPath | None = None
        self._correct_at = 0.0
        self._shown_ns = self._kept_ns = 0
        self._finder: tuple[TopologicalMap, Finder] | None = None
        self._is_at_node = False
        self._arrivals = node.publisher("node_arrival")
        self._relocalizations = node.publisher("relocalization")
        self._pairs = node.publisher("matched_features")
        node.subscribe("mapping_status", self.take_mapping_status)
        node.subscribe("map", self.take_map)
        node.subscribe("mapped_path", self.take_path)
        self._hearing = Hearing(
            node, settings.scan_period, self._wants, self.take_glance, self.forget_way
        )
        Queries(node, self._at, self.build)

    def take_mapping_status(self, status: MappingStatus) -> None:
        """Begin a new drive with each new map in the making."""
        before, self._status = self._status, status
        if status.mode == "mapping" and before.since_ns != status.since_ns:
            self._begin_drive(self._plan, is_first=before.stamp_ns == 0)

    def take_map(self, grid: OccupancyGrid) -> None:
        """Use the topological map of a finished map; one in the making gives its name."""
        if grid.in_progress:
            self._growing_id = grid.map_id
        elif self._follows and self._drive is not None:
            self._at.grid = grid
            self._drive.finish()
            self._at.use(self._drive.floor(grid.map_id))
        else:
            self._at.take_map(grid, self._plan)

    def take_path(self, path: MappedPath) -> None:
        """Move what was built while driving to where the mapper now says that the robot was.

        That takes a millisecond for each place, so that of a long drive not every news is taken.
        """
        self._path = path
        if self._node.clock.monotonic() >= self._correct_at:
            self._correct()

    def take_glance(self, glance: Glance) -> None:
        """Let the map grow by what is seen, or find the robot on it."""
        if self._is_driving:
            if glance.state == "localized":
                self._grow(glance)
        elif self._at.floor is not None and self._status.mode == "idle":
            self._find(glance, self._at.floor.map)

    def forget_way(self) -> None:
        """Begin anew what odometry carried on: it is counted anew."""
        self._finder = None

    def build(self, request: TopologyBuild) -> Floor:
        """Build a map anew: from the map in use at once, or from now on while driving."""
        plan = Plan(request.spacing, request.metres or self._settings.metres)
        if request.source == "map":
            floor = self._at.built(plan)
            self._follows, self._plan = False, plan
            self._end_drive()
            self._at.use(floor)
            return floor
        if not self._map_id:
            raise RefusedError("there is no map yet: map_start begins one")
        self._follows, self._plan = True, plan
        self._begin_drive(plan, is_first=False)
        return self._at.required

    @property
    def _map_id(self) -> str:
        """The map that poses are in at present."""
        if self._status.mode == "mapping":
            return self._growing_id
        return "" if self._at.grid is None else self._at.grid.map_id

    @property
    def _is_driving(self) -> bool:
        is_mapping = self._status.mode == "mapping"
        return self._drive is not None and bool(self._map_id) and (is_mapping or self._follows)

    def _wants(self) -> bool:
        return self._is_driving or self._at.floor is not None

    def _begin_drive(self, plan: Plan, *, is_first: bool) -> None:
        """Begin to build while driving; `is_first`: this process may be a restarted one."""
        self._drive = self._resumed() if is_first else None
        if self._drive is None:
            self._drive = Drive(plan)
            self._kept.forget_drive()
            self._at.show(self._drive.floor(self._map_id))
        self._has_grown = len(self._drive) > 0

    def _end_drive(self) -> None:
        self._drive = None
        self._kept.forget_drive()

    def _resumed(self) -> Drive | None:
        arrays = self._kept.load_drive()
        if arrays is None:
            return None
        try:
            with self._node.busy(WORK_S):
                return Drive.resumed(arrays)
        except (KeyError, ValueError) as error:
            self._node.warn("storage", f"the drive is ignored: {error}")
            return None

    def _correct(self) -> None:
        path, self._path = self._path, None
        if self._drive is None or path is None or path.map_id != self._map_id:
            return
        stamps = path.stamp_ns / 1e9 - path.ages.astype(float)
        order = np.unique(stamps, return_index=True)[1]
        began = self._node.clock.monotonic()
        with self._node.busy(WORK_S):
            if self._drive.correct(stamps[order], path.poses[order].astype(float)):
                self._has_grown = True
        ended = self._node.clock.monotonic()
        self._correct_at = ended + (ended - began) / MOST_CORRECTING

    def _find(self, glance: Glance, world: TopologicalMap) -> None:
        """Tell at which node the robot is, what of it is seen, and where it is if that was lost."""
        if self._finder is None or self._finder[0] is not world:
            self._finder = (world, Finder(world, self._at.cells))
        stamp_ns = glance.stamp_ns
        finding = self._finder[1].look(glance.sight)
        if finding.node is not None and finding.is_new:
            self._arrivals.publish(messages.arrival_message(finding.node, finding, stamp_ns))
        if finding.found is not None and self._settings.relocalizes:
            found = messages.relocalization_message(finding.found, world.map_id, stamp_ns)
            self._relocalizations.publish(found)
        is_at_node = finding.node is not None
        if is_at_node or self._is_at_node:
            self._pairs.publish(messages.pairs_message(finding, stamp_ns))
        self._is_at_node = is_at_node

    def _grow(self, glance: Glance) -> None:
        assert self._drive is not None  # noqa: S101 - it is driving
        stamp_ns = glance.stamp_ns
        if self._path is not None and self._node.clock.monotonic() >= self._correct_at:
            self._correct()
        added = self._drive.add(stamp_ns / 1e9, glance.map_from_base, glance.seen)
        self._has_grown = self._has_grown or added
        show_ns = round(self._settings.show_period * 1e9)
        if self._has_grown and abs(stamp_ns - self._shown_ns) >= show_ns:
            self._has_grown, self._shown_ns = False, stamp_ns
            self._at.show(self._drive.floor(self._map_id))
        keep_ns = self._settings.keep_period * 1e9 * max(1.0, len(self._drive) / MANY_STOPS)
        if abs(stamp_ns - self._kept_ns) >= keep_ns:
            self._kept_ns = stamp_ns
            self._kept.save_drive(self._drive.remember())
