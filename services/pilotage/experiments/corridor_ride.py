"""A robot that drives along a corridor with doors, with its odometry and a laser of 180 degrees.

It is steered along the middle line by what is true, as by somebody who watches it; what is tested
is whether it knows where it is. Time is simulated; people may walk about the corridor.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import OccupancyMap
from pilotage.robot.simulator.people import People
from pilotage.robot.simulator.range_sensors import LaserParams, scan
from pilotage.robot.simulator.simulation import TICK_S, RobotParams, Simulation
from pilotage.robot.simulator.walls import Walls

LASER = LaserParams(beams=361, field_of_view=float(np.pi), range_max=8.0, mount_x=0.10)
"""A SICK LMS 200: 180 degrees in steps of half a degree, 8 m in steps of a millimetre."""

ROBOT = RobotParams(laser=LASER)

SPEED = 0.4
"""m/s."""

WEAVE = 0.15
"""m by which the robot leaves the middle line on either side, for nobody steers exactly."""
WEAVE_LENGTH = 7.0
"""m from weave to weave."""

TO_LINE, TO_HEADING = 1.2, 1.8
"""How hard it is steered, rad/s per m and per rad."""

PATIENCE = 60.0
"""s to wait for people to let the robot pass."""


@dataclass(frozen=True)
class Look:
    """A scan (361,) m and the pose (3,) by odometry, its covariance (3, 3), and the true pose."""

    ranges: NDArray[np.float64]
    odom_from_base: NDArray[np.float64]
    odometry_covariance: NDArray[np.float64]
    truth: NDArray[np.float64]
    people: NDArray[np.float64]


class CorridorRide:
    """One ride from `start` (3,) in map, along x or against it as the start heads.

    `crowd` people walk about in the part of the floor that `busy` shows as free.
    """

    def __init__(
        self,
        floor: OccupancyMap,
        start: NDArray[np.float64],
        rng: np.random.Generator,
        crowd: tuple[int, OccupancyMap] | None = None,
    ) -> None:
        wheels, self._light, self._chance = rng.spawn(3)
        self._simulation = Simulation(Walls.of(floor), ROBOT, 0, wheels)
        self._simulation.put(start)
        if crowd is not None:
            self._simulation.people = People(Walls.of(crowd[1]), crowd[0], self._chance)
        self._phase = self._chance.uniform(0.0, 2.0 * np.pi)

    @property
    def truth(self) -> NDArray[np.float64]:
        """Where the robot is (3,), map frame."""
        return self._simulation.pose

    def look(self) -> Look:
        """Return what the robot measures now."""
        simulation = self._simulation
        simulation.count_wheels()
        ranges = scan(simulation.surroundings, simulation.pose, LASER, self._light)
        odometry = simulation.odometry
        return Look(
            ranges.astype(np.float64),
            odometry.pose.copy(),
            odometry.covariance.copy(),
            simulation.pose.copy(),
            simulation.people.discs,
        )

    def drive(self, way: float) -> None:
        """Drive on by so many metres, or until people have stood in the way for too long."""
        driven, waited = 0.0, 0.0
        while driven < way and waited < PATIENCE:
            before = self.truth[:2].copy()
            self._steer()
            for _ in range(10):
                self._simulation.tick()
            self._simulation.count_wheels()
            gone = float(np.hypot(*(self.truth[:2] - before)))
            driven += gone
            waited = waited + 10 * TICK_S if gone < 1e-4 else 0.0

    def turn_round(self) -> None:
        """Turn on the spot until the robot looks back along the corridor."""
        back = wrap(float(self._simulation.pose[2]) + np.pi)
        aim = 0.0 if np.cos(back) > 0.0 else np.pi
        while abs(left := wrap(aim - float(self.truth[2]))) > 0.05:
            self._simulation.want(0.0, 0.8 * np.sign(left))
            self._simulation.tick()
        self._simulation.count_wheels()

    def wait(self, seconds: float) -> None:
        """Stand still while people walk on."""
        self._simulation.want(0.0, 0.0)
        for _ in range(round(seconds / TICK_S)):
            self._simulation.tick()

    def collide(self, distance: float, turn: float) -> None:
        """Let something push the robot so many metres aside and turn it; odometry sees nothing.

        Where to and which way round is chance, as long as there is room.
        """
        clearance = ROBOT.drive.radius + 0.05
        for _ in range(1000):
            direction = self._chance.uniform(-np.pi, np.pi)
            spun = turn * self._chance.choice([-1.0, 1.0])
            push = distance * np.array([np.cos(direction), np.sin(direction)])
            pose = np.array([*(self.truth[:2] + push), wrap(float(self.truth[2]) + spun)])
            if not self._simulation.walls.overlaps(pose[0], pose[1], clearance):
                self._simulation.put(pose)
                return
        raise ValueError("there is no room to be pushed to")

    def _steer(self) -> None:
        """Set the wheels to drive along the middle line, weaving a little."""
        x, y, theta = self.truth
        ahead = 0.0 if np.cos(theta) > 0.0 else np.pi
        aim = WEAVE * np.sin(2.0 * np.pi * x / WEAVE_LENGTH + self._phase)
        off = (aim - y) * (1.0 if ahead == 0.0 else -1.0)
        wanted = np.clip(TO_LINE * off, -0.6, 0.6) - wrap(float(theta) - ahead)
        self._simulation.want(SPEED, float(np.clip(TO_HEADING * wanted, -1.0, 1.0)))


def increment_between(before: Look, after: Look) -> NDArray[np.float64]:
    """Return the motion (3,) by odometry from one look to the next, in the robot's frame."""
    return se2.between(before.odom_from_base, after.odom_from_base)
