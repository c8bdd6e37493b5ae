"""The localizer on the bus: odometry, scans, ranges, compass and a map in; pose and belief out."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pilotage.bus.deployment import Deployment
from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.odometry_buffer import OdometryBuffer
from pilotage.localizer import storage
from pilotage.localizer.compass_memory import CompassMemory
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.measurement import (
    Measurement,
    ranges_measurement,
    scan_measurement,
)
from pilotage.localizer.messages import belief_message, pose_message
from pilotage_schemas.commands import Done, Nothing, SetAlgorithm, SetPose
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.mapping import OccupancyGrid
from pilotage_schemas.sensors import Heading, LaserScan, Odometry, RobotDescription, SonarScan

MAP_WORK_S = 60.0
"""Limit for taking in a map: the tables of a large building take a while."""

POSE_PERIOD_NS = 90_000_000
MEMORY_PERIOD_NS = 1_000_000_000
EXTRAPOLATION_NS = 100_000_000
FASTEST = 5.0
"""Odometry that moves faster than this [m/s] has been started anew."""

ASSUMED = np.diag([0.25, 0.25, np.deg2rad(15.0) ** 2])


class LocalizerService:
    """Feeds a MarkovLocalizer from the bus and publishes what it believes."""

    def __init__(self, settings: LocalizerSettings, node: Node, deployment: Deployment) -> None:
        self._settings = settings
        self._node = node
        self._folder = deployment.run_dir
        self._localizer: MarkovLocalizer | None = None
        self._map_id = ""
        self._odometry = OdometryBuffer()
        self._odometry_seq = 0
        self._compass = CompassMemory()
        self._mounts: dict[str, NDArray[np.float64]] = {}
        self._waiting: tuple[int, Measurement] | None = None
        self._sent_ns = {"pose": 0, "belief": 0, "memory": 0}
        self._pose = node.publisher("pose")
        self._belief = node.publisher("belief")
        node.subscribe("map", self.take_map)
        node.subscribe("description", self.take_description)
        node.subscribe("odometry", self.take_odometry, depth=64)
        self._subscribe_sensors()
        node.answer("set_pose", self.set_pose)
        node.answer("relocalize", self.relocalize)
        node.answer("set_algorithm", self.set_algorithm)

    def take_map(self, grid: OccupancyGrid) -> None:
        """Begin on this map: from the memory of a crashed run, or from anywhere."""
        if grid.map_id == self._map_id:
            return
        try:
            with self._node.busy(MAP_WORK_S):
                self._localizer = self._localizer_on(grid)
        except ValueError as error:
            self._node.warn("map", f"kept the old one: {error}")
            return
        self._map_id = grid.map_id
        self._waiting = None
        self._send_belief_now()

    def take_description(self, description: RobotDescription) -> None:
        """Note where the sensors sit."""
        self._mounts = {m.frame_id: _array(m.pose) for m in description.mounts}

    def take_odometry(self, odometry: Odometry) -> None:
        """Move the pose on, and weigh a measurement that waited for this odometry."""
        pose = _array(odometry.pose)
        self._notice_restart(odometry, pose)
        self._odometry.append(odometry.stamp_ns, pose)
        if self._waiting is not None:
            self._weigh(*self._waiting)
        self._send_pose(odometry.stamp_ns, pose)

    def take_scan(self, scan: LaserScan) -> None:
        """Weigh a laser scan; without the laser's mount it cannot be placed."""
        mount = self._mounts.get(scan.frame_id)
        if mount is None and self._mounts:
            self._node.warn("scan", f"the robot's description has no mount '{scan.frame_id}'")
        if mount is not None and self._localizer is not None:
            angles = scan.angle_min, scan.angle_increment
            beams = self._localizer.params.beams
            self._weigh(scan.stamp_ns, scan_measurement(scan.ranges, angles, mount, beams))

    def take_sonar(self, sonar: SonarScan) -> None:
        """Weigh one round of the sonar ring."""
        measurement = ranges_measurement(sonar.ranges, sonar.mounts, sonar.range_max)
        self._weigh(sonar.stamp_ns, measurement)

    def take_heading(self, heading: Heading) -> None:
        """Keep the compass's word for the next scan."""
        odom = self._odometry.pose_at(heading.stamp_ns, EXTRAPOLATION_NS)
        if odom is not None:
            self._compass.keep(heading.stamp_ns, (heading.yaw, heading.sigma), float(odom[2]))

    def set_pose(self, request: SetPose) -> Done:
        """Begin anew from a pose."""
        covariance = ASSUMED if request.covariance is None else request.covariance
        localizer = self._running()
        try:
            localizer.start_at(_array(request.pose), covariance)
        except (ValueError, np.linalg.LinAlgError) as error:
            raise RefusedError(str(error)) from error
        self._send_belief_now()
        return Done(detail="localizing from the given pose")

    def relocalize(self, _request: Nothing) -> Done:
        """Forget everything."""
        self._running().start_anywhere()
        self._send_belief_now()
        return Done(detail="localizing from an unknown pose")

    def set_algorithm(self, request: SetAlgorithm) -> Done:
        """Choose M1 or M2."""
        self._running().choose_algorithm(request.algorithm, request.recovery_weight)
        return Done(detail=f"algorithm {request.algorithm.upper()}")

    def _subscribe_sensors(self) -> None:
        sensors = {
            "laser": lambda: self._node.subscribe("scan", self.take_scan, depth=1),
            "sonar": lambda: self._node.subscribe("sonar", self.take_sonar, depth=1),
            "compass": lambda: self._node.subscribe("heading", self.take_heading),
        }
        for sensor in self._settings.sensors:
            sensors[sensor]()

    def _weigh(self, stamp_ns: int, measurement: Measurement) -> None:
        """Update the belief if that tells more; wait for the odometry of this moment if need be."""
        self._waiting = None
        localizer = self._localizer
        odom = self._odometry.pose_at(stamp_ns, EXTRAPOLATION_NS)
        if localizer is None:
            return
        if odom is None:
            self._waiting = (stamp_ns, measurement)
            return
        if localizer.wants(stamp_ns, odom, measurement):
            compass = self._compass.at(stamp_ns, float(odom[2]))
            localizer.update(stamp_ns, odom, measurement.with_compass(compass))
            self._send_belief(stamp_ns)
            self._save(stamp_ns)

    def _notice_restart(self, odometry: Odometry, pose: NDArray[np.float64]) -> None:
        """Begin a new odometry when it jumps, or when its messages are numbered anew."""
        is_renumbered = odometry.seq < self._odometry_seq
        self._odometry_seq = odometry.seq
        last = self._odometry.latest()
        if last is None:
            return
        seconds = (odometry.stamp_ns - last[0]) / 1e9
        way = float(np.hypot(*(pose[:2] - last[1][:2])))
        if is_renumbered or seconds < 0.0 or way > FASTEST * max(seconds, 0.05):
            self._node.warn("odometry", f"jumped {way:.2f} m in {seconds:.2f} s: counting anew")
            self._odometry.clear()
            self._compass = CompassMemory()
            if self._localizer is not None:
                self._localizer.restart_odometry()

    def _send_pose(self, stamp_ns: int, odom: NDArray[np.float64]) -> None:
        localizer = self._localizer
        if localizer is not None and self._is_due("pose", stamp_ns, POSE_PERIOD_NS):
            pose = localizer.pose_at(odom)
            self._pose.publish(pose_message(localizer.estimate, pose, stamp_ns))

    def _send_belief_now(self) -> None:
        self._sent_ns["belief"] = 0
        self._send_belief(self._node.clock.now_ns())

    def _send_belief(self, stamp_ns: int) -> None:
        period = round(self._settings.belief_period * 1e9)
        if self._localizer is not None and self._is_due("belief", stamp_ns, period):
            self._belief.publish(belief_message(self._localizer, self._map_id, stamp_ns))

    def _save(self, stamp_ns: int) -> None:
        folder = self._folder
        if folder is None or not self._is_due("memory", stamp_ns, MEMORY_PERIOD_NS):
            return
        memory = self._running().remember()
        if memory is not None:
            self._keep(lambda: storage.save_memory(folder, self._map_id, memory))

    def _keep(self, save: Callable[[], None]) -> None:
        """Write to the run folder; a full disk costs the memory, not the localization."""
        try:
            save()
        except OSError as error:
            self._node.warn("memory", f"not kept: {error}")

    def _is_due(self, what: str, stamp_ns: int, period_ns: int) -> bool:
        """Say whether `what` is due, by the stamps of the measurements; and count it as done."""
        if abs(stamp_ns - self._sent_ns[what]) < period_ns:
            return False
        self._sent_ns[what] = stamp_ns
        return True

    def _localizer_on(self, grid: OccupancyGrid) -> MarkovLocalizer:
        params, world, folder = self._settings.params(), _world(grid), self._folder
        if folder is None:
            return MarkovLocalizer(world, params)
        sight = storage.load_sight(folder, grid.map_id, params)
        localizer = MarkovLocalizer(world, params, sight)
        if sight is None:
            self._keep(lambda: storage.save_sight(folder, grid.map_id, params, localizer.sight))
        memory = storage.load_memory(folder, grid.map_id)
        if memory is not None:
            localizer.resume(memory)
        return localizer

    def _running(self) -> MarkovLocalizer:
        if self._localizer is None:
            raise RefusedError("there is no map yet")
        return self._localizer


def _array(pose: Pose2) -> NDArray[np.float64]:
    return np.array([pose.x, pose.y, pose.theta])


def _world(grid: OccupancyGrid) -> OccupancyMap:
    rows, cols = grid.cells.shape
    origin = (grid.origin.x, grid.origin.y, grid.origin.theta)
    return OccupancyMap(GridGeometry(rows, cols, grid.resolution, origin), grid.cells)
