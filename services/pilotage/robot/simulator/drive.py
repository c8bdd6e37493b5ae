"""A differential drive with limited acceleration whose wheels slip now and then; pure."""

from dataclasses import dataclass, replace

import numpy as np

from pilotage.robot.simulator.parameter_checks import (
    refuse_negative,
    refuse_shares_above_one,
    refuse_zero,
)


@dataclass(frozen=True)
class DriveParams:
    """The chassis; figures of a small indoor robot.

    The body is a disc of the diameter of Li's MORCS-2, 0.33 m.
    """

    radius: float = 0.165
    """Radius of the body, m."""
    max_linear: float = 0.6
    """Fastest straight on, m/s."""
    max_angular: float = 1.6
    """Fastest turn, rad/s."""
    acceleration: float = 1.0
    """m/s^2 when gaining speed; turning four times as much in rad/s^2."""
    braking: float = 10.0
    """m/s^2 when losing speed; turning four times as much in rad/s^2."""

    def __post_init__(self) -> None:
        """Refuse what no chassis has (ValueError)."""
        refuse_negative(self)
        refuse_zero(self, "radius", "acceleration", "braking")


@dataclass(frozen=True)
class SlipParams:
    """Slips happen by chance per metre of way: for a moment the wheels turn more than the robot."""

    rate: float = 0.02
    """Slips per metre."""
    duration: float = 0.3
    """Length of a slip, s."""
    share: float = 0.4
    """Part of the wheels' way that is lost."""
    yaw_rate: float = 0.1
    """Standard deviation of the turn it causes, rad/s."""

    def __post_init__(self) -> None:
        """Refuse what no floor has (ValueError)."""
        refuse_negative(self)
        refuse_shares_above_one(self, "share")


@dataclass(frozen=True)
class Wheels:
    """What the wheels do: m/s and rad/s, and the slip that goes on (s left, rad/s)."""

    linear: float = 0.0
    angular: float = 0.0
    slip_left: float = 0.0
    slip_yaw_rate: float = 0.0


def accelerated(
    wheels: Wheels, wanted: tuple[float, float], params: DriveParams, dt: float
) -> Wheels:
    """Return the wheels `dt` s later on their way to the wanted m/s and rad/s."""
    linear = float(np.clip(wanted[0], -params.max_linear, params.max_linear))
    angular = float(np.clip(wanted[1], -params.max_angular, params.max_angular))
    gain, loss = params.acceleration * dt, params.braking * dt
    return replace(
        wheels,
        linear=_towards(wheels.linear, linear, gain, loss),
        angular=_towards(wheels.angular, angular, 4.0 * gain, 4.0 * loss),
    )


def slipped(wheels: Wheels, params: SlipParams, dt: float, rng: np.random.Generator) -> Wheels:
    """Return the wheels with the slip that goes on, ends or begins within `dt` s."""
    if wheels.slip_left > 0.0:
        return replace(wheels, slip_left=max(0.0, wheels.slip_left - dt))
    if rng.random() >= params.rate * abs(wheels.linear) * dt:
        return wheels
    yaw_rate = float(rng.normal(0.0, params.yaw_rate))
    return replace(wheels, slip_left=params.duration, slip_yaw_rate=yaw_rate)


def ground_twist(wheels: Wheels, params: SlipParams) -> tuple[float, float]:
    """Return the robot's true m/s and rad/s over ground."""
    if wheels.slip_left <= 0.0:
        return wheels.linear, wheels.angular
    grip = 1.0 - params.share
    return wheels.linear * grip, wheels.angular * grip + wheels.slip_yaw_rate


def _towards(value: float, target: float, gain: float, loss: float) -> float:
    """Move towards the target by `gain` where the speed grows and `loss` where it shrinks."""
    if value * target < 0.0:
        return _towards(value, 0.0, gain, loss)
    step = gain if abs(target) > abs(value) else loss
    return value + float(np.clip(target - value, -step, step))
