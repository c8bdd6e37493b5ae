"""Places known again: where a new keyframe fits on what older ones saw."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.mapper.correlative_search import SearchWindow, search
from pilotage.mapper.keyframes import KeyframeGraph
from pilotage.mapper.laser_grid_scans import DrawnScan
from pilotage.mapper.odometry_drift import turned_covariance
from pilotage.mapper.pose_edges import Edge, inverted
from pilotage.mapper.scan_matcher import Match, refine
from pilotage.mapper.scan_tracker import LocalMap, TrackerParams, local_map
from pilotage.mapper.sight import seen_past
from pilotage.mapper.surfel_kernels import thin_points
from pilotage.mapper.visibility_kernels import beams_through_walls

ON_WALL = 0.12
"""m from a surfel up to which a point lies on its wall."""
MARGIN = 0.3
"""m by which a beam must go on behind a wall, or past a point, to speak against it."""


@dataclass(frozen=True)
class Agreement:
    """How well two places must agree to be the same."""

    explained: float
    """Share of the new points that lie on walls of the old place."""
    contradicted: float
    """Share, of those and of the points that the old place saw past, of the latter."""
    through: float
    """Share of the new beams that go through walls of the old place, as people and doors make."""
    cost: float
    """Robust cost of the match."""


@dataclass(frozen=True)
class ClosureParams:
    """When a place counts as known again."""

    recent: int = 20
    """So many newest keyframes are the tracker's; only older ones close a loop."""
    near: float = 3.0
    """m between places that see much the same."""
    doubt: tuple[float, float] = (0.015, 0.005)
    """m and rad that the pose of one keyframe seen from another is unsure by, per m of way."""
    least_doubt: tuple[float, float] = (0.05, 0.02)
    """m and rad, however short the way is."""
    widest: tuple[float, float] = (6.0, 0.6)
    """m and rad; the search goes to three times the doubt, but no farther."""
    places: int = 2
    """So many old places are tried for each keyframe."""
    around: int = 10
    """So many keyframes before and after make an old place."""
    company: int = 6
    """So many keyframes before the new one are matched together with it."""
    sight: float = 12.0
    """m; what is farther away is left out."""
    search_points: int = 200
    """So many points take part in the search."""
    least_score: float = 0.4
    """Mean value of the points from which on a place may be the same."""
    agreement: Agreement = field(default_factory=lambda: Agreement(0.5, 0.10, 0.35, 0.6))
    """What must agree where the pose is nearly known already."""
    far_agreement: Agreement = field(default_factory=lambda: Agreement(0.6, 0.10, 0.25, 0.4))
    """And where a place half a metre and more from it is believed."""
    far: float = 0.5
    """m of doubt from which on this is asked."""
    error: tuple[float, float] = (0.01, 0.004)
    """m and rad: what a closure is never known better than."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """An old `place` with the map around it, and `points` (n, 2) of the newest matched there."""

    place: int
    there: LocalMap
    points: NDArray[np.float64]
    match: Match


def find_closures(
    graph: KeyframeGraph, params: ClosureParams, tracker: TrackerParams
) -> list[Edge]:
    """Return edges from old keyframes to the newest, where it sees what they saw."""
    new = graph.newest
    old = list(graph.keyframes)[: -params.recent]
    if not old:
        return []
    lengths = graph.lengths_from(new)
    places = _places(graph, old, lengths, params)
    found = [_closure(graph, place, lengths[place], params, tracker) for place in places]
    return [edge for edge in found if edge is not None]


def _places(
    graph: KeyframeGraph, old: list[int], lengths: dict[int, float], params: ClosureParams
) -> list[int]:
    """Return the nearest keyframes of the runs that pass by where the newest may be."""
    here = graph.poses[graph.newest]
    poses = np.array([graph.poses[number] for number in old])
    apart = np.hypot(poses[:, 0] - here[0], poses[:, 1] - here[1])
    ways = np.array([lengths[number] for number in old])
    doubts = params.least_doubt[0] + params.doubt[0] * ways
    near = np.nonzero(apart < params.near + 2.0 * doubts)[0]
    if not len(near):
        return []
    runs = np.split(near, np.nonzero(np.diff(near) > params.recent)[0] + 1)
    nearest = sorted((float(apart[run].min()), old[run[apart[run].argmin()]]) for run in runs)
    return [number for _, number in nearest[: params.places]]


def _doubt(length: float, params: ClosureParams) -> tuple[float, float]:
    """Return the standard deviations in m and rad of a pose seen over a way of `length` m."""
    way, turn = (
        least + per_metre * length
        for least, per_metre in zip(params.least_doubt, params.doubt, strict=True)
    )
    return way, turn


def _closure(
    graph: KeyframeGraph,
    place: int,
    length: float,
    params: ClosureParams,
    tracker: TrackerParams,
) -> Edge | None:
    """Return the edge from a place to the newest keyframe, None if that is not there."""
    sigma, turn_sigma = _doubt(length, params)
    points, old = _company_points(graph, params), _place_points(graph, place, params)
    if not len(points) or not len(old):
        return None
    there = local_map(old, tracker, 5 if sigma < 0.5 else 6)
    guess = se2.between(graph.poses[place], graph.poses[graph.newest])
    few = points[:: max(1, len(points) // params.search_points)]
    window = SearchWindow(
        min(3.0 * sigma, params.widest[0]),
        min(3.0 * turn_sigma, params.widest[1]),
        2.0 * sigma,
        2.0 * turn_sigma,
        0.01 * len(few),
    )
    found = search(there.raster, few, guess, window, params.least_score)
    if found is None:
        return None
    match = refine(there.surfels, points, found[0], tracker.match)
    asked = params.agreement if sigma < params.far else params.far_agreement
    if not _is_same(graph, Candidate(place, there, points, match), asked):
        return None
    known = inverted(match.information + np.eye(3))
    covariance = turned_covariance(-float(match.pose[2]), known)
    floor = np.diag([params.error[0] ** 2, params.error[0] ** 2, params.error[1] ** 2])
    return Edge(place, graph.newest, match.pose, covariance + floor, is_closure=True)


def _place_points(graph: KeyframeGraph, place: int, params: ClosureParams) -> NDArray[np.float64]:
    """Return what was seen around an old keyframe, from its pose."""
    numbers = list(graph.keyframes)
    at = numbers.index(place)
    around = numbers[max(0, at - params.around) : at + params.around + 1]
    return _in_sight(graph.points_of(around, place), params)


def _company_points(graph: KeyframeGraph, params: ClosureParams) -> NDArray[np.float64]:
    """Return what the newest keyframes saw, from the newest one's pose."""
    points = graph.points_of(graph.latest(params.company + 1), graph.newest)
    return thin_points(_in_sight(points, params), 0.1)


