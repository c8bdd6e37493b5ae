"""The last word before the wheels: limits, and stops when commands or sensors fail; pure.

Times are seconds of a clock that never goes backwards.
"""

from dataclasses import dataclass, field

import numpy as np

Speeds = tuple[float, float]
"""Straight on in m/s and turning in rad/s."""

AT_REST: Speeds = (0.0, 0.0)


@dataclass(frozen=True)
class Limits:
    """What no command may exceed."""

    linear: float = 0.6
    """m/s, forwards and backwards."""
    angular: float = 1.6
    """rad/s."""
    acceleration: float = 0.8
    """m/s^2 when gaining speed; losing it is left to the robot, which may brake harder."""
    angular_acceleration: float = 4.0
    """rad/s^2 when gaining speed."""

    def applied(self, wanted: Speeds, present: Speeds, dt: float) -> Speeds:
        """Return the speeds nearest to the wanted ones that are allowed `dt` s after `present`."""
        linear = float(np.clip(wanted[0], -self.linear, self.linear))
        angular = float(np.clip(wanted[1], -self.angular, self.angular))
        return (
            _gained(linear, present[0], self.acceleration * dt),
            _gained(angular, present[1], self.angular_acceleration * dt),
        )


@dataclass
class CommandWatch:
    """Velocity commands hold for `timeout` s; whoever falls silent stops the robot."""

    timeout: float = 0.5
    _fed: float | None = None

    def feed(self, now: float) -> None:
        """Note a command."""
        self._fed = now

    def is_silent(self, now: float) -> bool:
        """Say whether the last command is too old."""
        return self._fed is None or now - self._fed >= self.timeout


@dataclass
class SensorWatch:
    """Which of the sensors that motion relies on have fallen silent.

    `limits`: seconds of silence allowed, by topic.
    """

    limits: dict[str, float]
    _heard: dict[str, float] = field(default_factory=dict)

    def hear(self, topic: str, now: float) -> None:
        """Note a measurement."""
        self._heard[topic] = now

    def silent(self, topics: tuple[str, ...], now: float) -> str | None:
        """Return the first of `topics` that is silent for too long, None if all are heard."""
        for topic in topics:
            heard = self._heard.get(topic)
            if heard is None or now - heard > self.limits[topic]:
                return topic
        return None


def _gained(wanted: float, present: float, gain: float) -> float:
    """Limit how fast a speed may grow; changing direction begins at rest."""
    if wanted * present < 0.0:
        present = 0.0
    if abs(wanted) <= abs(present):
        return wanted
    return present + float(np.clip(wanted - present, -gain, gain))
