"""What the planner listens to, and what it makes of it."""

from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pilotage.bus.node import Node
from pilotage.core.odometry_watch import OdometrySample
from pilotage.planner import messages
from pilotage.planner.knowledge import Knowledge
from pilotage.planner.robot_facts import RobotFacts
from pilotage.planner.situation import Situation
from pilotage_schemas.localization import Belief, PoseEstimate
from pilotage_schemas.mapping import MappingStatus, OccupancyGrid
from pilotage_schemas.sensors import LaserScan, Odometry, RobotDescription, RobotStatus, SonarScan


class Listener(Protocol):
    """Who is told what cannot wait for the next step."""

    def robot_or_map_changed(self) -> None:
        """Another map is in use, or the robot is another."""
        ...

    def map_begun(self) -> None:
        """A map is being made."""
        ...

    def robot_said(self) -> None:
        """The robot has said what it does."""
        ...


@dataclass
class Hearing:
    """The newest of everything; `places` (n, 2): the modes of the belief in its order."""

    node: Node
    listener: Listener
    facts: RobotFacts = field(default_factory=RobotFacts)
    knowledge: Knowledge = field(default_factory=Knowledge)
    map: OccupancyGrid | None = None
    map_fault: str | None = None
    """Why nobody can plan on the map, in words."""
    is_mapping: bool = False
    places: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))

    def begin(self) -> None:
        """Listen from now on."""
        node = self.node
        node.subscribe("description", self.take_description)
        node.subscribe("status", self.take_status)
        node.subscribe("mapping_status", self.take_mapping_status)
        node.subscribe("map", self.take_map)
        node.subscribe("odometry", self.take_odometry, depth=64)
        node.subscribe("scan", self.take_scan, depth=1)
        node.subscribe("sonar", self.take_sonar, depth=1)
        node.subscribe("pose", self.take_pose, depth=1)
        node.subscribe("belief", self.take_belief, depth=1)

    def obstacle(self) -> str | None:
        """Say why the robot cannot be driven now; None if it can."""
        if self.facts.obstacle is not None:
            return self.facts.obstacle
        if self.is_mapping:
            return "a map is being made: finish it first"
        if self.map is None:
            return "there is no map yet"
        if self.map_fault is not None:
            return self.map_fault
        return self.knowledge.missing(self.node.clock.monotonic(), self.map.map_id)

    def situation(self) -> Situation | None:
        """Return what is known now; None if there is an obstacle."""
        if self.map is None or self.obstacle() is not None:
            return None
        return self.knowledge.situation(self.node.clock.monotonic(), self.map.map_id)

    def take_description(self, description: RobotDescription) -> None:
        """Note how the robot is built."""
        before, now = self.facts.build, messages.build_of(description)
        self.facts.build = now if before is None else replace(now, sight=before.sight)
        if repr(before) != repr(self.facts.build):
            self.listener.robot_or_map_changed()

    def take_status(self, status: RobotStatus) -> None:
        """Note what the robot says."""
        self.facts.said = messages.said_by(status)
        self.listener.robot_said()

    def take_mapping_status(self, status: MappingStatus) -> None:
        """Note whether a map is being made."""
        was_mapping, self.is_mapping = self.is_mapping, status.mode != "idle"
        if self.is_mapping and not was_mapping:
            self.listener.map_begun()

    def take_map(self, grid: OccupancyGrid) -> None:
        """Note that another map is in use; one in the making is not."""
        if grid.in_progress or (self.map is not None and grid.map_id == self.map.map_id):
            return
        self.map = grid
        self.knowledge.forget_place()
        self.listener.robot_or_map_changed()

    def take_odometry(self, odometry: Odometry) -> None:
        """Follow how the robot moves."""
        pose = messages.pose_array(odometry.pose)
        sample = OdometrySample(odometry.seq, odometry.stamp_ns, pose)
        self.knowledge.hear_odometry(sample, self.node.clock.monotonic())

    def take_scan(self, scan: LaserScan) -> None:
        """Note what the laser sees."""
        lasers = {} if self.facts.build is None else self.facts.build.lasers
        mount = lasers.get(scan.frame_id)
        view = None if mount is None else messages.laser_view(scan, mount)
        if view is not None:
            self.knowledge.hear_view(view, self.node.clock.monotonic())
            self._note_sight(scan.range_max)

    def take_sonar(self, sonar: SonarScan) -> None:
        """Note what the sonar ring sees, of a robot without a laser."""
        if self.facts.build is None or self.facts.build.lasers:
            return
        view = messages.sonar_view(sonar)
        if view is not None:
            self.knowledge.hear_view(view, self.node.clock.monotonic())
            self._note_sight(sonar.range_max)

    def take_pose(self, estimate: PoseEstimate) -> None:
        """Note where the robot is, and how sure that is."""
        self.knowledge.hear_estimate(messages.estimate_of(estimate), self.node.clock.monotonic())

    def take_belief(self, belief: Belief) -> None:
        """Note where the robot could be."""
        past = messages.belief_of(belief)
        if past is not None:
            self.knowledge.hear_belief(past)
            modes = [[mode.pose.x, mode.pose.y] for mode in belief.modes]
            self.places = np.array(modes).reshape(-1, 2)

    def _note_sight(self, metres: float) -> None:
        """Note how far the robot sees; what is expected to be seen depends on it."""
        build = self.facts.build
        if build is not None and build.sight != metres:
            self.facts.build = replace(build, sight=metres)
            self.listener.robot_or_map_changed()
