"""Follows the robot from scan to scan: odometry predicts, a match on the local map corrects."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.mapper.correlative_search import SearchRaster, SearchWindow, search, search_raster
from pilotage.mapper.odometry_drift import DriftParams, drift_covariance, moved_covariance
from pilotage.mapper.pose_edges import inverted
from pilotage.mapper.scan_matcher import Match, MatchParams, refine
from pilotage.mapper.surfel_kernels import SurfelMap
from pilotage.mapper.surfels import SurfelParams, surfel_map


@dataclass(frozen=True)
class TrackerParams:
    """How scans are followed."""

    surfels: SurfelParams = field(default_factory=SurfelParams)
    match: MatchParams = field(default_factory=MatchParams)
    drift: DriftParams = field(default_factory=DriftParams)
    blur: float = 0.08
    """m; how far beside a wall the search still takes a point for one of it."""
    search_points: int = 120
    """Of a scan so many points take part in the search."""
    search_limits: tuple[float, float] = (0.8, 0.7)
    """m and rad; the search goes to three standard deviations, but no farther."""
    doubtful_cost: float = 0.45
    """A match worse than this may be a wrong one: a better one is looked for farther off."""
    bad_cost: float = 0.65
    """A match worse than this is none."""
    good_cost: float = 0.35
    """One found by looking everywhere must be better than this."""
    everywhere: tuple[float, float] = (1.5, np.pi)
    """m and rad; where to look when odometry and scan contradict: wheels slip and are lifted."""
    distrust: float = 4.0
    """Odometry that a scan contradicts is off by so many times what is usual."""
    better: float = 0.15
    """A match farther off must be better than the usual one by so much cost."""
    enough_points: int = 40
    """With fewer a scan alone cannot say where it belongs, only correct what odometry says."""


@dataclass(frozen=True, eq=False)
class Tracked:
    """The robot's `pose` (3,) in the local map's frame with its covariance (3, 3).

    `is_matched`: the scan agrees; otherwise the pose is odometry's.
    """

    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]
    is_matched: bool


HERE = Tracked(np.zeros(3), 1e-6 * np.eye(3), is_matched=True)
"""At a keyframe, the frame's own origin."""


@dataclass(frozen=True, eq=False)
class LocalMap:
    """What scans are matched against."""

    surfels: SurfelMap
    raster: SearchRaster


def local_map(points: NDArray[np.float64], params: TrackerParams, depth: int = 4) -> LocalMap:
    """Return the map of points (n, 2) of a frame; the search starts on 2**(depth - 1) cells."""
    surfels = surfel_map(points, params.surfels)
    return LocalMap(surfels, search_raster(surfels, params.blur, depth))


def predicted(before: Tracked, increment: NDArray[np.float64], params: DriftParams) -> Tracked:
    """Return where the robot is after an odometry increment (3,)."""
    drift = drift_covariance(increment, params)
    covariance = moved_covariance(before.pose, before.covariance, increment, drift)
    return Tracked(se2.compose(before.pose, increment), covariance, is_matched=False)


def corrected(
    guess: Tracked, points: NDArray[np.float64], here: LocalMap, params: TrackerParams
) -> Tracked:
    """Return where the robot is, given also the points (n, 2) of a scan in its frame."""
    match = _near(guess, points, here, params)
    if match.cost > params.doubtful_cost and len(points) >= params.enough_points:
        return _recovered(guess, match, points, here, params)
    return Tracked(
        match.pose, inverted(inverted(guess.covariance) + match.information), is_matched=True
    )


def _recovered(
    guess: Tracked,
    usual: Match,
    points: NDArray[np.float64],
    here: LocalMap,
    params: TrackerParams,
) -> Tracked:
    """Look farther where odometry and scan may contradict each other: wheels slip and are lifted.

    If nothing fits, odometry's word is taken, but not for more than it is worth.
    """
    doubtful = Tracked(guess.pose, params.distrust**2 * guess.covariance, is_matched=False)
    wider = _near(doubtful, points, here, params)
    if wider.cost < usual.cost - params.better:
        return _fused(doubtful, wider)
    if usual.cost < params.bad_cost:
        return _fused(guess, usual)
    return _anywhere(guess, points, here, params) or doubtful


def _fused(guess: Tracked, match: Match) -> Tracked:
    known = inverted(guess.covariance) + match.information
    return Tracked(match.pose, inverted(known), is_matched=True)


def _near(
    guess: Tracked, points: NDArray[np.float64], here: LocalMap, params: TrackerParams
) -> Match:
    """Match within what odometry allows, its own word weighed too."""
    sigma = float(np.sqrt(np.linalg.eigvalsh(guess.covariance[:2, :2])[-1]))
    turn_sigma = float(np.sqrt(guess.covariance[2, 2]))
    radius, turn = (
        min(3.0 * size, limit)
        for size, limit in zip((sigma, turn_sigma), params.search_limits, strict=True)
    )
    few = points[:: max(1, len(points) // params.search_points)]
    # Agreement of an independent point is worth about two in log-likelihood.
    weight = max(1.0, len(few) / params.match.worth) / 2.0
    window = SearchWindow(radius, turn, sigma, turn_sigma, weight)
    found = search(here.raster, few, guess.pose, window)
    start = guess.pose if found is None else found[0]
    known = inverted(guess.covariance)
    return refine(here.surfels, points, start, params.match, (known, guess.pose))


def _anywhere(
    guess: Tracked, points: NDArray[np.float64], here: LocalMap, params: TrackerParams
) -> Tracked | None:
    """Match wherever the robot may have been carried or slipped to; None if it fits nowhere."""
    few = points[:: max(1, len(points) // params.search_points)]
    found = search(here.raster, few, guess.pose, SearchWindow(*params.everywhere), 0.5)
    if found is None:
        return None
    match = refine(here.surfels, points, found[0], params.match)
    if match.cost > params.good_cost:
        return None
    covariance = inverted(match.information + np.eye(3))
    return Tracked(match.pose, covariance, is_matched=True)
