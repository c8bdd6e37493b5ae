"""The localizer on the bus: odometry, scans, ranges, compass and a map in; pose and belief out."""

import numpy as np
from numpy.typing import NDArray

from pilotage.bus.deployment import Deployment
from pilotage.bus.endpoints import RejectedError
from pilotage.bus.node import Node
from pilotage.core.grid import OccupancyMap
from pilotage.core.odometry_buffer import OdometryBuffer
from pilotage.core.odometry_watch import OdometrySample, restart_between
from pilotage.localizer.compass_memory import CompassMemory
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.ekf_localizer import EkfLocalizer
from pilotage.localizer.localization import Localization
from pilotage.localizer.map_choice import MapChoice
from pilotage.localizer.measurement import (
    Measurement,
    landmarks_measurement,
    ranges_measurement,
    scan_measurement,
)
from pilotage.localizer.messages import (
    belief_message,
    pairs_message,
    pose_array,
    pose_message,
    sightings_of,
)
from pilotage.localizer.method_setup import method_setup
from pilotage.localizer.queries import Queries
from pilotage.localizer.relocalization import SecondChance
from pilotage.localizer.storage import Choice, RunFolder, Snapshot
from pilotage.localizer.takeover import Takeover
from pilotage.localizer.warm_up import warm_up
from pilotage_schemas.mapping import MappingStatus
from pilotage_schemas.sensors import (
    Heading,
    LandmarkSightings,
    LaserScan,
    Odometry,
    RobotDescription,
    SonarScan,
)

MAP_WORK_S = 60.0
"""Limit for taking in a map: the tables of a large building take a while."""

POSE_PERIOD_NS = 90_000_000
PAIRS_PERIOD_NS = 190_000_000
MEMORY_PERIOD_NS = 1_000_000_000
EXTRAPOLATION_NS = 100_000_000

BLIND_NS = 2_000_000_000
"""Without any measurement for so long, odometry alone has to say how sure the pose still is."""


