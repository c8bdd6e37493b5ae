"""Which point of a path to steer for, and how to get past what stands beside it; pure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.laser_view import View
from pilotage.planner.path_params import FollowerParams
from pilotage.planner.path_track import Track, distances_to_line

AHEAD = (1.0, 0.8, 0.6, 0.45, 0.3, 0.2)
"""m ahead on the path at which points to steer for are looked for."""
SHAVED = 0.06
"""m by which the way to that point may cut a bend."""
NEARER = (0.7, 0.5, 0.35)
"""m ahead at which ways past something are looked for, where none is free that is longer."""
ASIDE = np.deg2rad(np.arange(-48.0, 49.0, 4.0))
"""rad by which the robot may steer past something."""
TOO_TIGHT, BLOCKED = 1.5, 3.0
"""Costs, in rad of steering aside, of a way with too small a gap, and with none."""
CHANGED_MIND = 0.15
"""Costs of a rad of steering elsewhere than a moment ago."""


@dataclass(frozen=True)
class Aim:
    """The point steered for: `bearing` rad, `distance` m from here, `aside` rad of its bearing."""

    bearing: float
    distance: float
    aside: float = 0.0

    @property
    def curvature(self) -> float:
        """Of the arc that leads there, 1/m."""
        return 2.0 * float(np.sin(self.bearing)) / max(self.distance, 0.1)


def aim_on(track: Track, way: float, here: ArrayLike) -> Aim:
    """Return the farthest point to which one may go straight without cutting a bend.

    Args:
        track: the path.
        way: how far along it the robot is, m.
        here: (3,) its pose in the frame of the path.
    """
    pose = np.asarray(here, float)
    ahead = np.arange(0.0, AHEAD[0] + 0.01, 0.05)
    points = track.at(way + ahead)
    off = float(np.hypot(*(points[0] - pose[:2])))
    for distance in AHEAD[:-1]:
        piece = points[ahead <= distance + 0.001]
        if distances_to_line(piece, pose[:2], piece[-1]).max() <= off + SHAVED:
            return _aim_at(piece[-1], pose)
    return _aim_at(track.at(way + AHEAD[-1])[0], pose)


def steered_past(view: View, aim: Aim, last_aside: float, params: FollowerParams) -> Aim:
    """Return the aim turned aside as far as it takes to get past what stands in the way to it.

    If no way as long is free, shorter ones are looked at. The aim is turned no farther than
    `params.most_aside` m from the path; if that is not enough, it stays where it is.
    """
    for distance in (aim.distance, *(near for near in NEARER if near < aim.distance)):
        asides = ASIDE[2.0 * distance * np.abs(np.sin(ASIDE / 2.0)) <= params.most_aside]
        bearings = aim.bearing + asides
        blocked = _is_blocked(view, bearings, params.radius + params.least_gap, distance)
        if blocked.all():
            continue
        tight = _is_blocked(view, bearings, params.radius + params.keep_clear, distance)
        steering = np.abs(asides) + CHANGED_MIND * np.abs(asides - last_aside)
        best = int(np.argmin(steering + TOO_TIGHT * tight + BLOCKED * blocked))
        return Aim(float(bearings[best]), distance, float(asides[best]))
    return aim


def _aim_at(point: NDArray[np.float64], pose: NDArray[np.float64]) -> Aim:
    x, y = se2.transform_points(se2.inverse(pose), point[None])[0]
    return Aim(float(np.arctan2(y, x)), float(np.hypot(x, y)))


def _is_blocked(
    view: View, bearings: NDArray[np.float64], half_width: float, distance: float
) -> NDArray[np.bool_]:
    """Say at which bearings (n,) a disc cannot go so far straight on."""
    blocked: NDArray[np.bool_] = view.reach(bearings, half_width) < distance + half_width
    return blocked
