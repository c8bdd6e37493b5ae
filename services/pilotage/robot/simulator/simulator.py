"""The simulated robot as a driver: turns its state into messages at each sensor's rate."""

from collections.abc import Iterator
from types import TracebackType
from typing import TYPE_CHECKING, Self

import numpy as np

from pilotage.core import se2
from pilotage.robot.driver import DriverError, Measurement
from pilotage.robot.simulator.camera import Camera
from pilotage.robot.simulator.description import description_of
from pilotage.robot.simulator.range_sensors import compass_yaw, scan, sonar_round
from pilotage.robot.simulator.simulation import TICK_S, NoPlaceError, Simulation
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.sensors import (
    Bumper,
    GroundTruth,
    Heading,
    Landmark,
    LandmarkSightings,
    LaserScan,
    Odometry,
    RobotDescription,
    SonarScan,
)

if TYPE_CHECKING:
    from pilotage.robot.simulator.eye import Eye

TICK_NS = round(TICK_S * 1e9)
ODOMETRY_EVERY, SENSORS_EVERY, PICTURE_EVERY = 5, 10, 20
"""Ticks between two samples: 20 Hz, 10 Hz and 5 Hz."""
SONAR_PHASE, COMPASS_PHASE, CAMERA_PHASE = 5, 3, 7
"""Ticks by which sonar, compass and camera follow the laser, so that the work is spread.

The picture in which edges are sought is taken with the scan: doors are where both agree."""
LARGEST_GAP_NS = 500_000_000
"""After a longer pause (a stopped process) the world goes on as if no time had passed."""


