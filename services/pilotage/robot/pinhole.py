"""How a camera projects: from places in its picture to bearings of upright edges; pure.

Pixel centres are at whole numbers, u to the right and v down, as OpenCV counts them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

UNDISTORTING_STEPS = 8
"""Fixed-point steps; five are enough for the lenses of web cameras."""


@dataclass(frozen=True)
class PinholeCamera:
    """A camera that looks about level.

    `focal` in pixels, as every calibration gives it. `centre` (u, v) of the optical axis, the
    middle of the picture if None. `radial`: k1 and k2 of OpenCV's model. `tilt`: how far the axis
    points above the horizon, `roll`: how far the camera leans to its right side, rad.
    """

    focal: float
    centre: tuple[float, float] | None = None
    radial: tuple[float, float] = (0.0, 0.0)
    tilt: float = 0.0
    roll: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a lens without a focal length (ValueError)."""
        if not (np.isfinite(self.focal) and self.focal > 0.0):
            raise ValueError(f"focal must be positive, it is {self.focal:g}; it is in pixels")

    @classmethod
    def across(cls, width: int, field_of_view: float) -> "PinholeCamera":
        """Return a camera whose `width` pixels span `field_of_view` rad."""
        return cls(width / 2.0 / float(np.tan(field_of_view / 2.0)))

    def scaled(self, share: float) -> "PinholeCamera":
        """Return the same camera with a picture `share` times as large."""
        middle = None
        if self.centre is not None:
            u, v = self.centre
            middle = ((u + 0.5) * share - 0.5, (v + 0.5) * share - 0.5)
        return PinholeCamera(self.focal * share, middle, self.radial, self.tilt, self.roll)

    def bearings(self, places: NDArray[np.float64], shape: tuple[int, int]) -> NDArray[np.float64]:
        """Return bearings (n,) left of the axis, rad, of places (n, 2) = u, v in a picture.

        `shape`: its height and width. All points of an upright edge have the same bearing.
        """
        middle = self.centre or ((shape[1] - 1) / 2.0, (shape[0] - 1) / 2.0)
        right, down = self._undistorted((places - middle) / self.focal).T
        cos, sin = np.cos(self.roll), np.sin(self.roll)
        right, down = cos * right - sin * down, sin * right + cos * down
        ahead = np.cos(self.tilt) + np.sin(self.tilt) * down
        bearing: NDArray[np.float64] = np.arctan2(-right, ahead)
        return bearing

    def _undistorted(self, seen: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where the points (n, 2) of a distorted picture, over focal length, belong."""
        if self.radial == (0.0, 0.0):
            return seen
        k1, k2 = self.radial
        true = seen
        for _ in range(UNDISTORTING_STEPS):
            squared = (true**2).sum(axis=1, keepdims=True)
            true = seen / (1.0 + k1 * squared + k2 * squared**2)
        return true
