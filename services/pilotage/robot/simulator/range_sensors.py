"""The simulated laser, sonar ring and compass; pure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.robot.simulator.parameter_checks import (
    refuse_negative,
    refuse_shares_above_one,
    refuse_zero,
)
from pilotage.robot.simulator.people import ranges_to_discs
from pilotage.robot.simulator.walls import Walls

MOST_BEAMS = 10_000

Discs = NDArray[np.float64]
"""(n, 3): x, y, radius in m, map frame."""


@dataclass(frozen=True)
class LaserParams:
    """A small scanning laser; beams at equal steps, the first at -field_of_view / 2."""

    beams: int = 271
    field_of_view: float = float(np.deg2rad(270.0))
    """rad."""
    range_min: float = 0.05
    """m."""
    range_max: float = 12.0
    """m."""
    sigma: float = 0.01
    """Standard deviation of a range, m."""
    share_without_return: float = 0.005
    """Beams that find nothing though there is something: glass, black leather."""
    share_too_short: float = 0.005
    """Beams stopped on the way by dust or a cable: anywhere, evenly."""
    mount_x: float = 0.05
    """m ahead of the robot's centre."""

    def __post_init__(self) -> None:
        """Refuse what no laser has (ValueError)."""
        refuse_negative(self)
        refuse_zero(self, "field_of_view", "range_max")
        refuse_shares_above_one(self, "share_without_return", "share_too_short")
        if not 2 <= self.beams <= MOST_BEAMS:
            raise ValueError(f"beams must be 2 to {MOST_BEAMS}, they are {self.beams}")

    @property
    def bearings(self) -> NDArray[np.float64]:
        """Directions (beams,) in the laser's frame, rad."""
        return np.linspace(-self.field_of_view / 2.0, self.field_of_view / 2.0, self.beams)


@dataclass(frozen=True)
class SonarParams:
    """The sonar ring of MORCS-2 (Li 2008): eight sonars on the rim."""

    directions_deg: tuple[float, ...] = (90.0, 44.0, 12.0, -12.0, -44.0, -90.0, -144.0, 144.0)
    """In the order of their numbers 0 to 7, counter-clockwise positive."""
    cone: float = float(np.deg2rad(25.0))
    """Full opening angle, rad."""
    range_min: float = 0.1
    """m."""
    range_max: float = 4.0
    """m."""
    sigma: float = 0.01
    """Standard deviation, which is also the resolution, m."""
    share_without_echo: float = 0.02
    """Rounds in which the echo goes elsewhere."""

    def __post_init__(self) -> None:
        """Refuse what no sonar has (ValueError)."""
        refuse_negative(self)
        refuse_zero(self, "cone", "range_max", "directions_deg")
        refuse_shares_above_one(self, "share_without_echo")

    def mounts(self, rim: float) -> NDArray[np.float64]:
        """Return x, y, direction (n, 3) in base_link of sonars on a rim of radius `rim` m."""
        angles = wrap(np.deg2rad(np.array(self.directions_deg)))
        return np.stack([rim * np.cos(angles), rim * np.sin(angles), angles], axis=1)


@dataclass(frozen=True)
class CompassParams:
    """An electronic compass."""

    sigma: float = float(np.deg2rad(2.0))
    """Standard deviation, rad."""

    def __post_init__(self) -> None:
        """Refuse a compass without error: nobody would know how to weigh it (ValueError)."""
        refuse_negative(self)
        refuse_zero(self, "sigma")


@dataclass(frozen=True)
class Surroundings:
    """Walls, and discs (people) among them."""

    walls: Walls
    discs: Discs

    def ranges(
        self, origin: ArrayLike, bearings: ArrayLike, range_max: float
    ) -> NDArray[np.float64]:
        """Return true ranges (n,) from a pose of the map frame; infinite beyond `range_max`."""
        to_walls = self.walls.ranges(origin, bearings, range_max)
        if len(self.discs) == 0:
            return to_walls
        to_discs = ranges_to_discs(
            np.asarray(origin, float), np.asarray(bearings, float), self.discs
        )
        nearest = np.minimum(to_walls, to_discs)
        return np.where(nearest <= range_max, nearest, np.inf)


def scan(
    around: Surroundings, pose: ArrayLike, params: LaserParams, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Return what the laser on a robot at `pose` measures: (beams,) m, infinite = no return."""
    origin = se2.compose(pose, (params.mount_x, 0.0, 0.0))
    ranges = around.ranges(origin, params.bearings, params.range_max)
    noisy = ranges + params.sigma * rng.standard_normal(params.beams)
    chance = rng.random(params.beams)
    is_short = chance < params.share_too_short
    too_far = np.minimum(noisy, params.range_max)
    noisy = np.where(is_short, rng.random(params.beams) * too_far, noisy)
    noisy[chance > 1.0 - params.share_without_return] = np.inf
    return _limited(noisy, params.range_min, params.range_max)


def sonar_round(
    around: Surroundings, mounts: ArrayLike, params: SonarParams, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Return one reading (n,) per mount (n, 3: poses in the map frame), infinite = no echo.

    A cone answers with the nearest thing in it, found by five beams.
    """
    fan = np.linspace(-params.cone / 2.0, params.cone / 2.0, 5)
    poses = np.asarray(mounts, float)
    nearest = np.array([around.ranges(pose, fan, params.range_max).min() for pose in poses])
    noisy = nearest + params.sigma * rng.standard_normal(len(poses))
    noisy[rng.random(len(poses)) < params.share_without_echo] = np.inf
    return _limited(noisy, params.range_min, params.range_max)


def compass_yaw(theta: float, params: CompassParams, rng: np.random.Generator) -> float:
    """Return the measured direction in [-pi, pi) of a robot that looks along `theta` rad."""
    return wrap(theta + params.sigma * float(rng.standard_normal()))


def _limited(ranges: NDArray[np.float64], lowest: float, highest: float) -> NDArray[np.float32]:
    """Return no range below the sensor's least, and infinity beyond its reach."""
    inside = np.maximum(ranges, lowest)
    return np.where(inside <= highest, inside, np.inf).astype(np.float32)
