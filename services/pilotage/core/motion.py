"""How a differential drive moves: exact arcs, and odometry with its noise."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap


@dataclass(frozen=True)
class OdometryNoise:
    """How much odometry errs; variances grow with the squares of the motion.

    The model of Thrun, Burgard & Fox 2005, table 5.6: a turn, a way straight on, a second turn.
    The defaults cover four recorded buildings (FR079, Aces, Seattle, Acapulco), whose odometry
    errs by 1 to 10 % of a turn, 2 to 7 % of a way and 0.002 to 0.02 rad a metre, now and then
    0.09: see the golden test.
    """

    rotation_noise_from_rotation: float = 0.01
    """alpha1: variance of a turn per squared turn, rad^2 / rad^2."""
    rotation_noise_from_translation: float = 0.0025
    """alpha2: variance of a turn per squared way, rad^2 / m^2."""
    translation_noise_from_translation: float = 0.0064
    """alpha3: variance of a way per squared way, m^2 / m^2."""
    translation_noise_from_rotation: float = 0.0025
    """alpha4: variance of a way per squared turn, m^2 / rad^2."""

    def __post_init__(self) -> None:
        """Refuse negative and non-finite coefficients (ValueError)."""
        for name, value in vars(self).items():
            if not 0.0 <= value < np.inf:
                raise ValueError(f"{name} must be finite and not negative, not {value}")


def sample_odometry(
    poses: ArrayLike, increment: ArrayLike, noise: OdometryNoise, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return where each of `poses` (n, 3) may be after odometry reported `increment` (3,).

    The increment is the motion seen from the pose before, `between(before, after)`.
    """
    start = np.asarray(poses, float)
    turn_1, way, turn_2 = _split(np.asarray(increment, float))
    # Driving backwards is no half turn: turns are counted from the nearer of both directions.
    spins = _acute(turn_1), _acute(turn_2)
    sigma_1 = _turn_sigma(spins[0], way, noise)
    sigma_2 = _turn_sigma(spins[1], way, noise)
    sigma_way = np.sqrt(
        noise.translation_noise_from_translation * way**2
        + noise.translation_noise_from_rotation * (spins[0] ** 2 + spins[1] ** 2)
    )
    errors = rng.standard_normal((3, len(start)))
    direction = start[:, 2] + turn_1 + sigma_1 * errors[0]
    noisy_way = way + sigma_way * errors[1]
    moved = np.empty_like(start)
    moved[:, 0] = start[:, 0] + noisy_way * np.cos(direction)
    moved[:, 1] = start[:, 1] + noisy_way * np.sin(direction)
    moved[:, 2] = wrap(direction + turn_2 + sigma_2 * errors[2])
    return moved


def arc(pose: ArrayLike, linear: float, angular: float, dt: float) -> NDArray[np.float64]:
    """Return the pose (..., 3) after driving for `dt` s at `linear` m/s and `angular` rad/s.

    Exact for constant speeds: the chord of the arc, D sin(psi/2) / (psi/2), lies half the turn
    psi ahead of the heading. Equal to Li 2008, eq. 2-5 to 2-7 (its y has a wrong sign in print),
    and without their division by zero as psi -> 0.
    """
    turn = angular * dt
    chord = linear * dt * np.sinc(turn / (2.0 * np.pi))
    step = np.array([chord * np.cos(turn / 2.0), chord * np.sin(turn / 2.0), turn])
    return se2.compose(pose, step)


def _split(increment: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return turn, way and turn whose succession is the increment."""
    x, y, theta = (float(value) for value in increment)
    way = float(np.hypot(x, y))
    # Standing still has no direction; noise of a micrometre must not look like a turn.
    turn_1 = float(np.arctan2(y, x)) if way > 1e-6 else 0.0
    return turn_1, way, wrap(theta - turn_1)


def _acute(turn: float) -> float:
    """Return how far a turn is from straight ahead or straight back, whichever is nearer."""
    return min(abs(wrap(turn)), abs(wrap(turn - np.pi)))


def _turn_sigma(turn: float, way: float, noise: OdometryNoise) -> float:
    """Return the standard deviation in rad of a turn that belongs to a way."""
    return float(
        np.sqrt(
            noise.rotation_noise_from_rotation * turn**2
            + noise.rotation_noise_from_translation * way**2
        )
    )
