"""The map that grows while the robot drives, and what a restart needs to go on with it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.features import Features
from pilotage.topology.from_drive.building import LiveBuilder, LiveParams
from pilotage.topology.from_drive.nodes import NodeParams
from pilotage.topology.from_drive.trail import Trail
from pilotage.topology.routes.floors import Floor
from pilotage.topology.topological_map import Spacing

Arrays = dict[str, NDArray[np.generic]]


@dataclass(frozen=True)
class Plan:
    """How nodes are to be spaced: `metres` between those of equal spacing."""

    spacing: Spacing
    metres: float


class Drive:
    """Takes in where the robot is and what it sees there; gives a map at any moment."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        nodes = NodeParams(spacing=plan.spacing, usual=plan.metres, longest=2.0 * plan.metres)
        self._params = LiveParams(nodes=nodes)
        self._builder = LiveBuilder(self._params)
        self._trail = Trail(self._params.trail)

    def __len__(self) -> int:
        """Return the number of places that were passed."""
        return len(self._trail)

    def add(self, stamp: float, map_from_base: NDArray[np.float64], seen: Features) -> bool:
        """Take in what was seen (base_link) at a time [s]; say if the map has changed by it."""
        self._trail.add(stamp, map_from_base, seen)
        return self._builder.add(stamp, map_from_base, seen)

    def correct(self, stamps: NDArray[np.float64], poses: NDArray[np.float64]) -> bool:
        """Move the way to corrected poses (k, 3) at rising stamps (k,) [s]; say if that matters."""
        if len(self) == 0:
            return False
        # What was driven before this drive tells nothing of it.
        is_of_it = stamps >= self._trail.stops[0].stamp
        stamps, poses = stamps[is_of_it], poses[is_of_it]
        if len(stamps) == 0 or not self._builder.correct(stamps, poses):
            return False
        self._trail = self._trail.corrected(stamps, poses)
        return True

    def finish(self) -> None:
        """Set the nodes anew, now that all is known."""
        if len(self):
            self._builder.finish()

    def floor(self, map_id: str) -> Floor:
        """Return the map as far as it is built."""
        world = self._builder.topology(map_id)
        return Floor(world, built_from="drive", spacing=self.plan.spacing)

    def remember(self) -> Arrays:
        """Return all that `resumed` needs, as arrays by name."""
        seen = [stop.seen for stop in self._trail.stops]
        features = Features.joined(seen)
        return {
            "spacing": np.array(self.plan.spacing),
            "metres": np.array(self.plan.metres),
            "stamps": np.array([stop.stamp for stop in self._trail.stops]),
            "poses_map": self._trail.poses,
            "counts": np.array([len(one) for one in seen], np.int64),
            "kinds": features.kinds,
            "poses": features.poses,
            "widths": features.widths,
            "covariances": features.covariances,
        }

    @classmethod
    def resumed(cls, memory: Arrays) -> "Drive":
        """Return the drive that was remembered; KeyError or ValueError if it does not fit."""
        spacing: Spacing = "equal" if str(memory["spacing"]) == "equal" else "variable"
        drive = cls(Plan(spacing, float(memory["metres"])))
        all_seen = Features(
            np.asarray(memory["kinds"], np.int64),
            np.asarray(memory["poses"], float).reshape(-1, 3),
            np.asarray(memory["widths"], float),
            np.asarray(memory["covariances"], float).reshape(-1, 2, 2),
        )
        firsts = np.concatenate([[0], np.cumsum(np.asarray(memory["counts"], np.int64))])
        stamps = np.asarray(memory["stamps"], float)
        poses = np.asarray(memory["poses_map"], float).reshape(-1, 3)
        for i, (stamp, pose) in enumerate(zip(stamps, poses, strict=True)):
            drive.add(float(stamp), pose, all_seen.chosen(np.arange(firsts[i], firsts[i + 1])))
        return drive
