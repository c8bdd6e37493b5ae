"""Weak measurements of one displacement, and how two of them are fused (Li 2008, 2.3); pure.

Odometry counts a displacement, a command orders it; neither is true. As in Lu & Milios 1997 both
are measurements of the same link between two poses, linearised and weighed by their covariances.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class DisplacementNoise:
    """How a measurement of displacements errs, as standard deviations.

    A share errs the same way all the time (a wheel of another size), a walk anew in every step.
    """

    way_share: float
    """Of every way, m / m."""
    turn_share: float
    """Of every turn, rad / rad."""
    way_walk: float = 0.01
    """m per square root of a metre of way."""
    turn_walk: float = 0.008
    """rad per square root of a radian of turn."""
    drift_walk: float = 0.01
    """rad per square root of a metre of way: turns nobody meant (uneven floor)."""
    way_floor: float = 0.0002
    """m in any step, along and across: counting and timing."""
    turn_floor: float = 0.0002
    """rad in any step."""

    def __post_init__(self) -> None:
        """Refuse what would leave a covariance singular or endless (ValueError)."""
        for name, value in vars(self).items():
            if not 0.0 <= value < np.inf:
                raise ValueError(f"{name} must be finite and not negative, not {value}")
        if min(self.way_floor, self.turn_floor) <= 0.0:
            raise ValueError("way_floor and turn_floor must be positive")

    @property
    def walks(self) -> "DisplacementNoise":
        """The same without the shares: what errs anew in every step."""
        return replace(self, way_share=0.0, turn_share=0.0)


@dataclass(frozen=True, eq=False)
class Displacement:
    """A motion seen from the pose before it: `increment` (3,) and its covariance (3, 3)."""

    increment: Vector
    covariance: Matrix


def polar(increment: Vector) -> tuple[float, float, float]:
    """Return direction phi [rad], way d [m] and the turn eta [rad] left over (eq. 2-10).

    x = d cos(phi), y = d sin(phi), theta = phi + eta. Backwards is a negative way, no half turn;
    on an exact arc (eq. 2-5 to 2-7) both phi and eta are half the turn.
    """
    x, y, theta = (float(value) for value in increment)
    way = float(np.copysign(np.hypot(x, y), x))
    # Standing still has no direction; half the turn is the limit of ever smaller arcs.
    direction = float(np.arctan2(y * np.sign(way), abs(x))) if abs(way) > 1e-9 else theta / 2.0
    return direction, way, wrap(theta - direction)


def polar_jacobian(direction: float, way: float) -> Matrix:
    """Return d(x, y, theta) / d(phi, d, eta) (3, 3).

    Eq. 2-12; in print dy/dphi is -d cos(phi), it is +d cos(phi).
    """
    cos, sin = np.cos(direction), np.sin(direction)
    return np.array([[-way * sin, cos, 0.0], [way * cos, sin, 0.0], [1.0, 0.0, 1.0]])


def displacement_covariance(
    increment: Vector, noise: DisplacementNoise, horizon: float = 0.0
) -> Matrix:
    """Return the covariance (3, 3) of an increment (3,) over x, y, theta (eq. 2-11).

    Args:
        increment: the motion as measured, seen from the pose before it.
        noise: how the measurement errs.
        horizon: way [m] and turn [rad] over which shares add up. Zero counts this step alone;
            for weights it must not be so, or short steps would hide what errs all the time.
    """
    direction, way, _ = polar(increment)
    turn = float(increment[2])
    way_variance = noise.way_share**2 * _lasting(way, horizon) + noise.way_walk**2 * abs(way)
    turn_variance = (
        noise.turn_share**2 * _lasting(turn, horizon)
        + noise.turn_walk**2 * abs(turn)
        + noise.drift_walk**2 * abs(way)
    )
    # Direction and rest err by half the turn's error each, as on an arc.
    halves = np.diag([turn_variance / 2.0, way_variance, turn_variance / 2.0])
    jacobian = polar_jacobian(direction, way)
    floor = np.diag([noise.way_floor, noise.way_floor, noise.turn_floor]) ** 2
    return _symmetric(jacobian @ halves @ jacobian.T + floor)


def share_directions(increment: Vector, noise: DisplacementNoise) -> Matrix:
    """Return by how much x, y, theta err (3, 2) when way and turn err by one sigma of a share."""
    direction, way, _ = polar(increment)
    jacobian = polar_jacobian(direction, way)
    from_way = jacobian[:, 1] * way * noise.way_share
    from_turn = (jacobian[:, 0] + jacobian[:, 2]) / 2.0 * float(increment[2]) * noise.turn_share
    return np.stack([from_way, from_turn], axis=1)


def measured(increment: Vector, noise: DisplacementNoise, horizon: float = 0.0) -> Displacement:
    """Return an increment (3,) with what is uncertain about it."""
    return Displacement(increment, displacement_covariance(increment, noise, horizon))


def fusing_gain(one: Displacement, other: Displacement) -> Matrix:
    """Return how much (3, 3) of the difference to the other measurement the one takes on."""
    gain = np.linalg.solve(one.covariance + other.covariance, one.covariance).T
    return np.asarray(gain, float)


def fuse_increments(
    one: Displacement, other: Displacement, gain: Matrix | None = None
) -> Displacement:
    """Return the displacement that two measurements of it make most probable.

    The weighted mean of Lu & Milios 1997 for one link: (C1^-1 + C2^-1)^-1 (C1^-1 d1 + C2^-1 d2),
    written without inverses and along the shorter way round of the angle. Another `gain` than
    theirs gives another mean, whose covariance is just as true.
    """
    weight = fusing_gain(one, other) if gain is None else gain
    fused = one.increment + weight @ apart(other.increment, one.increment)
    fused[2] = wrap(float(fused[2]))
    rest = np.eye(3) - weight
    # Joseph's form stays symmetric and positive however the numbers are rounded.
    spread = rest @ one.covariance @ rest.T + weight @ other.covariance @ weight.T
    return Displacement(fused, _symmetric(spread))


def disagreement(one: Displacement, other: Displacement) -> float:
    """Return the squared Mahalanobis distance of two measurements of one displacement."""
    off = apart(other.increment, one.increment)
    return float(off @ np.linalg.solve(one.covariance + other.covariance, off))


def apart(target: Vector, origin: Vector) -> Vector:
    """Return the difference (3,) of two increments, its angle in [-pi, pi)."""
    off: Vector = np.asarray(target, float) - np.asarray(origin, float)
    off[2] = wrap(float(off[2]))
    return off


def _symmetric(covariance: Matrix) -> Matrix:
    """Return a covariance without what rounding made of its symmetry."""
    halves: Matrix = (covariance + covariance.T) / 2.0
    return halves


def _lasting(amount: float, horizon: float) -> float:
    """Return the square to which a share of `amount` adds up, spread over the horizon."""
    return abs(amount) * max(abs(amount), horizon)
