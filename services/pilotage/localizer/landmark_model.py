"""How likely sightings of landmarks are from a pose: range and bearing, class or identity.

A sighting of range r and bearing b, of a landmark at distance d and direction a off the robot's
heading, has the likelihood

    p = (1 - outlier) * exp(-(r - d)^2 / (2 s_r^2) - (b - a)^2 / (2 s_b^2)) + outlier

relative to its best. Where the sensor cannot tell a landmark from its likes, the most likely one
of the class counts (maximum likelihood association). The mean over the class, which supposes
nothing, differs by the factor 1 / m for all poses alike as long as landmarks stand farther apart
than they are measured; taken here it would let the outliers drown a class of many.

A landmark that the map does not have says nothing: likelihood 1.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer import landmark_kernels as kernels
from pilotage.localizer.landmark_sightings import Sightings
from pilotage.localizer.landmark_states import SightingsLikelihood
from pilotage.localizer.markov_grid import MarkovGrid

OUTLIER = 0.05
"""Likelihood of any sighting, relative to the best: things are mistaken for landmarks."""


def landmark_likelihoods(
    poses: NDArray[np.float64],
    seen: Sightings,
    landmarks: LandmarkMap,
    outlier: float = OUTLIER,
) -> NDArray[np.float64]:
    """Return log p (n,) of all sightings together from poses (n, 3); zero at the best."""
    total = np.zeros(len(poses))
    sightings = _sightings(seen, landmarks, outlier)
    kernels.add_sightings(np.ascontiguousarray(poses, np.float64), sightings, total)
    return total


def weigh_landmarks(
    grid: MarkovGrid,
    seen: Sightings,
    landmarks: LandmarkMap,
    novelty: float = 1.0,
    outlier: float = OUTLIER,
) -> None:
    """`Bel <- P(sightings | l)^novelty Bel`: the belief weighed in place, and its rest bounded.

    A state is as wide as a cell and a heading bin: uniform, which adds w^2 / 12 to variances.
    """
    geometry, step = grid.grid.geometry, grid.grid.heading_step
    wider = geometry.resolution**2 / 12.0
    around = wider / np.maximum(seen.ranges, geometry.resolution) ** 2 + step**2 / 12.0
    blurred = replace(
        seen,
        range_sigmas=np.sqrt(seen.range_sigmas**2 + wider),
        bearing_sigmas=np.sqrt(seen.bearing_sigmas**2 + around),
    )
    sightings = _sightings(blurred, landmarks, outlier)
    in_grid = geometry.grid_from_map(sightings.positions)
    firsts = np.zeros((grid.grid.headings, 3), np.int64)
    firsts[:, 0] = np.arange(grid.grid.headings)
    corners = se2.compose(se2.inverse(geometry.origin), grid.poses_of(firsts))
    known = sightings._replace(positions=np.ascontiguousarray(in_grid))
    grid.weigh_states(SightingsLikelihood((corners, geometry.resolution), known, novelty))


def _sightings(seen: Sightings, landmarks: LandmarkMap, outlier: float) -> kernels.KnownSightings:
    """Return the sightings of mapped landmarks, each with the places that it may belong to."""
    of_each = [
        landmarks.candidates(kind, identity)
        for kind, identity in zip(seen.kinds, seen.identities, strict=True)
    ]
    known = [i for i, candidates in enumerate(of_each) if len(candidates)]
    counts = [len(of_each[i]) for i in known]
    values = np.column_stack(
        [seen.ranges, wrap(seen.bearings), seen.range_sigmas, seen.bearing_sigmas]
    )
    return kernels.KnownSightings(
        np.ascontiguousarray(values[known], np.float64),
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        np.concatenate([np.empty((0, 2)), *(of_each[i] for i in known)]),
        outlier,
    )