class LocalizerService:
    """Feeds a localization method from the bus and publishes what it believes."""

    def __init__(self, settings: LocalizerSettings, node: Node, deployment: Deployment) -> None:
        self._settings = settings
        self._node = node
        self._setup = method_setup(settings, lambda line: node.log.info("amcl_file: %s", line))
        with node.busy(MAP_WORK_S):
            warm_up()
        kept = RunFolder(deployment.run_dir, lambda text: node.warn("memory", text))
        chosen = settings.method, settings.algorithm, settings.recovery_weight
        usual = Choice(settings.model_dump_json(), *chosen)
        rng = np.random.default_rng(self._setup.seed)
        self._at = Localization(self._setup, kept, usual, rng)
        self._odometry = OdometryBuffer()
        self._newest: OdometrySample | None = None
        self._unsaid: OdometrySample | None = None
        self._compass = CompassMemory()
        self._mounts: dict[str, NDArray[np.float64]] = {}
        self._waiting: tuple[int, Measurement] | None = None
        self._weighed_ns = self._awake_ns = 0
        self._sent_ns = {"pose": 0, "belief": 0, "memory": 0, "pairs": 0}
        self._takeover = Takeover()
        self._pose = node.publisher("pose")
        self._belief = node.publisher("belief")
        self._pairs = node.publisher("matched_lines")
        node.subscribe("mapping_status", self.take_mapping_status)
        node.subscribe("description", self.take_description)
        node.subscribe("odometry", self.take_odometry, depth=64)
        self._subscribe_sensors()
        node.when_idle(self._send_pose)
        Queries(node, self._at, self._takeover, (self._send_belief_now, self._save_known))
        SecondChance(node, self._at, self._takeover, self._odometry, self._begun_anew)
        MapChoice(node, self._at, self._takeover, self._begin_on)

    def take_mapping_status(self, status: MappingStatus) -> None:
        """Fall silent while the mapper owns the pose; speak again when it leaves it."""
        self._takeover.take(status)
        self._pose.rest(is_resting=self._takeover.is_silent)
        self._belief.rest(is_resting=self._takeover.is_mapping)

    def take_description(self, description: RobotDescription) -> None:
        """Note where the sensors sit."""
        self._mounts = {m.frame_id: pose_array(m.pose) for m in description.mounts}

    def take_odometry(self, odometry: Odometry) -> None:
        """Move the pose on, and weigh a measurement that waited for this odometry."""
        now = OdometrySample(odometry.seq, odometry.stamp_ns, pose_array(odometry.pose))
        self._notice_restart(now)
        self._odometry.append(now.stamp_ns, now.pose)
        self._unsaid = now
        if self._waiting is not None:
            self._weigh(*self._waiting)
        elif self._is_blind(now.stamp_ns):
            self._weigh(now.stamp_ns, Measurement())

    def _is_blind(self, now_ns: int) -> bool:
        """Say whether sensors have been silent for long, an earlier run's time not counted."""
        self._awake_ns = self._awake_ns or now_ns
        since = max(self._weighed_ns, self._awake_ns)
        return self._weighed_ns > 0 and since < now_ns - BLIND_NS

    def take_scan(self, scan: LaserScan) -> None:
        """Weigh a laser scan; without the laser's mount it cannot be placed."""
        self._refuse_late("scan", scan.stamp_ns)
        mount, method = self._mount("scan", scan.frame_id), self._at.method
        if mount is not None and method is not None:
            angles = scan.angle_min, scan.angle_increment
            beams, reach = method.params.beams, scan.range_max
            measurement = scan_measurement(scan.ranges, angles, mount, beams, reach)
            self._weigh(scan.stamp_ns, measurement)

    def take_sonar(self, sonar: SonarScan) -> None:
        """Weigh one round of the sonar ring."""
        self._refuse_late("sonar", sonar.stamp_ns)
        measurement = ranges_measurement(sonar.ranges, sonar.mounts, sonar.range_max)
        self._weigh(sonar.stamp_ns, measurement)

    def take_landmarks(self, seen: LandmarkSightings) -> None:
        """Weigh the landmarks of one picture; one that shows none says nothing."""
        self._refuse_late("landmarks", seen.stamp_ns)
        mount = self._mount("landmarks", seen.frame_id)
        if mount is not None and seen.sightings:
            self._weigh(seen.stamp_ns, landmarks_measurement(sightings_of(seen), mount))

    def take_heading(self, heading: Heading) -> None:
        """Keep the compass's word for the next measurement."""
        odom = self._odometry.pose_at(heading.stamp_ns, EXTRAPOLATION_NS)
        if odom is not None:
            self._compass.keep(heading.stamp_ns, (heading.yaw, heading.sigma), float(odom[2]))

    def _subscribe_sensors(self) -> None:
        sensors = {
            "laser": lambda: self._node.subscribe("scan", self.take_scan, depth=1),
            "sonar": lambda: self._node.subscribe("sonar", self.take_sonar, depth=1),
            "compass": lambda: self._node.subscribe("heading", self.take_heading),
            "landmark": lambda: self._node.subscribe("landmarks", self.take_landmarks, depth=1),
        }
        for sensor in self._settings.sensors:
            sensors[sensor]()

    def _mount(self, topic: str, frame_id: str) -> NDArray[np.float64] | None:
        """Return the pose (3,) of a sensor on the robot; None, and a warning, if nobody said it."""
        if frame_id == "base_link":
            return np.zeros(3)
        mount = self._mounts.get(frame_id)
        if mount is None and self._mounts:
            self._node.warn(topic, f"the robot's description has no mount '{frame_id}'")
        return mount

    def _refuse_late(self, topic: str, stamp_ns: int) -> None:
        """Drop what was measured before what the belief already holds: it cannot be turned back."""
        if stamp_ns < self._weighed_ns:
            late = (self._weighed_ns - stamp_ns) / 1e9
            raise RejectedError(topic, f"measured {late:.3f} s before what was weighed already")

    def _weigh(self, stamp_ns: int, measurement: Measurement) -> None:
        """Update the belief if that tells more; wait for the odometry of this moment if need be."""
        self._waiting = None
        method = self._at.method
        odom = self._odometry.pose_at(stamp_ns, EXTRAPOLATION_NS)
        if method is None or stamp_ns < self._weighed_ns or self._takeover.is_mapping:
            return
        if odom is None:
            self._waiting = (stamp_ns, measurement)
            return
        if method.wants(stamp_ns, odom, measurement):
            # An update of a whole belief takes a while, and what comes in next may bring another.
            self._send_pose()
            compass = self._compass.at(stamp_ns, float(odom[2]))
            method.update(stamp_ns, odom, measurement.with_compass(compass))
            self._weighed_ns = stamp_ns
            self._send_belief(stamp_ns)
            self._send_pairs(stamp_ns)
            self._save(stamp_ns)

    def _begin_on(self, world: OccupancyMap, map_id: str) -> None:
        """Begin on a map, unless it is the one in use; ValueError if nobody can localize on it."""
        if map_id == self._at.map_id:
            return
        with self._node.busy(MAP_WORK_S):
            snapshot = self._at.begin_on(world, map_id)
        self._waiting, self._weighed_ns = None, 0
        handed_over = self._takeover.memory_on(map_id)
        if handed_over is not None and self._at.method is not None:
            self._at.method.resume(handed_over)
        elif snapshot is not None:
            self._go_on_from(snapshot)
        elif self._at.choice.method == "mcl" and self._setup.start is not None:
            self._begin_as_amcl(*self._setup.start)
        if handed_over is None:
            self._send_belief_now()

    def _go_on_from(self, snapshot: Snapshot) -> None:
        """See whether odometry is still the one that the snapshot speaks of."""
        memory = snapshot.memory
        then = OdometrySample(snapshot.odometry_seq, memory.stamp_ns, memory.odom_from_base)
        if self._newest is None:
            self._newest, self._weighed_ns = then, memory.stamp_ns
        else:
            self._odometry_went_on(then, self._newest)

    def _begin_as_amcl(self, pose: NDArray[np.float64], covariance: NDArray[np.float64]) -> None:
        try:
            if self._at.method is not None:
                self._at.method.start_at(pose, covariance)
        except (ValueError, np.linalg.LinAlgError) as error:
            self._node.warn("amcl_file", f"its initial pose is ignored: {error}")

    def _notice_restart(self, now: OdometrySample) -> None:
        """Begin a new odometry when it jumps, or when its messages are numbered anew."""
        before, self._newest = self._newest, now
        if before is not None and not self._odometry_went_on(before, now):
            self._odometry.clear()
            self._compass = CompassMemory()

    def _odometry_went_on(self, before: OdometrySample, now: OdometrySample) -> bool:
        reason = restart_between(before, now)
        if reason is None:
            return True
        self._node.warn("odometry", reason)
        self._weighed_ns = 0
        if self._at.method is not None:
            self._at.method.restart_odometry()
        return False

    def _send_pose(self) -> None:
        """Publish the pose at the newest odometry, if that is due."""
        now, self._unsaid = self._unsaid, None
        method = self._at.method
        if now is None or method is None or self._takeover.is_silent:
            return
        if self._is_due("pose", now.stamp_ns, POSE_PERIOD_NS):
            pose = method.pose_at(now.pose)
            self._pose.publish(pose_message(method.estimate, pose, now.stamp_ns))

    def _send_belief_now(self) -> None:
        self._sent_ns["belief"] = 0
        self._send_belief(self._node.clock.now_ns())

    def _send_belief(self, stamp_ns: int) -> None:
        period = round(self._settings.belief_period * 1e9)
        method = self._at.method
        if method is None or self._takeover.is_mapping:
            return
        if self._is_due("belief", stamp_ns, period):
            self._belief.publish(belief_message(method, self._at.map_id, stamp_ns))

    def _send_pairs(self, stamp_ns: int) -> None:
        """Publish what the filter matched, also that it was nothing."""
        method = self._at.method
        if isinstance(method, EkfLocalizer) and self._is_due("pairs", stamp_ns, PAIRS_PERIOD_NS):
            self._pairs.publish(pairs_message(method.matched, stamp_ns))

    def _begun_anew(self) -> None:
        self._send_belief_now()
        self._save_known()

    def _save_known(self) -> None:
        self._at.save_known(self._newest)

    def _save(self, stamp_ns: int) -> None:
        if self._newest is not None and self._is_due("memory", stamp_ns, MEMORY_PERIOD_NS):
            self._at.save(self._newest.seq)

    def _is_due(self, what: str, stamp_ns: int, period_ns: int) -> bool:
        """Say whether `what` is due, by the stamps of the measurements; and count it as done."""
        if abs(stamp_ns - self._sent_ns[what]) < period_ns:
            return False
        self._sent_ns[what] = stamp_ns
        return True