class Simulator:
    """A driver whose world moves on by wall-clock time, when it is asked what it sees."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._now_ns: int | None = None
        self._ticks = 0
        self._was_pressed: bool | None = None
        self._eye = _eye(simulation)

    def __enter__(self) -> Self:
        """There is nothing to open."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stand still."""
        self.stop()

    def describe(self) -> RobotDescription:
        """Return body, sensors and limits."""
        return description_of(self._simulation)

    def sense(self, now_ns: int) -> Iterator[Measurement]:
        """Move the world on to `now_ns` and return what the sensors measured on the way."""
        measured: list[Measurement] = []
        if self._now_ns is None or now_ns - self._now_ns > LARGEST_GAP_NS:
            self._now_ns = now_ns
        while now_ns - self._now_ns >= TICK_NS:
            self._now_ns += TICK_NS
            self._ticks += 1
            self._simulation.tick()
            measured.extend(self._measure(self._now_ns))
        return iter(measured)

    def drive(self, twist: Twist2) -> None:
        """Set the wheels' target from now on."""
        if twist.vy != 0.0:
            raise DriverError("a differential drive cannot move sideways")
        self._simulation.want(twist.vx, twist.omega)

    def stop(self) -> None:
        """Brake."""
        self._simulation.want(0.0, 0.0)

    def kidnap(self, pose: Pose2 | None) -> Pose2:
        """Carry the robot to `pose` or to a random free place; its odometry does not notice."""
        try:
            if pose is None:
                self._simulation.put_anywhere()
            else:
                self._simulation.put(np.array([pose.x, pose.y, pose.theta]))
        except NoPlaceError as error:
            raise DriverError(str(error)) from error
        return _pose(self._simulation.pose)

    def look(self, pan: float) -> None:
        """Turn the camera towards `pan` rad from now on, as far as its joint goes."""
        if self._simulation.camera is None:
            raise DriverError("this robot has no camera")
        self._simulation.camera.look(pan)

    def _measure(self, stamp_ns: int) -> Iterator[Measurement]:
        if self._ticks % ODOMETRY_EVERY == 0:
            yield Measurement("odometry", self._odometry(stamp_ns))
            yield Measurement("ground_truth", self._truth(stamp_ns))
        if self._ticks % SENSORS_EVERY == 0:
            yield Measurement("scan", self._scan(stamp_ns))
        if self._ticks % SENSORS_EVERY == SONAR_PHASE:
            yield Measurement("sonar", self._sonar(stamp_ns))
        if self._ticks % SENSORS_EVERY == COMPASS_PHASE:
            yield Measurement("heading", self._heading(stamp_ns))
        camera = self._simulation.camera
        is_time = self._ticks % PICTURE_EVERY == CAMERA_PHASE
        if camera is not None and camera.landmarks.classes and is_time:
            yield Measurement("landmarks", self._landmarks(camera, stamp_ns))
        if self._eye is not None and self._ticks % PICTURE_EVERY == 0:
            yield Measurement("vertical_edges", self._eye.edges(stamp_ns))
        if (self._simulation.contact is not None) != self._was_pressed:
            yield Measurement("bumper", self._bumper(stamp_ns))

    def _odometry(self, stamp_ns: int) -> Odometry:
        simulation = self._simulation
        simulation.count_wheels()
        wheels = simulation.wheels
        return Odometry(
            stamp_ns=stamp_ns,
            frame_id="odom",
            pose=_pose(simulation.odometry.pose),
            twist=Twist2(vx=wheels.linear, vy=0.0, omega=wheels.angular),
            covariance=simulation.odometry.covariance,
        )

    def _truth(self, stamp_ns: int) -> GroundTruth:
        linear, angular = self._simulation.twist
        return GroundTruth(
            stamp_ns=stamp_ns,
            frame_id="map",
            pose=_pose(self._simulation.pose),
            twist=Twist2(vx=linear, vy=0.0, omega=angular),
        )

    def _scan(self, stamp_ns: int) -> LaserScan:
        simulation = self._simulation
        params = simulation.params.laser
        bearings = params.bearings
        return LaserScan(
            stamp_ns=stamp_ns,
            frame_id="laser",
            angle_min=float(bearings[0]),
            angle_increment=params.field_of_view / max(params.beams - 1, 1),
            range_min=params.range_min,
            range_max=params.range_max,
            ranges=scan(simulation.surroundings, simulation.pose, params, simulation.rng),
        )

    def _sonar(self, stamp_ns: int) -> SonarScan:
        simulation = self._simulation
        params = simulation.params.sonar
        mounts = params.mounts(simulation.params.drive.radius)
        in_map = se2.compose(simulation.pose, mounts)
        return SonarScan(
            stamp_ns=stamp_ns,
            frame_id="base_link",
            mounts=mounts.astype(np.float32),
            ranges=sonar_round(simulation.surroundings, in_map, params, simulation.rng),
            cone=params.cone,
            range_min=params.range_min,
            range_max=params.range_max,
        )

    def _heading(self, stamp_ns: int) -> Heading:
        simulation = self._simulation
        params = simulation.params.compass
        yaw = compass_yaw(float(simulation.pose[2]), params, simulation.rng)
        return Heading(stamp_ns=stamp_ns, frame_id="map", yaw=yaw, sigma=params.sigma)

    def _landmarks(self, camera: Camera, stamp_ns: int) -> LandmarkSightings:
        simulation, params, known = self._simulation, camera.params, camera.landmarks
        seen = camera.picture(simulation.surroundings, simulation.pose, simulation.rng)
        sightings = [
            Landmark(
                kind=known.classes[which],
                range=float(distance),
                bearing=float(bearing),
                range_sigma=params.range_share * float(distance),
                bearing_sigma=params.bearing_sigma,
                identity=known.identities[which] if params.reads_identities else None,
            )
            for which, distance, bearing in zip(
                seen.landmarks, seen.ranges, seen.bearings, strict=True
            )
        ]
        return LandmarkSightings(stamp_ns=stamp_ns, frame_id="camera", sightings=tuple(sightings))

    def _bumper(self, stamp_ns: int) -> Bumper:
        bearing = self._simulation.contact
        self._was_pressed = bearing is not None
        return Bumper(
            stamp_ns=stamp_ns, frame_id="base_link", pressed=self._was_pressed, bearing=bearing
        )


def _pose(pose: "np.typing.NDArray[np.float64]") -> Pose2:
    x, y, theta = (float(value) for value in pose)
    return Pose2(x=x, y=y, theta=theta)


def _eye(simulation: Simulation) -> "Eye | None":
    """Return what looks for edges, if there are pictures."""
    camera = simulation.camera
    if camera is None or not (simulation.walls.doors or simulation.params.picture):
        return None
    # Imported here: most worlds have no pictures, and OpenCV takes a tenth of a second to load.
    from pilotage.robot.simulator.eye import Eye  # noqa: PLC0415 - start-up time

    return Eye(simulation, camera)
