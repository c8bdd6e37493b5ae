"""What a ring of sonars tells whoever drives; pure."""

import numpy as np
from numpy.typing import ArrayLike

from pilotage.core import se2
from pilotage.core.laser_view import View

NEAR = 0.8
"""m: of what is farther away a cone does not say well enough where it is."""
DIRECTIONS = 61


def echo_view(ranges: ArrayLike, mounts: ArrayLike, cone: float) -> View:
    """Return the view of a sonar ring, in base_link: each near echo at three places of its cone.

    An echo says how near something is, and not where in its cone: both edges and the middle are
    minded. So a robot with sonars alone keeps off things as one with a laser does, but takes
    narrow doors for closed sooner.

    Args:
        ranges: (n,) m; not finite without an echo.
        mounts: (n, 3) poses of the sonars in base_link.
        cone: full opening angle, rad.
    """
    distances, poses = np.asarray(ranges, float), np.asarray(mounts, float)
    bearings = np.linspace(-np.pi, np.pi, DIRECTIONS)
    heard = np.isfinite(distances) & (distances <= NEAR)
    edges = np.array([-0.5, 0.0, 0.5]) * cone
    rays = np.stack([np.cos(edges), np.sin(edges)], axis=1)
    points = [
        se2.transform_points(pose, distance * rays)
        for pose, distance in zip(poses[heard], distances[heard], strict=True)
    ]
    return View(np.vstack([np.zeros((0, 2)), *points]), bearings)
