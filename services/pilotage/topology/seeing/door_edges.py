"""The vertical edges of a camera's picture, brought to the frame in which doors are sought."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap


@dataclass(frozen=True)
class SeenEdges:
    """Vertical edges seen from `origin` (2,) m at `bearings` (n,) rad, each sure to `sigma` rad.

    All in one frame, usually base_link; `origin` is the camera's place there.
    """

    origin: NDArray[np.float64]
    bearings: NDArray[np.float64]
    sigma: float

    @classmethod
    def of(cls, mount: ArrayLike, bearings: ArrayLike, sigma: float) -> "SeenEdges":
        """Return edges in base_link of a camera at `mount` (3,) from bearings in its own frame."""
        pose = np.asarray(mount, float)
        turned = np.asarray(wrap(np.asarray(bearings, float) + pose[2]))
        return cls(pose[:2], turned, sigma)

    def moved(self, outer_from_inner: ArrayLike) -> "SeenEdges":
        """Return the same edges in the outer frame of a pose (3,).

        With base_link at the scan's time as outer and at the picture's time as inner frame, it
        makes up for the way in between.
        """
        pose = np.asarray(outer_from_inner, float)
        origin = se2.transform_points(pose, self.origin[None])[0]
        return SeenEdges(origin, np.asarray(wrap(self.bearings + pose[2])), self.sigma)
