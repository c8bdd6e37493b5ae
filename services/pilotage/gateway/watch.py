"""Tells what happened by comparing each message with the one before it."""

from pilotage.gateway.event_log import EventLog, Severity
from pilotage_schemas.health import Deployment, Process
from pilotage_schemas.localization import PoseEstimate
from pilotage_schemas.mapping import MappingStatus, OccupancyGrid
from pilotage_schemas.message import Message
from pilotage_schemas.planning import PlanningStatus
from pilotage_schemas.topology import NodeArrival, Relocalization, TopologicalMap

STATE_WORDS = {
    "unknown": "Searching: it could be anywhere",
    "ambiguous": "Ambiguous: several places fit",
    "localized": "Localized",
    "lost": "Lost: what it sees does not fit the map",
}
STATE_SEVERITY: dict[str, Severity] = {"lost": "warning", "ambiguous": "warning"}
PROCESS_SEVERITY: dict[str, Severity] = {"late": "warning", "down": "fault", "given_up": "fault"}
FOUND_BY = {"recovered": "at a known place", "chain": "by a chain of places"}
SILENT_STARTS = frozenset({"starting", "ready"})
"""States of a process seen for the first time that are no news."""


class Watch:
    """Writes changes of state to the event log."""

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self._pose_state: str | None = None
        self._map_id: str | None = None
        self._mapping = MappingStatus(stamp_ns=0, frame_id="map", mode="idle")
        self._planning: tuple[str, str] | None = None
        self._topology: tuple[str, str, str] | None = None
        self._processes: dict[str, Process] = {}

    def see(self, message: Message, now_ns: int) -> None:
        """Compare a message with what was before."""
        match message:
            case PoseEstimate():
                self._see_pose(message, now_ns)
            case OccupancyGrid():
                self._see_map(message, now_ns)
            case MappingStatus():
                self._see_mapping(message, now_ns)
            case PlanningStatus():
                self._see_planning(message, now_ns)
            case TopologicalMap():
                self._see_topology(message, now_ns)
            case NodeArrival():
                self._see_arrival(message, now_ns)
            case Relocalization():
                self._see_relocalization(message, now_ns)
            case Deployment():
                for process in message.processes:
                    self._see_process(process, now_ns)

    def _see_pose(self, estimate: PoseEstimate, now_ns: int) -> None:
        state = estimate.state
        if state != self._pose_state:
            severity = STATE_SEVERITY.get(state, "info")
            self._events.append(now_ns, "localization", severity, STATE_WORDS[state])
        self._pose_state = state

    def _see_map(self, grid: OccupancyGrid, now_ns: int) -> None:
        if grid.in_progress:
            return
        if grid.map_id != self._map_id:
            rows, cols = grid.cells.shape
            width, height = cols * grid.resolution, rows * grid.resolution
            text = f"Map {grid.name} in use, {width:.0f} m x {height:.0f} m"
            self._events.append(now_ns, "map", "info", text)
        self._map_id = grid.map_id

    def _see_mapping(self, status: MappingStatus, now_ns: int) -> None:
        before, self._mapping = self._mapping, status
        if status.mode == "mapping" and before.since_ns != status.since_ns:
            self._events.append(now_ns, "map", "info", f"A map is made by {status.sensor}")
        elif status.mode == "mapping" and status.redraws > before.redraws:
            text = "Old poses were corrected: the map is drawn anew"
            self._events.append(now_ns, "map", "info", text)
        elif status.mode == "idle" and before.mode != "idle":
            text = f"The map is finished, of {status.steps} measurements"
            self._events.append(now_ns, "map", "info", text)

    def _see_planning(self, status: PlanningStatus, now_ns: int) -> None:
        """Tell what the planner begins, waits for and ends; how often it says so is no news."""
        before, self._planning = self._planning, (status.mode, status.outcome)
        if before == self._planning or (before is None and self._planning == ("idle", "none")):
            return
        is_trouble = status.mode == "waiting" or status.outcome in ("failed", "interrupted")
        severity: Severity = "warning" if is_trouble else "info"
        self._events.append(now_ns, "command", severity, f"Planner: {status.reason}")

    def _see_topology(self, world: TopologicalMap, now_ns: int) -> None:
        """Tell of another topological map; that one grows is no news."""
        # A map in the making has another id after each correction.
        of_map = world.map_id if world.built_from == "map" else ""
        before, self._topology = self._topology, (of_map, world.name, world.built_from)
        if before != self._topology:
            size = f"{len(world.nodes)} nodes, {len(world.edges)} ways"
            of = f" {world.name}" if world.name else ""
            text = f"Topological map{of} in use, built from the {world.built_from}: {size}"
            self._events.append(now_ns, "map", "info", text)

    def _see_arrival(self, arrival: NodeArrival, now_ns: int) -> None:
        place = arrival.name or f"node {arrival.node}"
        text = f"At {place}: {arrival.matched} of {arrival.bound} features seen again"
        self._events.append(now_ns, "place", "info", text)

    def _see_relocalization(self, found: Relocalization, now_ns: int) -> None:
        """Tell that a lost pose was found again; that one was corrected is no news."""
        if found.cause != "corrected":
            how = FOUND_BY[found.cause]
            text = f"Pose found again {how}, at node {found.node} by {found.matched} features"
            self._events.append(now_ns, "localization", "info", text)

    def _see_process(self, process: Process, now_ns: int) -> None:
        before = self._processes.get(process.name)
        self._processes[process.name] = process
        if before is None and process.state in SILENT_STARTS:
            return
        if before is None or _has_changed(before, process):
            severity = PROCESS_SEVERITY.get(process.state, "info")
            self._events.append(now_ns, "service", severity, _sentence(process))


def _has_changed(before: Process, now: Process) -> bool:
    return (before.state, before.restarts) != (now.state, now.restarts)


def _sentence(process: Process) -> str:
    name, reason = process.name, f": {process.reason}" if process.reason else ""
    tries = f"try {process.try_number} of {process.max_tries}"
    match process.state:
        case "starting":
            return f"{name} is starting, {tries}{reason}"
        case "ready":
            return f"{name} is ready"
        case "late":
            late_for = process.late_for or 0.0
            return f"{name} is late: no heartbeat for {late_for:.1f} s, limit {process.limit:g} s"
        case "down":
            return f"{name} is down{reason}; it is being restarted, {tries}"
        case "given_up":
            return f"{name} was given up after {process.try_number} tries{reason}"
        case "stopped":
            return f"{name} was stopped{reason}"
