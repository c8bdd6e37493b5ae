"""Whether landmarks stand where they should: what says at once that a robot was carried off.

One sighting may be a mistake (see `landmark_model`), and so may two. A robot that sees several in
a row where none should be, and none that should, is not where it is thought to be.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.landmark_model import OUTLIER, landmark_likelihoods
from pilotage.localizer.landmark_sightings import Sightings

IN_A_ROW = 3
"""So many sightings are all mistaken once in 8,000 times."""

MISTAKEN = float(np.log(2.0 * OUTLIER))
"""A sighting of less log likelihood is rather a mistake than one of a landmark as mapped."""


class LandmarkSurprise:
    """Counts the sightings in a row that fit nothing from where the robot should be."""

    def __init__(self, landmarks: LandmarkMap | None) -> None:
        self._landmarks = landmarks
        self._in_a_row = 0

    def forget(self) -> None:
        """Begin to count anew."""
        self._in_a_row = 0

    def is_surprised(
        self, pose: NDArray[np.float64], covariance: NDArray[np.float64], seen: Sightings | None
    ) -> bool:
        """Say whether what is seen is one mistake too many at a pose (3,), known to (3, 3)."""
        return seen is not None and self._with(pose, covariance, seen) >= IN_A_ROW

    def note(
        self, pose: NDArray[np.float64], covariance: NDArray[np.float64], seen: Sightings | None
    ) -> None:
        """Take in what is seen there."""
        self._in_a_row = self._with(pose, covariance, seen)

    def _with(
        self, pose: NDArray[np.float64], covariance: NDArray[np.float64], seen: Sightings | None
    ) -> int:
        """Return how many sightings in a row fit nothing, together with these."""
        if self._landmarks is None or seen is None:
            return self._in_a_row
        widened = _widened(seen, covariance)
        every = [_one_of(widened, i) for i in range(len(seen.ranges))]
        logs = [float(landmark_likelihoods(pose[None], one, self._landmarks)[0]) for one in every]
        # What the map does not have says nothing, not even that it fits.
        known = [log for one, log in zip(every, logs, strict=True) if self._is_mapped(one)]
        misfits = sum(1 for log in known if log < MISTAKEN)
        if 2 * misfits < len(known):
            return 0
        return self._in_a_row + misfits

    def _is_mapped(self, one: Sightings) -> bool:
        if self._landmarks is None:
            return False
        return bool(len(self._landmarks.candidates(one.kinds[0], one.identities[0])))


def _one_of(seen: Sightings, index: int) -> Sightings:
    one = slice(index, index + 1)
    return Sightings(
        seen.ranges[one],
        seen.bearings[one],
        seen.range_sigmas[one],
        seen.bearing_sigmas[one],
        seen.kinds[one],
        seen.identities[one],
    )


def _widened(seen: Sightings, covariance: NDArray[np.float64]) -> Sightings:
    """Return the sightings with errors that take in how well the pose is known."""
    place = float(np.linalg.eigvalsh(covariance[:2, :2])[-1])
    aside = place / np.maximum(seen.ranges, np.sqrt(place)) ** 2 + covariance[2, 2]
    return replace(
        seen,
        range_sigmas=np.sqrt(seen.range_sigmas**2 + place),
        bearing_sigmas=np.sqrt(seen.bearing_sigmas**2 + aside),
    )
