"""Kernels that tell walls from people, pillars, legs of chairs and hedges."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.core.line_fit import BeamNoise, Fit, misfit
from pilotage.core.line_merging import is_open
from pilotage.core.line_splitting import LOST, Straightness, distance_along, spacing


class Demands(NamedTuple):
    """What a wall must be."""

    length: float
    """m, at least."""
    beams: float
    """At least."""
    roughness: float
    """Largest mean squared residual of its beams, in variances."""
    radius: float
    """m: what plainly bulges like a smaller disc is none."""
    open_share: float
    """Of its length, through which beams may go."""


@kernel
def is_wall(
    scan: NDArray[np.float64],
    numbers: NDArray[np.int64],
    line: Fit,
    rules: Straightness,
    demands: Demands,
) -> bool:
    """Say whether those beams of a scan (n, 3) with these numbers (m,) lie on a wall."""
    beams = scan[numbers]
    begin, end = extent(beams, line)
    if len(numbers) < demands.beams or end - begin < demands.length:
        return False
    if misfit(beams, line, rules.noise)[1] > demands.roughness:
        return False
    if open_length(scan, numbers, line, rules) > demands.open_share * (end - begin):
        return False
    return not is_round(beams, line, rules.noise, demands.radius)


@kernel
def extent(beams: NDArray[np.float64], line: Fit) -> tuple[float, float]:
    """Return where beams (m, 3) begin and end along their line, m from its normal's foot."""
    along = beams[:, 2] * (math.cos(line.alpha) * beams[:, 1] - math.sin(line.alpha) * beams[:, 0])
    return along.min(), along.max()


@kernel
def open_length(
    scan: NDArray[np.float64], numbers: NDArray[np.int64], line: Fit, rules: Straightness
) -> float:
    """Return how much of a line lies between its beams where others went through it, m.

    Two legs, or the bars of a fence, are straight but open; a wall behind a person is not.
    """
    total = 0.0
    for k in range(1, len(numbers)):
        before, after = numbers[k - 1], numbers[k]
        apart = distance_along(line, scan[before], scan[after])
        if apart > LOST * spacing(line, scan[before], rules.step):
            total += apart if is_open(scan, (before, after), line) else 0.0
    return total


@kernel
def is_round(beams: NDArray[np.float64], line: Fit, noise: BeamNoise, radius: float) -> bool:
    """Say whether beams (m, 3) bulge from their line more like a disc of a radius, m, than not.

    The bulge is fitted as a parabola over the line; it must be plain beyond the noise.
    """
    cos, sin = math.cos(line.alpha), math.sin(line.alpha)
    along = beams[:, 2] * (cos * beams[:, 1] - sin * beams[:, 0])
    middle = 0.5 * (along.min() + along.max())
    half = max(0.5 * (along.max() - along.min()), 1e-6)
    shape = ((along - middle) / half) ** 2
    shape -= shape.mean()
    off = beams[:, 2] * (cos * beams[:, 0] + sin * beams[:, 1]) - line.distance
    power = (shape**2).sum()
    if power < 1e-9:
        return False
    bulge = (shape * (off - off.mean())).sum() / power
    sigma = math.hypot(noise.range_sigma, noise.wall_sigma) / math.sqrt(power)
    return bool(abs(bulge) > 3.0 * sigma and half * half / (2.0 * abs(bulge)) < radius)
