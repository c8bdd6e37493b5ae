"""Recent echoes of a ring, whose arcs wait until enough others have crossed them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.arc_median import CrossingParams, find_crossings, place_echoes
from pilotage.mapper.sonar_arcs import ArcCrossings
from pilotage.mapper.sonar_ring import SonarReadings


@dataclass(frozen=True)
class EchoMemoryParams:
    """How long echoes are remembered and wait."""

    memory: int = 1500
    """Echoes whose arcs are kept to be crossed with later ones."""
    delay: int = 300
    """Echoes that follow before one is placed for good (the thesis's additional slice, 4.5)."""
    crossings: CrossingParams = field(default_factory=CrossingParams)
    """Which crossings place an obstacle."""


class EchoMemory:
    """Takes readings in, and gives them back with the place on the arc the echo came from."""

    def __init__(self, params: EchoMemoryParams, cone: float, *, improved: bool) -> None:
        self._params, self.cone, self._improved = params, cone, improved
        self._arcs: SonarReadings = np.zeros((0, 4))
        self._waiting = 0

    def take(self, readings: SonarReadings) -> NDArray[np.float64]:
        """Take in readings (k, 4); return the echoes (m, 5) that are now placed for good."""
        self._arcs = np.concatenate([self._arcs, readings])
        self._waiting += len(readings)
        due = max(0, self._waiting - self._params.delay)
        first = len(self._arcs) - self._waiting
        placed = self._placed(first, first + due)
        self._waiting -= due
        self._arcs = self._arcs[max(0, first + due - self._params.memory) :]
        return placed

    def waiting(self) -> NDArray[np.float64]:
        """Return the echoes (m, 5) that wait, placed as well as is known now."""
        return self._placed(len(self._arcs) - self._waiting, len(self._arcs))

    def crossings(self) -> ArcCrossings:
        """Return all transversal crossings of the arcs in memory, and which are used."""
        params = self._params.crossings
        return find_crossings(self._arcs, self.cone, params, improved=self._improved)

    def remember(self) -> dict[str, NDArray[np.generic]]:
        """Return all that `resume` needs."""
        return {"arcs": self._arcs, "waiting": np.array(self._waiting)}

    def resume(self, memory: Mapping[str, NDArray[np.generic]]) -> None:
        """Go on from what was remembered; ValueError if it does not fit."""
        if not {"arcs", "waiting"} <= memory.keys():
            raise ValueError("the memory lacks the sonar's echoes")
        arcs, waiting = np.array(memory["arcs"], float), int(memory["waiting"].item())
        if arcs.ndim != 2 or arcs.shape[1] != 4 or not 0 <= waiting <= len(arcs):
            raise ValueError(f"these are no echoes: {arcs.shape}, {waiting} of them waiting")
        self._arcs, self._waiting = arcs, waiting

    def _placed(self, first: int, last: int) -> NDArray[np.float64]:
        """Return the arcs `first` to `last` - 1 with the places on them (n, 5)."""
        crossing = self._params.crossings
        weights = np.array(crossing.weights)
        rule = self._improved, crossing.least_angle, weights, crossing.least_score
        found = place_echoes(self._arcs, first, last, self.cone, rule)
        return np.column_stack([self._arcs[first:last], found[:, 0]])
