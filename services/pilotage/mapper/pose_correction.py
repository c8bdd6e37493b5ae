"""Corrects dead reckoning by commands and compass (Li 2008, 2.2 and 2.3); pure.

A step fuses what odometry counted with what was ordered, takes the pose along the fused
displacement, and then weighs the compass against the heading. Whatever disagrees beyond chance
is left out: an order that was not obeyed, a compass near iron.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.mapper.displacement import (
    Displacement,
    DisplacementNoise,
    Matrix,
    Vector,
    fuse_increments,
    fusing_gain,
    measured,
    share_directions,
)
from pilotage.mapper.obedience import Obedience, ObedienceParams

HEADING = np.array([0.0, 0.0, 1.0, 1.0])
"""What a compass sees of the state (x, y, theta, offset of the compass)."""


@dataclass(frozen=True)
class PoseCorrectionParams:
    """What odometry, orders and compass are worth; sources with each."""

    odometry: DisplacementNoise = field(
        default_factory=lambda: DisplacementNoise(way_share=0.048, turn_share=0.07)
    )
    """176 mm in 3.67 m (Li 2008, table 5-1); 5.25 and 7.67 degrees in a quarter turn (5-3)."""
    command: DisplacementNoise = field(
        default_factory=lambda: DisplacementNoise(
            way_share=0.011,
            turn_share=0.02,
            way_walk=0.005,
            way_floor=0.001,
            turn_floor=0.003,
        )
    )
    """43 mm in 3.64 m (table 5-1); floors: 5 ms of timing at 0.2 m/s and 0.6 rad/s."""
    horizon: float = 1.0
    """m and rad over which shares add up when odometry and orders are weighed."""
    obedience: ObedienceParams = field(default_factory=ObedienceParams)
    """When an order counts."""
    most_heading_sigmas: float = 3.5
    """Standard deviations up to which a compass counts as undisturbed."""
    compass_deviation: float = float(np.deg2rad(1.0))
    """rad by which a compass errs beyond its noise (the robot's own iron), at one heading."""
    compass_offset: float = np.pi / np.sqrt(3.0)
    """Standard deviation in rad of north against the map's x axis; this is: unknown."""


@dataclass(frozen=True, eq=False)
class Belief:
    """Mean (4,) of x, y, theta and the compass's offset, and what is uncertain about it.

    `random` (4, 4) is the covariance of errors made anew in each step. The columns of `lasting`
    (4, 4) are what one sigma of each lasting error has led to: odometry's ways and turns, the
    orders' ways and turns. Adding these up step by step as if they were random would promise far
    too much.
    """

    mean: Vector
    random: Matrix
    lasting: Matrix

    @property
    def covariance(self) -> Matrix:
        """The whole covariance (4, 4)."""
        whole: Matrix = self.random + self.lasting @ self.lasting.T
        return whole


class PoseCorrection:
    """The corrected pose of a robot over time."""

    def __init__(
        self,
        params: PoseCorrectionParams | None = None,
        start: ArrayLike = (0.0, 0.0, 0.0),
        start_covariance: ArrayLike | None = None,
    ) -> None:
        """Begin at a pose (3,) of the map, exactly unless a covariance (3, 3) is given."""
        self._params = params or PoseCorrectionParams()
        self._obedience = Obedience(
            self._params.obedience, self._params.odometry, self._params.command
        )
        random = np.zeros((4, 4))
        random[:3, :3] = np.diag([1e-8] * 3) if start_covariance is None else start_covariance
        random[3, 3] = self._params.compass_offset**2
        mean = np.array([*np.asarray(start, float), 0.0])
        self._belief = Belief(mean, random, np.zeros((4, 4)))

    @property
    def pose(self) -> Vector:
        """The corrected pose (3,) of base_link in the map."""
        return self._belief.mean[:3].copy()

    @property
    def covariance(self) -> Matrix:
        """Its covariance (3, 3)."""
        return self._belief.covariance[:3, :3]

    def step(
        self,
        odometry_increment: ArrayLike,
        dt: float,
        command: tuple[float, float] | None = None,
        heading: tuple[float, float] | None = None,
    ) -> tuple[Vector, Matrix]:
        """Return pose (3,) and covariance (3, 3) after one step.

        Args:
            odometry_increment: (3,) what odometry counted, seen from the pose before.
            dt: s it took.
            command: speeds ordered meanwhile, m/s and rad/s; None: nobody knows.
            heading: yaw that the compass shows at the end and its standard deviation, rad; None:
                it shows nothing.
        """
        counted = np.asarray(odometry_increment, float)
        ordered = self._obedience.order(counted, dt, command)
        self._belief = moved(self._belief, counted, ordered, self._params)
        if heading is not None:
            self._belief = turned_to(self._belief, *heading, self._params)
        return self.pose, self.covariance

    def remember(self) -> dict[str, NDArray[np.float64]]:
        """Return all that `resume` needs."""
        belief = self._belief
        return {"mean": belief.mean, "random": belief.random, "lasting": belief.lasting}

    def resume(self, memory: Mapping[str, NDArray[np.float64]]) -> None:
        """Go on from what was remembered; ValueError if it does not fit."""
        known = self.remember()
        for name, value in known.items():
            if name not in memory or memory[name].shape != value.shape:
                raise ValueError(f"the pose correction remembers no {name} of {value.shape}")
        self._belief = Belief(**{name: np.array(memory[name], float) for name in known})


def moved(
    belief: Belief, counted: Vector, ordered: Vector | None, params: PoseCorrectionParams
) -> Belief:
    """Return the belief after a displacement counted, and ordered if one was (2-8 to 2-19)."""
    step = measured(counted, params.odometry.walks)
    lasting = np.zeros((3, 4))
    lasting[:, :2] = share_directions(counted, params.odometry)
    if ordered is not None:
        gain = fusing_gain(
            measured(counted, params.odometry, params.horizon),
            measured(ordered, params.command, params.horizon),
        )
        step = fuse_increments(step, measured(ordered, params.command.walks), gain)
        lasting[:, :2] = (np.eye(3) - gain) @ lasting[:, :2]
        lasting[:, 2:] = gain @ share_directions(ordered, params.command)
    return _along(belief, step, lasting)


def turned_to(belief: Belief, yaw: float, sigma: float, params: PoseCorrectionParams) -> Belief:
    """Return the belief after a look at the compass; unchanged if it is disturbed."""
    variance = sigma**2 + params.compass_deviation**2
    spread = belief.covariance @ HEADING
    innovation = wrap(yaw - float(HEADING @ belief.mean))
    expected = float(HEADING @ spread) + variance
    if innovation**2 > params.most_heading_sigmas**2 * expected:
        return belief
    gain = spread / expected
    mean = belief.mean + gain * innovation
    mean[2:] = wrap(mean[2:])
    rest = np.eye(4) - np.outer(gain, HEADING)
    random = rest @ belief.random @ rest.T + variance * np.outer(gain, gain)
    return Belief(mean, (random + random.T) / 2.0, rest @ belief.lasting)


def compound_jacobians(before: Vector, after: Vector) -> tuple[Matrix, Matrix]:
    """Return d(after) / d(before) and d(after) / d(displacement), (3, 3) each.

    These are H and K of Lu & Milios 1997 (eq. 2-17 to 2-19) for a displacement seen from the
    pose before. In print H has its off-diagonal ones in the wrong column and the signs of a
    displacement seen from the pose after.
    """
    x, y = after[:2] - before[:2]
    cos, sin = np.cos(before[2]), np.sin(before[2])
    h = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
    k = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return h, k


def _along(belief: Belief, step: Displacement, lasting: Matrix) -> Belief:
    """Return the belief taken along a displacement; `lasting` (3, 4) as in Belief."""
    before = belief.mean[:3]
    after = se2.compose(before, step.increment)
    h, k = np.eye(4), np.zeros((4, 3))
    h[:3, :3], k[:3] = compound_jacobians(before, after)
    random = h @ belief.random @ h.T + k @ step.covariance @ k.T
    mean = np.array([*after, belief.mean[3]])
    return Belief(mean, (random + random.T) / 2.0, h @ belief.lasting + k @ lasting)
