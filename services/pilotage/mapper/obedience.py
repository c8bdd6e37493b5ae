"""Whether a robot does what it is told, so that its orders say how it moves.

An order says nothing while the robot gathers speed, while its wheels are blocked or a watchdog
holds it. The first is not tested but waited for; the others show when what was counted and what
was ordered are compared over a moment. A single step is too short for that: in 20 ms a robot that
is still 0.1 m/s too slow is 2 mm behind, which is no more than the steps' own errors.
"""

from dataclasses import dataclass

import numpy as np

from pilotage.core.motion import arc
from pilotage.mapper.displacement import (
    DisplacementNoise,
    Vector,
    disagreement,
    measured,
)

Command = tuple[float, float]
"""Speeds ordered, m/s and rad/s."""


@dataclass(frozen=True)
class ObedienceParams:
    """When an order counts."""

    settling: float = 0.3
    """s after an order changed until it counts (0.6 m/s at 2 m/s^2)."""
    moment: float = 0.3
    """s over which displacements are compared; older ones fade."""
    most_disagreement: float = 11.34
    """Squared Mahalanobis distance up to which an order counts as obeyed (chi2, 3, 99 %)."""
    same_linear: float = 0.02
    """m/s by which an order may vary and still be the same."""
    same_angular: float = 0.05
    """rad/s, likewise."""


class Obedience:
    """Watches the steps of a robot and its orders."""

    def __init__(
        self, params: ObedienceParams, odometry: DisplacementNoise, command: DisplacementNoise
    ) -> None:
        self._params = params
        self._noises = odometry, command
        self._last: Command | None = None
        self._age = 0.0
        self._counted, self._ordered = np.zeros(3), np.zeros(3)

    def order(self, counted: Vector, dt: float, command: Command | None) -> Vector | None:
        """Return the displacement (3,) ordered in a step, None if the robot may not have obeyed.

        Args:
            counted: (3,) what odometry counted in the step.
            dt: s it took.
            command: what was ordered meanwhile; None: nobody knows.
        """
        if command is None:
            self._last, self._counted, self._ordered = None, np.zeros(3), np.zeros(3)
            return None
        if self._last is None or not self._is_same(command, self._last):
            self._last, self._age = command, 0.0
        ordered = arc(np.zeros(3), *command, dt)
        # In a moment poses hardly turn, so that displacements of steps may be added.
        kept = np.exp(-dt / self._params.moment)
        self._counted = kept * self._counted + counted
        self._ordered = kept * self._ordered + ordered
        is_settled = self._age >= self._params.settling
        self._age += dt
        return ordered if is_settled and self._agrees() else None

    def _agrees(self) -> bool:
        odometry, command = self._noises
        counted, ordered = measured(self._counted, odometry), measured(self._ordered, command)
        return disagreement(counted, ordered) <= self._params.most_disagreement

    def _is_same(self, one: Command, other: Command) -> bool:
        return (
            abs(one[0] - other[0]) <= self._params.same_linear
            and abs(one[1] - other[1]) <= self._params.same_angular
        )
