"""Rides of the simulated robot through worlds, with the noise of a good localizer."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.laser_view import View
from pilotage.planner.obstacle_view import echo_view
from pilotage.planner.situation import Hypotheses, Situation, Speeds
from pilotage.robot.simulator.range_sensors import scan, sonar_round
from pilotage.robot.simulator.simulation import Simulation

PERIOD = 0.1
POSE_NOISE = np.array([0.02, 0.02, np.deg2rad(0.5)])


def view_of(simulation: Simulation) -> View:
    laser = simulation.params.laser
    ranges = scan(simulation.surroundings, simulation.pose, laser, simulation.rng)
    return View.of(ranges, laser.bearings, (laser.mount_x, 0.0, 0.0))


def echoes_of(simulation: Simulation) -> View:
    sonar = simulation.params.sonar
    mounts = sonar.mounts(simulation.params.drive.radius)
    poses = se2.compose(simulation.pose, mounts)
    ranges = sonar_round(simulation.surroundings, poses, sonar, simulation.rng)
    return echo_view(ranges, mounts, sonar.cone)


@dataclass
class Ride:
    """A robot on its way: `touched` once it has touched anything, its `way` so far."""

    simulation: Simulation
    noise: NDArray[np.float64] = field(default_factory=POSE_NOISE.copy)
    touched: bool = False
    seconds: float = 0.0
    way: list[NDArray[np.float64]] = field(default_factory=list)

    def pose(self) -> NDArray[np.float64]:
        """What the localizer says."""
        noisy: NDArray[np.float64] = self.simulation.pose + self.noise * (
            self.simulation.rng.standard_normal(3)
        )
        return noisy

    def drive(self, speeds: Speeds) -> None:
        """Let 0.1 s pass."""
        self.simulation.want(*speeds)
        for _ in range(round(PERIOD / 0.01)):
            self.simulation.tick()
            self.touched |= self.simulation.contact is not None
        self.simulation.count_wheels()
        self.way.append(self.simulation.pose.copy())
        self.seconds += PERIOD

    @property
    def metres(self) -> float:
        """Length of the way so far."""
        return float(np.hypot(*np.diff(np.array(self.way)[:, :2], axis=0).T).sum())


def situation_of(ride: Ride) -> Situation:
    """What the robot knows on a ride, its pose noisy but known."""
    belief = Hypotheses(ride.pose()[None], np.ones(1))
    odom = ride.simulation.odometry.pose
    return Situation(ride.seconds, odom, view_of(ride.simulation), belief, "localized")
