"""The mapper on the bus: measurements in, a map that grows out; or a finished map, served.

It is in one of three modes. `idle`: it serves a map, the localizer owns `pose`. `mapping`: it
makes one and owns `pose`. `handing_over`: the map is finished and the localizer makes itself ready
on it; so that nobody is without a pose meanwhile, the mapper goes on by odometry until the
localizer's first belief on that map.
"""

from collections.abc import Callable
from contextlib import nullcontext

import numpy as np
from numpy.typing import NDArray

from pilotage.bus.deployment import ConfigError, Deployment
from pilotage.bus.endpoints import RejectedError
from pilotage.bus.node import Node
from pilotage.core.logs import Record
from pilotage.core.map_files import MapFileError
from pilotage.mapper.config import MapperSettings
from pilotage.mapper.map_choice import MapChoice
from pilotage.mapper.map_library import MapLibrary
from pilotage.mapper.mapping_session import LateError
from pilotage.mapper.messages import (
    command_record,
    heading_record,
    odometry_sample,
    pose_array,
    scan_record,
    sonar_record,
)
from pilotage.mapper.method import MappingMethod
from pilotage.mapper.methods import MappingSetup, make_method
from pilotage.mapper.queries import Queries
from pilotage.mapper.storage import StateFolder
from pilotage_schemas.localization import Belief, PoseEstimate
from pilotage_schemas.planning import VelocityCommand
from pilotage_schemas.sensors import Heading, LaserScan, Odometry, RobotDescription, SonarScan

LONG_STEP_S, LONG_WORK_S = 0.3, 30.0
"""After a step that took so long, further ones are announced: closing a loop takes a while."""

PATH_EVERY = 4
"""The way so far is shown with every fourth message of the map."""

MakeMethod = Callable[[str], MappingMethod]


def made_by_default(sensor: str) -> MappingMethod:
    """Return the method for a sensor with its own defaults."""
    return make_method(sensor, MappingSetup())


class MapperService:
    """Feeds a mapping run from the bus and shows what comes of it."""

    def __init__(
        self,
        settings: MapperSettings,
        node: Node,
        deployment: Deployment,
        make: MakeMethod = made_by_default,
    ) -> None:
        self._settings = settings
        self._node = node
        self._mounts: dict[str, NDArray[np.float64]] = {}
        self._slowest_s = 0.0
        self._shown_steps = self._shown_times = 0
        kept = StateFolder(deployment.run_dir, lambda text: node.warn("memory", text))
        self._at = MapChoice(node, kept, MapLibrary(settings.library(deployment)), make)
        self._listen()
        Queries(node, self._at)
        self._begin()
        node.when_idle(self._show_pose)
        node.every(settings.show_period, self._show_map)
        node.every(settings.keep_period, self._at.keep)
        node.every(1.0, self._at.see_to_hand_over)

    def take_description(self, description: RobotDescription) -> None:
        """Note where the sensors sit."""
        self._mounts = {mount.frame_id: pose_array(mount.pose) for mount in description.mounts}

    def take_odometry(self, odometry: Odometry) -> None:
        """Move on, and map what has waited for this odometry."""
        session, sample = self._at.session, odometry_sample(odometry)
        if session is None:
            return
        if self._at.mode != "mapping":
            session.newest = sample
            return
        began = self._node.clock.monotonic()
        announced = self._slowest_s > LONG_STEP_S
        with self._node.busy(LONG_WORK_S) if announced else nullcontext():
            restart = session.take_odometry(sample)
        self._slowest_s = max(self._slowest_s, self._node.clock.monotonic() - began)
        if restart is not None:
            self._node.warn("odometry", restart)

    def take_scan(self, scan: LaserScan) -> None:
        """Map a laser scan; without the laser's mount it cannot be placed."""
        mount = self._mount("scan", scan.frame_id)
        if mount is not None and self._at.sensor == "laser":
            self._take("scan", scan.stamp_ns, scan_record(scan, mount), scan.frame_id)

    def take_sonar(self, sonar: SonarScan) -> None:
        """Map one round of the sonar ring."""
        if self._at.sensor == "sonar":
            self._take("sonar", sonar.stamp_ns, sonar_record(sonar))

    def take_heading(self, heading: Heading) -> None:
        """Use the compass's word."""
        self._take("heading", heading.stamp_ns, heading_record(heading))

    def take_command(self, command: VelocityCommand) -> None:
        """Use what the robot was told to do."""
        self._take("velocity_command", command.stamp_ns, command_record(command))

    def take_pose(self, estimate: PoseEstimate) -> None:
        """Note where the localizer says that the robot is: mapping may go on from there."""
        if self._at.mode == "idle":
            is_sure = estimate.state == "localized"
            self._at.localized = pose_array(estimate.pose) if is_sure else None

    def take_belief(self, belief: Belief) -> None:
        """Leave the pose to the localizer once it believes something on the finished map."""
        self._at.take_over_by(belief.map_id)

    def _listen(self) -> None:
        node = self._node
        node.subscribe("description", self.take_description)
        node.subscribe("odometry", self.take_odometry, depth=64)
        node.subscribe("scan", self.take_scan, depth=4)
        node.subscribe("sonar", self.take_sonar, depth=4)
        node.subscribe("heading", self.take_heading)
        node.subscribe("velocity_command", self.take_command)
        node.subscribe("pose", self.take_pose, depth=1)
        node.subscribe("belief", self.take_belief, depth=1)

    def _begin(self) -> None:
        """Go on from a crash; else do what the settings say."""
        if self._at.go_on_after_crash():
            return
        try:
            if self._settings.map is not None:
                self._at.use_file(self._settings.map)
        except MapFileError as error:
            raise ConfigError(str(error)) from error
        if self._settings.mapping is not None:
            self._at.start(self._settings.mapping)
        else:
            self._at.say_status()

    def _take(self, topic: str, stamp_ns: int, record: Record, frame_id: str = "") -> None:
        if self._at.session is None or self._at.mode != "mapping":
            return
        try:
            self._at.session.take(f"{topic} {frame_id}", stamp_ns, record)
        except LateError as error:
            raise RejectedError(topic, str(error)) from error

    def _mount(self, topic: str, frame_id: str) -> NDArray[np.float64] | None:
        """Return the pose (3,) of a sensor on the robot; None, and a warning, if nobody said it."""
        if frame_id == "base_link":
            return np.zeros(3)
        mount = self._mounts.get(frame_id)
        if mount is None and self._mounts:
            self._node.warn(topic, f"the robot's description has no mount '{frame_id}'")
        return mount

    def _show_pose(self) -> None:
        """Publish the pose at the newest odometry, from the first measurement of the map on."""
        session = self._at.session
        if self._at.mode == "idle" or session is None or session.steps == 0:
            return
        pose = session.pose()
        if pose is not None and session.newest is not None:
            self._at.show.pose(pose, session.covariance(), session.newest.stamp_ns)

    def _show_map(self) -> None:
        """Publish what is new of the map, now and then with the way."""
        session = self._at.session
        if self._at.mode != "mapping" or session is None or session.steps == self._shown_steps:
            return
        self._shown_steps = session.steps
        self._at.show_growth(with_path=self._shown_times % PATH_EVERY == 0)
        self._shown_times += 1
