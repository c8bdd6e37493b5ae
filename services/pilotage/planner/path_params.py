"""How paths are followed, and when a goal counts as reached."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Tolerances:
    """How near to the goal is near enough."""

    position: float = 0.10
    """m."""
    heading: float = float(np.deg2rad(5.0))
    """rad."""


@dataclass(frozen=True)
class FollowerParams:
    """How the robot follows paths; for a small indoor robot (see the simulator's chassis)."""

    radius: float = 0.165
    """Radius of its body, m."""
    max_linear: float = 0.5
    """m/s."""
    max_angular: float = 1.2
    """rad/s."""
    acceleration: float = 0.8
    """Of driving, m/s^2."""
    braking: float = 0.6
    """That it can count on, m/s^2."""
    braking_at_goal: float = 0.3
    """With which it comes to rest at the goal, m/s^2."""
    sideways_acceleration: float = 0.5
    """In curves, m/s^2."""
    delay: float = 0.25
    """From a look to the wheels' answer, the time between two looks included, s."""
    least_gap: float = 0.03
    """Gap to whatever is seen that it never goes below, m."""
    keep_clear: float = 0.08
    """Gap with which it steers past what stands by the path, m."""
    most_aside: float = 0.35
    """How far it may leave the path for that, m."""
    turn_first: float = 0.7
    """Angle to the point steered for beyond which it turns on the spot, rad."""
    turned: float = 0.2
    """Angle at which it has turned enough, rad."""
    patience: float = 2.0
    """Time that it waits for what stands in the way to go away, s."""
    stuck: float = 8.0
    """Time without getting on after which it gives up, s."""
