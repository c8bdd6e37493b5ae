"""Upright edges in a grey-scale picture, as bearings; for the simulator's pictures and real ones.

A level camera shows upright edges as columns. So the steps of brightness along each row are found
to a part of a pixel, brought to the bearing that the lens says, and counted there: where enough
rows agree on a bearing is an edge. Floors, ceilings and slanted things spread over many bearings.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pilotage.robot.pinhole import PinholeCamera

cv2.setNumThreads(1)  # a frame is too small to share, and the other core is another service's


Shades = NDArray[np.float32]

SLOPE = np.array([-0.054, -0.242, 0.0, 0.242, 0.054], np.float32) / 0.7
"""Slope of a Gaussian of one pixel: shades from pixel to pixel."""
SMOOTH = np.array([0.1, 0.2, 0.4, 0.2, 0.1], np.float32)
LEAST_SLOPE = 0.2
"""Shades a pixel: less is rounding."""
APART = 1.0
"""Pixels by which rows may differ about an edge."""
CLEARANCE = 3.0
"""Pixels between two edges of the same sign."""


@dataclass(frozen=True)
class EdgeParams:
    """What counts as an upright edge."""

    least_rise: float = 0.25
    """m a metre that it must rise: a door does up to 8 m away; posters and boxes are lower."""
    least_share: float = 0.4
    """Or, in a low picture, the share of its rows that must show it."""
    least_slope: float = 0.05
    """Least change from pixel to pixel, in standard deviations of the picture's shades."""
    noise_factor: float = 4.0
    """The same in standard deviations of its noise, which is judged from the picture."""
    sigma_px: float = 0.5
    """Standard deviation of an edge's place, pixels: the blur of lens and floor plan, not noise."""
    widest: int = 640
    """Larger pictures are made smaller first, pixels."""


@dataclass(frozen=True)
class VerticalEdgesFound:
    """Edges from left to right.

    `bearings` (n,) rad left of the optical axis, each with standard deviation `sigma` rad;
    `strengths` (n,): share of the rows that show the edge, negative where it gets darker to the
    right.
    """

    bearings: NDArray[np.float64]
    strengths: NDArray[np.float64]
    sigma: float


def vertical_edges(
    picture: NDArray[np.uint8], camera: PinholeCamera, params: EdgeParams | None = None
) -> VerticalEdgesFound:
    """Return the upright edges of a picture (h, w) of shades; ValueError if it is no picture."""
    chosen = params or EdgeParams()
    if picture.ndim != 2 or min(picture.shape) < 3:
        raise ValueError(f"a grey-scale picture (h, w) is needed, this is {picture.shape}")
    small, lens = _fitting(picture, camera, chosen.widest)
    places, is_rise = _steps(small, chosen)
    upright = lens.focal * np.tan(lens.bearings(places, small.shape))
    needed = min(chosen.least_rise * lens.focal, chosen.least_share * small.shape[0])
    rises, falls = _agreed(upright[is_rise], needed), _agreed(upright[~is_rise], needed)
    found = np.array([*rises, *((column, -rows) for column, rows in falls)]).reshape(-1, 2)
    found = found[np.argsort(-found[:, 0])]
    bearings = np.arctan(found[:, 0] / lens.focal)
    return VerticalEdgesFound(bearings, found[:, 1] / small.shape[0], chosen.sigma_px / lens.focal)


def _fitting(
    picture: NDArray[np.uint8], camera: PinholeCamera, widest: int
) -> tuple[Shades, PinholeCamera]:
    """Return a picture small enough, and the camera that would have taken it."""
    share = widest / picture.shape[1]
    if share >= 1.0:
        return picture.astype(np.float32), camera
    size = widest, max(round(picture.shape[0] * share), 3)
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return small.astype(np.float32), camera.scaled(share)


def _steps(shades: Shades, params: EdgeParams) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return places (n, 2) = u, v where rows change most, and whether they get brighter there."""
    slopes = cv2.sepFilter2D(shades, cv2.CV_32F, SLOPE, SMOOTH, borderType=cv2.BORDER_REPLICATE)
    steep = np.abs(slopes)
    noise = float(np.median(steep[::2, ::3])) / 0.6745
    spread = float(cv2.meanStdDev(shades)[1][0, 0])
    least = max(params.noise_factor * noise, params.least_slope * spread, LEAST_SLOPE)
    left, here, right = steep[:, :-2], steep[:, 1:-1], steep[:, 2:]
    rows, cols = np.nonzero((here > least) & (here >= left) & (here > right))
    before, peak, after = left[rows, cols], here[rows, cols], right[rows, cols]
    # The top of the parabola through three slopes: a step's place to a part of a pixel.
    aside = 0.5 * (before - after) / (before - 2.0 * peak + after)
    places = np.stack([cols + 1.0 + aside, rows], axis=1)
    return places, slopes[rows, cols + 1] > 0.0


def _agreed(columns: NDArray[np.float64], needed: float) -> list[tuple[float, float]]:
    """Return columns on which at least `needed` of the places (n,) agree, with how many do."""
    if len(columns) == 0:
        return []
    ordered = np.sort(columns)
    first = np.arange(len(ordered))
    last = np.searchsorted(ordered, ordered + 2.0 * APART, side="right")
    is_free = np.ones(len(ordered), bool)
    found: list[tuple[float, float]] = []
    while True:
        # Places taken by an edge count no more, neither as the first nor among the others.
        counted = np.concatenate([[0], np.cumsum(is_free)])
        rows = np.where(is_free, counted[last] - counted[first], 0)
        best = int(np.argmax(rows))
        if rows[best] < needed:
            return found
        column = float(np.median(ordered[first[best] : last[best]]))
        found.append((column, float(rows[best])))
        is_free &= np.abs(ordered - column) > CLEARANCE
