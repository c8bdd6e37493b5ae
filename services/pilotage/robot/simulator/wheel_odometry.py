"""Dead reckoning from wheels that are not quite as large and as far apart as believed; pure."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core.motion import arc
from pilotage.robot.simulator.parameter_checks import refuse_negative


@dataclass(frozen=True)
class WheelOdometryParams:
    """Errors of the odometry, as standard deviations.

    With the defaults a way is wrong by 1 to 2 % and a full turn by 1 to 2 degrees, as in figures
    published for calibrated indoor robots.
    """

    scale_of_translation: float = 0.01
    """Share by which all ways are too long or too short; drawn once (wheel radius)."""
    scale_of_rotation: float = 0.003
    """The same for turns (wheel base)."""
    noise_of_translation: float = 0.01
    """m per square root of a metre."""
    noise_of_rotation: float = 0.008
    """rad per square root of a radian."""
    rotation_per_metre: float = 0.004
    """rad per square root of a metre of way (uneven floor)."""

    def __post_init__(self) -> None:
        """Refuse what no wheel has (ValueError)."""
        refuse_negative(self)


@dataclass
class WheelOdometry:
    """The pose of base_link in odom that a robot reckons; begins at zero."""

    params: WheelOdometryParams
    rng: np.random.Generator
    pose: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros((3, 3)))

    def __post_init__(self) -> None:
        """Draw this robot's own wheels."""
        self._way_scale = 1.0 + self.params.scale_of_translation * self.rng.standard_normal()
        self._turn_scale = 1.0 + self.params.scale_of_rotation * self.rng.standard_normal()

    def count(self, way: float, turn: float) -> None:
        """Add what the wheels did since the last count: m and rad, true to the wheels."""
        way_sigma = self.params.noise_of_translation * np.sqrt(abs(way))
        turn_sigma = np.hypot(
            self.params.noise_of_rotation * np.sqrt(abs(turn)),
            self.params.rotation_per_metre * np.sqrt(abs(way)),
        )
        noise = self.rng.standard_normal(2)
        seen_way = way * self._way_scale + way_sigma * noise[0]
        seen_turn = turn * self._turn_scale + turn_sigma * noise[1]
        self._spread(seen_way, seen_turn, (float(way_sigma), float(turn_sigma)))
        self.pose = arc(self.pose, seen_way, seen_turn, 1.0)

    def _spread(self, way: float, turn: float, sigmas: tuple[float, float]) -> None:
        """Let the covariance (x, y, theta) grow by one arc, to first order."""
        direction = self.pose[2] + turn / 2.0
        cos, sin = np.cos(direction), np.sin(direction)
        along_pose = np.array([[1.0, 0.0, -way * sin], [0.0, 1.0, way * cos], [0.0, 0.0, 1.0]])
        along_motion = np.array([[cos, -way * sin / 2.0], [sin, way * cos / 2.0], [0.0, 1.0]])
        way_sigma = np.hypot(sigmas[0], self.params.scale_of_translation * way)
        turn_sigma = np.hypot(sigmas[1], self.params.scale_of_rotation * turn)
        motion = np.diag([way_sigma**2, turn_sigma**2])
        grown = along_pose @ self.covariance @ along_pose.T + along_motion @ motion @ along_motion.T
        self.covariance = (grown + grown.T) / 2.0
