"""A closed loop without a bus: a robot, a building that is as its map says, and the localizer.

What the map does not show as free stops beams and bodies. Time is simulated: a scan every 0.1 s,
after each of which whoever drives sets the speeds until the next.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.laser_view import View
from pilotage.experiments.clutter import CONDITIONS, altered
from pilotage.localizer.measurement import scan_measurement
from pilotage.localizer.method import LocalizationMethod
from pilotage.planner.situation import Hypotheses, Situation, Speeds, State
from pilotage.robot.simulator.range_sensors import LaserParams, scan
from pilotage.robot.simulator.simulation import TICK_S, RobotParams, Simulation
from pilotage.robot.simulator.walls import Walls

PERIOD_S = 0.1
"""Time between two scans."""

TICKS = round(PERIOD_S / TICK_S)

SAMPLES = 2000
"""Heaviest states of the belief that whoever drives gets to see."""

ELBOW_ROOM = 0.15
"""Least gap [m] to the walls where a robot is put down."""


@dataclass(frozen=True)
class TrialWorld:
    """A building with its map, a localizer on it, which every ride begins anew, and a robot."""

    world: OccupancyMap
    walls: Walls
    localizer: LocalizationMethod
    robot: RobotParams

    @classmethod
    def of(
        cls, world: OccupancyMap, localizer: LocalizationMethod, robot: RobotParams | None = None
    ) -> "TrialWorld":
        """Return the building that a map shows."""
        walls = altered(world, CONDITIONS["clean"], np.random.default_rng(0))
        return cls(world, walls, localizer, robot or RobotParams())

    def seen_by(self, laser: LaserParams) -> "TrialWorld":
        """Return the same with another laser."""
        return replace(self, robot=replace(self.robot, laser=laser))

    @cached_property
    def places(self) -> NDArray[np.float64]:
        """Where (n, 2) the robot may be put down, map frame."""
        return self.walls.places(self.robot.drive.radius + ELBOW_ROOM)


class Ride:
    """A robot put down somewhere, which knows nothing; it goes where it is driven.

    `rng` is of the wheels and the laser. What a ride did so far: `travel_m` is the true way,
    `contacts` how often it ran into something, `said` the localizer's word at each scan weighed.
    """

    def __init__(
        self, world: TrialWorld, map_from_base: NDArray[np.float64], rng: np.random.Generator
    ) -> None:
        wheels, self._light = rng.spawn(2)
        self._localizer = world.localizer
        self.laser = world.robot.laser
        self._simulation = Simulation(world.walls, world.robot, 0, wheels)
        self._simulation.put(map_from_base)
        self._localizer.start_anywhere()
        self._belief = Hypotheses(np.zeros((0, 3)), np.zeros(0))
        self._odom_then = np.zeros(3)
        self._scans = 0
        self.travel_m = 0.0
        self.contacts = 0
        self.said: list[State] = []

    @property
    def time(self) -> float:
        """Seconds since the robot was put down."""
        return self._scans * PERIOD_S

    @property
    def truth(self) -> NDArray[np.float64]:
        """Where the robot is (3,), map frame."""
        return self._simulation.pose

    @property
    def pose(self) -> NDArray[np.float64]:
        """Where the localizer has it (3,), map frame."""
        return self._localizer.pose_at(self._simulation.odometry.pose)

    def look(self) -> Situation:
        """Take a scan, weigh it if it tells something new, and return what is known now."""
        simulation, laser = self._simulation, self.laser
        simulation.count_wheels()
        odom = simulation.odometry.pose.copy()
        ranges = scan(simulation.surroundings, simulation.pose, laser, self._light)
        mount = np.array([laser.mount_x, 0.0, 0.0])
        self._weigh(ranges, mount, odom)
        since = se2.between(self._odom_then, odom)
        return Situation(
            now=self.time,
            odom_from_base=odom,
            view=View.of(ranges, laser.bearings, mount),
            belief=self._belief.moved(since),
            state=self._localizer.estimate.state,
        )

    def drive(self, speeds: Speeds) -> None:
        """Drive with these speeds until the next scan."""
        simulation = self._simulation
        simulation.want(*speeds)
        for _ in range(TICKS):
            before, touched = simulation.pose, simulation.contact is not None
            simulation.tick()
            self.travel_m += float(np.hypot(*(simulation.pose - before)[:2]))
            self.contacts += simulation.contact is not None and not touched
        self._scans += 1

    def wait(self, seconds: float) -> None:
        """Let time pass with the robot at rest."""
        self._scans += round(seconds / PERIOD_S)

    def _weigh(
        self, ranges: NDArray[np.float32], mount: NDArray[np.float64], odom: NDArray[np.float64]
    ) -> None:
        localizer, laser = self._localizer, self.laser
        bearings = laser.bearings
        angles = float(bearings[0]), float(bearings[1] - bearings[0])
        beams = localizer.params.beams
        measurement = scan_measurement(ranges, angles, mount, beams, laser.range_max)
        stamp_ns = round((1.0 + self.time) * 1e9)
        if not localizer.wants(stamp_ns, odom, measurement):
            return
        self.said.append(localizer.update(stamp_ns, odom, measurement).state)
        poses, weights = localizer.belief.heaviest(SAMPLES)
        shares = weights.astype(float)
        self._belief = Hypotheses(poses, shares / shares.sum())
        self._odom_then = odom
