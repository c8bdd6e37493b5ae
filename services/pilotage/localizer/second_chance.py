"""When a pose that was found anew at a node is taken: the same rule for every method; pure.

A node of the topological map knows the robot by its doors and corners, whatever the belief has come
to. It is a second chance for those who need one, not a second opinion for those who do well: a
belief that is localized and fits what is seen has more behind it than one look at a few features.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.localizer.dead_reckoning import grown
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.modes import is_within
from pilotage.localizer.motion_spread import MotionSpread

LEAST_MATCHED = 2
"""Fewer features fit in too many places."""

WELL_MATCHED = 0.6
"""Share of the beams that meet what the map shows, from which on a pose is not given up."""

ITS_MAIN_MODE = 0.5
"""Share of the belief that makes a place the one that is believed."""


@dataclass(frozen=True)
class Found:
    """A pose (3,) map_from_base with covariance (3, 3), map frame, and how many features say so."""

    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]
    matched: int

    def moved(self, increment: NDArray[np.float64]) -> "Found":
        """Return the same after a motion (3,) by odometry, in the robot's frame of then."""
        covariance = grown(self.pose, self.covariance, increment, MotionSpread())
        return Found(se2.compose(self.pose, increment), covariance, self.matched)


def takes(estimate: Estimate, shift: NDArray[np.float64], found: Found) -> bool:
    """Say whether a localizer should begin anew from a pose that was found.

    Args:
        estimate: what it says.
        shift: (3,) motion by odometry since that was measured.
        found: the pose, of now.

    One that is localized does not, unless the two disagree and its scans fit badly. Of an ambiguous
    belief one mode has to agree. One that is unknown or lost does, unless it is on its way already:
    a second start would only take away what the first has earned.
    """
    if found.matched < LEAST_MATCHED:
        return False
    agreeing = [mode.mass for mode in estimate.modes if _agrees(mode.pose, shift, found)]
    match estimate.state:
        case "localized":
            fits = estimate.matched is None or estimate.matched >= WELL_MATCHED
            return not fits and not _agrees(estimate.pose, shift, found)
        case "ambiguous":
            return bool(agreeing)
        case "unknown":
            return max(agreeing, default=0.0) < ITS_MAIN_MODE
        case "lost":
            return True


def _agrees(pose: NDArray[np.float64], shift: NDArray[np.float64], found: Found) -> bool:
    """Say whether a pose, moved on, is the same place as the one that was found."""
    return bool(is_within(se2.compose(pose, shift)[None], found.pose)[0])
