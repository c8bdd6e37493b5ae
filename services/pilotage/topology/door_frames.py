"""What the edges of a door frame in a camera's picture add to the laser's gaps in a wall."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.door_gaps import Gap, Jamb
from pilotage.topology.door_walls import Crossings

Placed = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Edges on a wall: places (n,) along it, ascending, and their sigmas (n,), m."""

BAND = (0.04, 0.12)
"""Width of a frame on the face of its wall, m: it shows as two edges."""
BAND_SIGMA_MAX = 0.025
"""Edges known worse cannot be told to be the two of one frame, m."""
ALIKE = 3.0
"""Sigmas within which two places are the same."""


def sharpened(gap: Gap, places: NDArray[np.float64], sigmas: NDArray[np.float64]) -> Gap:
    """Return a gap with its jambs where the edges say, as far as there are edges at them."""
    return replace(
        gap,
        first=_sharpened(gap.first, places, sigmas),
        second=_sharpened(gap.second, places, sigmas),
    )


def _sharpened(jamb: Jamb, places: NDArray[np.float64], sigmas: NDArray[np.float64]) -> Jamb:
    """Return a jamb fused with the edge that fits it best."""
    variances = sigmas**2
    off = np.abs(places - jamb.place) / np.sqrt(jamb.variance + variances)
    if len(off) == 0 or off.min() > ALIKE:
        return jamb
    best = int(np.argmin(off))
    total = jamb.variance + float(variances[best])
    gain = jamb.variance / total
    place = jamb.place + gain * (float(places[best]) - jamb.place)
    return Jamb(place, jamb.variance * float(variances[best]) / total)


def framed_doors(
    met: Crossings, edges: Placed, on_wall: float, widths: tuple[tuple[float, float], ...]
) -> list[Gap]:
    """Return closed doors flush with their wall: two frames at the right distance, wall between.

    A poster has vertical edges too; what it lacks is a narrow band at either side.
    """
    bands = _bands(edges)
    found = [
        gap
        for first, inner in bands
        for second, outer in bands
        if any(low <= second.place - inner.place <= high for low, high in widths)
        and (gap := _between(met, inner, second, on_wall)) is not None
        and first.place < outer.place
    ]
    return [gap for gap in found if not any(_holds(gap, other) for other in found)]


def _bands(edges: Placed) -> list[tuple[Jamb, Jamb]]:
    """Return pairs of edges a frame's width apart."""
    places, sigmas = edges
    sharp = [
        Jamb(float(place), float(sigma) ** 2)
        for place, sigma in zip(places, sigmas, strict=True)
        if sigma <= BAND_SIGMA_MAX
    ]
    return [
        (one, other)
        for one in sharp
        for other in sharp
        if BAND[0] <= other.place - one.place <= BAND[1]
    ]


def _between(met: Crossings, first: Jamb, second: Jamb, on_wall: float) -> Gap | None:
    """Return the leaf between two jambs if most of the beams there end on the wall."""
    inside = (met.places > first.place) & (met.places < second.place) & (met.depths > -on_wall)
    if inside.sum() < 3 or np.mean(np.abs(met.depths[inside]) <= on_wall) < 0.8:
        return None
    return Gap(first, second, met.places[inside], met.depths[inside])


def _holds(gap: Gap, other: Gap) -> bool:
    """Say whether a gap holds another one: of several, the frame's inner edges count."""
    is_within = gap.first.place <= other.first.place and other.second.place <= gap.second.place
    return is_within and gap is not other
