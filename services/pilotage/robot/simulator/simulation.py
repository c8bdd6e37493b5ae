"""A robot in its world, moved on in steps of 10 ms; pure."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.landmark_map import NO_LANDMARKS, LandmarkMap
from pilotage.core.motion import arc
from pilotage.robot.simulator.camera import Camera, CameraParams
from pilotage.robot.simulator.doors import Doors
from pilotage.robot.simulator.drive import (
    DriveParams,
    SlipParams,
    Wheels,
    accelerated,
    ground_twist,
    slipped,
)
from pilotage.robot.simulator.people import People
from pilotage.robot.simulator.picture_params import PictureParams
from pilotage.robot.simulator.range_sensors import (
    CompassParams,
    LaserParams,
    SonarParams,
    Surroundings,
)
from pilotage.robot.simulator.walls import Walls
from pilotage.robot.simulator.wheel_odometry import WheelOdometry, WheelOdometryParams

TICK_S = 0.01
TICKS_OF_A_PERSON = 10
KIDNAP_DISTANCE = 2.0
"""A robot put nearer than this, in m, to where it was has hardly been kidnapped."""
CONTACT = 0.005
"""Gap in m below which a body counts as touching."""


@dataclass(frozen=True)
class RobotParams:
    """All parameters of the simulated robot.

    `camera` None: it has one if its world has landmarks or doors. `picture` None: that camera
    takes pictures if its world has doors.
    """

    drive: DriveParams = field(default_factory=DriveParams)
    slip: SlipParams = field(default_factory=SlipParams)
    odometry: WheelOdometryParams = field(default_factory=WheelOdometryParams)
    laser: LaserParams = field(default_factory=LaserParams)
    sonar: SonarParams = field(default_factory=SonarParams)
    compass: CompassParams = field(default_factory=CompassParams)
    camera: CameraParams | None = None
    picture: PictureParams | None = None


class NoPlaceError(ValueError):
    """The robot cannot stand there; the text says why."""


class Simulation:
    """State of the robot and of the people round it. Poses are (3,) in the map frame."""

    def __init__(
        self,
        walls: Walls,
        params: RobotParams,
        people: int,
        rng: np.random.Generator,
        landmarks: LandmarkMap = NO_LANDMARKS,
    ) -> None:
        self.walls = walls
        self.params = params
        self.rng = rng
        self.pose = np.zeros(3)
        self.wheels = Wheels()
        self.twist = (0.0, 0.0)
        self.contact: float | None = None
        self.odometry = WheelOdometry(params.odometry, rng)
        self.people = People(walls, people, rng)
        self.camera = _camera(params, landmarks, walls.doors)
        self._wanted = (0.0, 0.0)
        self._counted = np.zeros(2)
        self._ticks = 0

    @property
    def surroundings(self) -> Surroundings:
        """What beams meet now."""
        return Surroundings(self.walls, self.people.discs)

    def want(self, linear: float, angular: float) -> None:
        """Set the wheels' target, m/s and rad/s."""
        self._wanted = (linear, angular)

    def put(self, pose: NDArray[np.float64]) -> None:
        """Put the robot down, standing; its odometry does not notice. NoPlaceError if it cannot."""
        x, y, theta = (float(value) for value in pose)
        if self.walls.overlaps(x, y, self.params.drive.radius):
            raise NoPlaceError(self._obstacle_at(x, y))
        self.pose = np.array([x, y, wrap(theta)])
        self.wheels, self.twist, self._wanted = Wheels(), (0.0, 0.0), (0.0, 0.0)
        self.contact = None

    @cached_property
    def _places(self) -> NDArray[np.float64]:
        """Where it may be put down at random (n, 2), map frame; half a second's work on a floor."""
        return self.walls.places(self.params.drive.radius + 0.15)

    def put_anywhere(self) -> None:
        """Put the robot down at a random place at least 2 m from where it is."""
        is_far = np.hypot(*(self._places - self.pose[:2]).T) >= KIDNAP_DISTANCE
        if not is_far.any():
            raise NoPlaceError("the map has no free place at least 2 m away that the robot fits in")
        x, y = self.rng.choice(self._places[is_far])
        self.put(np.array([x, y, self.rng.uniform(-np.pi, np.pi)]))

    def tick(self) -> None:
        """Let 10 ms pass."""
        self._ticks += 1
        wheels = accelerated(self.wheels, self._wanted, self.params.drive, TICK_S)
        self.wheels = slipped(wheels, self.params.slip, TICK_S, self.rng)
        self.twist = ground_twist(self.wheels, self.params.slip)
        self._move()
        if self.camera is not None:
            self.camera.turn(TICK_S)
        if self._ticks % TICKS_OF_A_PERSON == 0:
            self.people.walk(self.pose, TICK_S * TICKS_OF_A_PERSON, self.rng)

    def count_wheels(self) -> None:
        """Let the odometry read what the wheels did since the last time."""
        self.odometry.count(float(self._counted[0]), float(self._counted[1]))
        self._counted[:] = 0.0

    def _move(self) -> None:
        linear, angular = self.twist
        if linear == 0.0 and angular == 0.0:
            return
        moved = arc(self.pose, linear, angular, TICK_S)
        obstacle = self._blocking(moved)
        if obstacle is None:
            self._counted += (self.wheels.linear * TICK_S, self.wheels.angular * TICK_S)
            self.pose = moved
        else:
            # A disc can always turn where it stands, so only the way is lost, not the turn.
            self.pose[2] = wrap(self.pose[2] + angular * TICK_S)
            self._counted[1] += self.wheels.angular * TICK_S
            self.wheels = Wheels(angular=self.wheels.angular)
            self.twist = (0.0, angular)
        self._feel(obstacle)

    def _blocking(self, moved: NDArray[np.float64]) -> float | None:
        """Return the direction (map frame) of what a move would run into, None if it is free."""
        radius = self.params.drive.radius
        if self.walls.overlaps(moved[0], moved[1], radius):
            return self.walls.nearest(self.pose[0], self.pose[1], 2.0 * radius)[1]
        for x, y, size in self.people.discs:
            now, then = (
                np.hypot(x - self.pose[0], y - self.pose[1]),
                np.hypot(x - moved[0], y - moved[1]),
            )
            if then < radius + size and then < now:
                return float(np.arctan2(y - self.pose[1], x - self.pose[0]))
        return None

    def _feel(self, obstacle: float | None) -> None:
        """Press the bumper when running into something, release it when away from it."""
        if obstacle is not None:
            self.contact = wrap(obstacle - float(self.pose[2]))
        elif self.contact is not None and self._is_clear():
            self.contact = None

    def _is_clear(self) -> bool:
        reach = self.params.drive.radius + CONTACT
        if self.walls.overlaps(self.pose[0], self.pose[1], reach):
            return False
        discs = self.people.discs
        gaps = np.hypot(discs[:, 0] - self.pose[0], discs[:, 1] - self.pose[1]) - discs[:, 2]
        return bool((gaps > reach).all())

    def _obstacle_at(self, x: float, y: float) -> str:
        geometry = self.walls.geometry
        cells = geometry.cells_of([[x, y]])
        place = f"({x:.2f}, {y:.2f})"
        if not geometry.contains(cells)[0]:
            return f"{place} lies outside of the map"
        row, col = cells[0]
        if self.walls.stops_beams[row, col]:
            return f"{place} lies in a wall"
        if self.walls.stops_bodies[row, col]:
            return f"{place} lies on unknown ground"
        return f"at {place} the robot would touch a wall"


def _camera(params: RobotParams, landmarks: LandmarkMap, doors: Doors) -> Camera | None:
    """Return the camera that was asked for, or the usual one where there is something to see."""
    is_asked_for = params.camera is not None or params.picture is not None
    if not (is_asked_for or landmarks.classes or doors):
        return None
    return Camera(params.camera or CameraParams(), landmarks)
