"""What a camera would see of landmarks, and how well it tells poses apart by that; pure.

Landmarks are recognised by chance, each with its own probability. So what is seen from pose j is
a Poisson process over sightings z = (kind, range, bearing), with the intensity

    lambda_j(z) = sum over landmarks l of that kind in view of p_jl * fit(z; l from j) + outlier,

p_jl: the recognition probability. A set Z of sightings then has the log likelihood

    log P(Z | j) = sum over Z of log lambda_j(z) - sum over landmarks in view of p_jl,

in which what is not seen speaks too. What would be seen from pose i is not known either; the mean
of log P over what may be seen there weighs each landmark by its probability p_il.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.jit import kernel
from pilotage.planner.information import LogLikelihoods
from pilotage.planner.potential_field import Sources, is_in_sight, is_within, recognised

Array = NDArray[np.float64]
CUT = 4.0
"""Standard deviations beyond which a landmark does not fit; e^-8 is far below any outlier."""
NEAR = 0.15
"""m: what is nearer lies below the picture. (On a landmark its bearing could be anything.)"""
LEAST = 0.05
"""Landmarks recognised less often than this are not reckoned with."""


class Sharpness(NamedTuple):
    """How sharply a camera tells poses apart.

    `range_error`, `bearing_error`, `outlier`: as of the camera; `blur`: of the position [m];
    `rim`: over how much of a bearing on either side a landmark passes out of view [rad].
    """

    range_error: float
    bearing_error: float
    outlier: float
    blur: float
    rim: float


@dataclass(frozen=True)
class Camera:
    """A camera that recognises landmarks: Liu et al. 2008, section 3.1.

    `half_view`: half its field of view [rad]; `range_error`: standard deviation of a range as a
    share of it; `bearing_error` [rad]; `outlier`: intensity of mistaken sightings, relative to
    the best of a true one.
    """

    half_view: float = float(np.deg2rad(28.5))
    range_error: float = 0.1
    bearing_error: float = float(np.deg2rad(10.0))
    outlier: float = 0.02

    @property
    def sharpness(self) -> Sharpness:
        """What kernels need: the errors and the outliers, no blur, and a sharp rim."""
        return Sharpness(self.range_error, self.bearing_error, self.outlier, 0.0, 0.0)


class Views(NamedTuple):
    """All landmarks from each of n poses: `ranges`, `bearings` (off the heading), `shares` (n, l).

    `shares`: the probability that a landmark is recognised if the camera points to it; what is
    hardly ever recognised has none, and no bearing.
    """

    ranges: Array
    bearings: Array
    shares: Array


def views_from(sources: Sources, poses: Array) -> Views:
    """Return where the landmarks are from poses (n, 3) of the map frame."""
    shape = len(poses), len(sources.positions)
    views = Views(np.empty(shape), np.empty(shape), np.empty(shape))
    _look(sources, np.ascontiguousarray(poses, float), views)
    return views


def expected_log_likelihoods(
    sources: Sources,
    views: Views,
    truths: NDArray[np.int64],
    window: tuple[float, float],
    sharpness: Sharpness,
) -> LogLikelihoods:
    """Return (m, n): what would be seen from poses `truths` (m,) through a window, at each of n.

    Args:
        sources: the landmarks.
        views: of the n poses.
        truths: which of them the robot could be at.
        window: where the camera points, off the heading, and half of its field of view; a half
            of pi is a full turn.
        sharpness: see `Camera.sharpness`.
    """
    return _expected(sources, views, truths, window, sharpness)


def sighting_log_likelihoods(
    sources: Sources,
    poses: ArrayLike,
    sightings: tuple[NDArray[np.int64], Array],
    window: tuple[float, float],
    sharpness: Sharpness,
) -> Array:
    """Return log P(Z | j) (n,) of what was seen through a window at poses (n, 3).

    `sightings`: kinds (s,), and values (s, 2): range [m] and bearing off the heading [rad]. The
    others as for `expected_log_likelihoods`.
    """
    views = views_from(sources, np.asarray(poses, float))
    return _weighed(sources.firsts, views, sightings, window, sharpness)


@kernel
def _look(sources: Sources, poses: Array, views: Views) -> None:
    """Fill in the views."""
    for i in range(len(poses)):
        x, y, theta = poses[i]
        for at in range(len(sources.positions)):
            dx, dy = sources.positions[at, 0] - x, sources.positions[at, 1] - y
            distance = np.sqrt(dx * dx + dy * dy)
            share = recognised(distance, sources.reaches[at], sources.falls[at])
            views.ranges[i, at], views.bearings[i, at], views.shares[i, at] = distance, 0.0, 0.0
            if share >= LEAST and distance >= NEAR:
                direction = np.arctan2(dy, dx)
                views.bearings[i, at] = direction - theta
                if is_in_sight(sources.walls, x, y, direction, distance):
                    views.shares[i, at] = share


@kernel
def _expected(
    sources: Sources,
    views: Views,
    truths: NDArray[np.int64],
    window: tuple[float, float],
    sharpness: Sharpness,
) -> LogLikelihoods:
    """See `expected_log_likelihoods`."""
    log_p = np.empty((len(truths), len(views.ranges)), np.float32)
    missed = _recognised_in_view(views, window, sharpness.rim)
    for i in range(len(truths)):
        for j in range(len(missed)):
            log_p[i, j] = -missed[j]
        for at in range(len(sources.kinds)):
            bearing = views.bearings[truths[i], at]
            share = views.shares[truths[i], at] * _in_view(bearing, window, sharpness.rim)
            if share > 0.0:
                kind = sources.kinds[at]
                landmarks = sources.firsts[kind], sources.firsts[kind + 1]
                value = views.ranges[truths[i], at], bearing
                _add(log_p[i], views, landmarks, value, (share, window, sharpness))
    return log_p


@kernel
def _weighed(
    firsts: NDArray[np.int64],
    views: Views,
    sightings: tuple[NDArray[np.int64], Array],
    window: tuple[float, float],
    sharpness: Sharpness,
) -> Array:
    """See `sighting_log_likelihoods`."""
    kinds, values = sightings
    total = -_recognised_in_view(views, window, sharpness.rim)
    for s in range(len(kinds)):
        landmarks = firsts[kinds[s]], firsts[kinds[s] + 1]
        _add(total, views, landmarks, (values[s, 0], values[s, 1]), (1.0, window, sharpness))
    return total


@kernel
def _in_view(bearing: float, window: tuple[float, float], rim: float) -> float:
    """Return how surely a bearing lies within a window: 1 inside, 0 outside, between on the rim."""
    gaze, half_view = window
    if rim == 0.0 or half_view >= np.pi:
        return 1.0 if is_within(bearing, gaze, half_view) else 0.0
    off = bearing - gaze
    off -= 2.0 * np.pi * np.rint(off / (2.0 * np.pi))
    return float(min(1.0, max(0.0, 0.5 + (half_view - abs(off)) / (2.0 * rim))))


@kernel
def _recognised_in_view(views: Views, window: tuple[float, float], rim: float) -> Array:
    """Return how many landmarks each pose (n,) is expected to recognise through the window."""
    total = np.zeros(len(views.ranges))
    for j in range(len(total)):
        for at in range(views.ranges.shape[1]):
            share = views.shares[j, at]
            if share > 0.0:
                total[j] += share * _in_view(views.bearings[j, at], window, rim)
    return total


@kernel
def _add(
    total: NDArray[np.floating],
    views: Views,
    landmarks: tuple[int, int],
    value: tuple[float, float],
    weighing: tuple[float, tuple[float, float], Sharpness],
) -> None:
    """Add weight * log lambda_j(z) to `total` (n,) of every pose j.

    Args:
        total: changed in place.
        views: of the poses.
        landmarks: first and end of those of the sighting's kind.
        value: range and bearing of the sighting.
        weighing: its weight, where the camera pointed, and its sharpness.
    """
    weight, window, (range_error, bearing_error, outlier, blur, rim) = weighing
    seen, bearing = value
    variance = (range_error * seen) ** 2 + blur**2 + 1e-6
    reach = CUT * np.sqrt(variance)
    around = bearing_error**2 + blur**2 / (seen**2 + blur**2 + 1e-6)
    nothing = weight * np.log(outlier)
    for j in range(len(total)):
        intensity = 0.0
        for at in range(landmarks[0], landmarks[1]):
            off = views.ranges[j, at] - seen
            if abs(off) < reach and views.shares[j, at] > 0.0:
                turn = views.bearings[j, at] - bearing
                turn -= 2.0 * np.pi * np.rint(turn / (2.0 * np.pi))
                squared = off * off / variance + turn * turn / around
                if squared < CUT * CUT:
                    share = views.shares[j, at] * _in_view(views.bearings[j, at], window, rim)
                    intensity += share * np.exp(-0.5 * squared)
        total[j] += weight * np.log(intensity + outlier) if intensity > 0.0 else nothing
