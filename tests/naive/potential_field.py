"""The potential field of landmarks, and what a camera sees of them, landmark by landmark.

Twins of `planner.potential_field` and `planner.landmark_views`, in plain Python.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.core.raycast import cast_rays
from pilotage.planner.landmark_views import LEAST, NEAR, Sharpness
from pilotage.planner.potential_field import Recognition

Array = NDArray[np.float64]
Sighting = tuple[str, str | None, float, float]
"""Class, identity, range and bearing."""


def recognised(distance: float, recognition: Recognition) -> float:
    """Eq. 1 over k."""
    return 1.0 / (1.0 + math.exp((distance - recognition.reach) / recognition.fall))


def is_in_sight(world: OccupancyMap | None, place: Array, landmark: Array) -> bool:
    """A ray from the place comes within two cells of the landmark."""
    if world is None:
        return True
    away = landmark - place
    distance = math.hypot(*away)
    beam = [place[0], place[1], math.atan2(away[1], away[0])]
    near = distance - 2.0 * world.geometry.resolution
    return float(cast_rays(world, beam, 100.0)[0]) >= near


def window_potential(
    landmarks: LandmarkMap,
    recognitions: dict[str, Recognition],
    pose: Array,
    half_view: float,
    world: OccupancyMap | None = None,
) -> float:
    """Eq. 2; half a view of pi makes it eq. 3."""
    names = list(zip(landmarks.classes, landmarks.identities, strict=True))
    total = 0.0
    for name, position in zip(names, landmarks.positions, strict=True):
        dx, dy = position - pose[:2]
        off = math.remainder(math.atan2(dy, dx) - pose[2], math.tau)
        if abs(off) <= half_view and is_in_sight(world, pose[:2], position):
            total += recognised(math.hypot(dx, dy), recognitions[name[0]]) / names.count(name)
    return total


def seen_share(distance: float, recognition: Recognition) -> float:
    """How often a landmark is recognised that the camera points to."""
    share = recognised(distance, recognition)
    return share if share >= LEAST and distance >= NEAR else 0.0


def in_view(off: float, half_view: float, rim: float) -> float:
    """How surely a landmark so far off the camera's pointing is in its view."""
    if half_view >= math.pi:
        return 1.0
    off = abs(math.remainder(off, math.tau))
    if rim == 0.0:
        return 1.0 if off <= half_view else 0.0
    return float(np.interp(off, [half_view - rim, half_view + rim], [1.0, 0.0]))


def sighting_log_likelihood(
    landmarks: LandmarkMap,
    recognitions: dict[str, Recognition],
    pose: Array,
    seen: list[tuple[Sighting, float]],
    look: tuple[float, float, Sharpness],
) -> float:
    """log P of sightings, each with a weight, from one pose.

    `look`: where the camera points, half of its view, and how sharp it is.
    """
    gaze, half_view, camera = look
    shares, places = [], []
    for kind, position in zip(landmarks.classes, landmarks.positions, strict=True):
        dx, dy = position - pose[:2]
        shares.append(seen_share(math.hypot(dx, dy), recognitions[kind]))
        places.append((math.hypot(dx, dy), math.atan2(dy, dx) - pose[2]))
    total = 0.0
    for share, (_, bearing) in zip(shares, places, strict=True):
        total -= share * in_view(bearing - gaze, half_view, camera.rim)
    for (kind, identity, distance, bearing), weight in seen:
        intensity = camera.outlier
        variance = (camera.range_error * distance) ** 2 + camera.blur**2
        around = camera.bearing_error**2 + camera.blur**2 / (distance**2 + camera.blur**2)
        for at, name in enumerate(zip(landmarks.classes, landmarks.identities, strict=True)):
            if name == (kind, identity):
                off = places[at][0] - distance
                turn = math.remainder(places[at][1] - bearing, math.tau)
                fit = math.exp(-0.5 * (off**2 / variance + turn**2 / around))
                sure = in_view(places[at][1] - gaze, half_view, camera.rim)
                intensity += shares[at] * sure * fit
        total += weight * math.log(intensity)
    return total