def _in_sight(points: NDArray[np.float64], params: ClosureParams) -> NDArray[np.float64]:
    near: NDArray[np.bool_] = np.hypot(points[:, 0], points[:, 1]) < params.sight
    return np.ascontiguousarray(points[near])


def _is_same(graph: KeyframeGraph, candidate: Candidate, asked: Agreement) -> bool:
    """Say whether the place looks as the newest keyframes saw it, matched so.

    Walls where it has walls, nothing where it saw nothing: and whatever else two alike rooms share,
    nobody sees through the wall between them.
    """
    match, count = candidate.match, len(candidate.points)
    moved = se2.transform_points(match.pose, candidate.points)
    gaps = candidate.there.surfels.distances_at(moved)
    explained = int((gaps < ON_WALL).sum())
    past = seen_past(moved, _scans_around(graph, candidate.place), MARGIN)
    contradicted = int((past & (gaps > MARGIN)).sum())
    return (
        match.cost <= asked.cost
        and explained >= asked.explained * count
        and contradicted <= asked.contradicted * (explained + contradicted)
        and _share_through(graph, match, candidate.there) <= asked.through
    )


def _scans_around(graph: KeyframeGraph, place: int) -> list[DrawnScan]:
    """Return some scans of an old place, from the pose of its keyframe."""
    numbers = list(graph.keyframes)
    at = numbers.index(place)
    some = numbers[max(0, at - 8) : at + 9 : 4]
    seen_from = graph.poses[place]
    return [
        graph.keyframes[number].scans[-1].moved(se2.between(seen_from, graph.poses[number]))
        for number in some
    ]


def _share_through(graph: KeyframeGraph, match: Match, there: LocalMap) -> float:
    """Return the share of the newest keyframe's beams that go through walls of the place."""
    through = total = 0
    for scan in graph.keyframes[graph.newest].scans:
        points = se2.transform_points(match.pose, np.vstack([scan.laser, scan.ends[scan.is_hit]]))
        through += beams_through_walls(points[0], points[1:], there.surfels, MARGIN)
        total += len(points) - 1
    return through / max(1, total)
