"""Estimates and beliefs as messages, and messages as what the mathematics takes."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.localizer.ekf_pairs import MatchedWalls
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.landmark_sightings import Sightings
from pilotage.localizer.method import LocalizationMethod
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.localization import Belief, Marginal, Mode, PoseEstimate
from pilotage_schemas.mapping import OccupancyGrid
from pilotage_schemas.sensors import LandmarkSightings
from pilotage_schemas.topology import MatchedPairs

SAMPLES = 2000
MODES = 8
MARGINAL_RESOLUTION = 0.2
LEAST_SHARE = 1e-6
"""Share of the belief in a cell of the marginal below which the cell is cut off at the edges."""


def pose_of(pose: NDArray[np.float64]) -> Pose2:
    """Return a pose (3,) as a message part."""
    x, y, theta = (float(value) for value in pose)
    return Pose2(x=x, y=y, theta=theta)


def pose_array(pose: Pose2) -> NDArray[np.float64]:
    """Return a message part as a pose (3,)."""
    return np.array([pose.x, pose.y, pose.theta])


def world_of(grid: OccupancyGrid) -> OccupancyMap:
    """Return a map message as a map."""
    rows, cols = grid.cells.shape
    origin = (grid.origin.x, grid.origin.y, grid.origin.theta)
    return OccupancyMap(GridGeometry(rows, cols, grid.resolution, origin), grid.cells)


def sightings_of(message: LandmarkSightings) -> Sightings:
    """Return the landmarks of a message, as seen from its frame."""
    seen = message.sightings
    return Sightings(
        ranges=np.array([one.range for one in seen], float),
        bearings=np.array([one.bearing for one in seen], float),
        range_sigmas=np.array([one.range_sigma for one in seen], float),
        bearing_sigmas=np.array([one.bearing_sigma for one in seen], float),
        kinds=[one.kind for one in seen],
        identities=[one.identity for one in seen],
    )


def pose_message(estimate: Estimate, pose: NDArray[np.float64], stamp_ns: int) -> PoseEstimate:
    """Return the estimate, its pose moved on by odometry to `pose` (3,) at `stamp_ns`."""
    return PoseEstimate(
        stamp_ns=stamp_ns,
        frame_id="map",
        pose=pose_of(pose),
        covariance=estimate.covariance,
        state=estimate.state,
        confidence=min(1.0, max(0.0, estimate.confidence)),
    )


def belief_message(localizer: LocalizationMethod, map_id: str, stamp_ns: int) -> Belief:
    """Return the belief reduced to samples, modes and a marginal."""
    belief = localizer.belief
    poses, weights = belief.heaviest(SAMPLES)
    samples = np.column_stack([poses, weights / max(weights.sum(), 1e-300)])
    return Belief(
        stamp_ns=stamp_ns,
        frame_id="map",
        map_id=map_id,
        method=localizer.name,
        samples=samples.astype(np.float32),
        entropy=belief.entropy(),
        modes=tuple(
            Mode(mass=min(1.0, mode.mass), pose=pose_of(mode.pose), covariance=mode.covariance)
            for mode in localizer.estimate.modes[:MODES]
        ),
        marginal=_marginal(belief.marginal(), belief.geometry),
        matched=localizer.estimate.matched,
    )


def pairs_message(matched: MatchedWalls, stamp_ns: int) -> MatchedPairs:
    """Return the pairs of the filter's last cycle, lines first."""
    kinds: list[Literal["line", "corner", "door", "passage"]] = ["line"] * matched.lines
    kinds += ["corner"] * (len(matched) - matched.lines)
    return MatchedPairs(
        stamp_ns=stamp_ns,
        frame_id="map",
        kinds=tuple(kinds),
        seen=matched.seen.reshape(-1, 4).astype(np.float32),
        expected=matched.expected.reshape(-1, 4).astype(np.float32),
    )


def _marginal(cells: NDArray[np.float32], geometry: GridGeometry) -> Marginal:
    """Return the marginal on coarser cells, cut to where the belief is."""
    factor = max(1, round(MARGINAL_RESOLUTION / geometry.resolution))
    rows, cols = (-length % factor for length in cells.shape)
    padded = np.pad(cells, ((0, rows), (0, cols)))
    blocks = padded.reshape(padded.shape[0] // factor, factor, -1, factor).sum(axis=(1, 3))
    window = _window(blocks >= LEAST_SHARE)
    resolution = geometry.resolution * factor
    corner = np.array([window[1].start * resolution, window[0].start * resolution, 0.0])
    return Marginal(
        resolution=resolution,
        origin=pose_of(se2.compose(geometry.origin, corner)),
        mass=np.ascontiguousarray(blocks[window], np.float32),
    )


def _window(kept: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the smallest window that holds all kept cells, the first cell if there is none."""
    if not kept.any():
        return slice(0, 1), slice(0, 1)
    spans = []
    for axis in (1, 0):
        index = np.nonzero(kept.any(axis=axis))[0]
        spans.append(slice(int(index[0]), int(index[-1]) + 1))
    return spans[0], spans[1]
