"""Three ways to go about: actively, along a fixed path, at random (Liu et al. 2008, section 3)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pilotage.planner.landmark_localization import LandmarkLocalization, Move, move_to
from pilotage.planner.situation import Hypotheses

Array = NDArray[np.float64]
STEP = 0.10
"""m: the longest way of a step (section 3.1)."""


class Policy(Protocol):
    """Says at each step how to move and where to look then."""

    def step(self, belief: Hypotheses, number: int) -> tuple[Move, float]:
        """Return the move and the camera's pointing off the heading [rad]."""
        ...


class ActivePolicy:
    """What the paper proposes."""

    def __init__(self, method: LandmarkLocalization, rng: np.random.Generator) -> None:
        self._method = method
        self._rng = rng

    def step(self, belief: Hypotheses, number: int) -> tuple[Move, float]:
        """See Policy."""
        del number
        decision = self._method.decide(belief, self._rng)
        return decision.move, decision.gaze


class RandomPolicy:
    """A full step in any direction, and a look in any direction, at every step."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def step(self, belief: Hypotheses, number: int) -> tuple[Move, float]:
        """See Policy."""
        del belief, number
        direction, gaze = self._rng.uniform(-np.pi, np.pi, 2)
        return STEP * np.array([np.cos(direction), np.sin(direction)]), float(gaze)


@dataclass(frozen=True)
class FixedPolicy:
    """Orders that would lead along a path, were there no noise; the camera looks ahead."""

    moves: list[Move]

    @classmethod
    def along(cls, start: Array, corners: Sequence[tuple[float, float]]) -> "FixedPolicy":
        """Return the orders from a pose (3,) by way of corners."""
        moves, pose = [], np.array(start, float)
        for corner in corners:
            way = move_to(pose, np.array(corner))
            count = math.ceil(float(np.hypot(*way)) / STEP - 1e-9)
            moves += [way / count] * count
            pose[:2] = corner
        return cls(moves)

    def step(self, belief: Hypotheses, number: int) -> tuple[Move, float]:
        """See Policy; at the end of the path the robot stands still."""
        del belief
        move = self.moves[min(number, len(self.moves) - 1)]
        gaze = float(np.arctan2(move[1], move[0]))
        return (move if number < len(self.moves) else np.zeros(2)), gaze
