"""What the edges of a door frame in a camera's picture add to the laser's gaps in a wall."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.seeing.door_gaps import Gap, Jamb
from pilotage.topology.seeing.door_walls import Crossings

Placed = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Edges on a wall: places (n,) along it, ascending, and their sigmas (n,), m."""

BAND = (0.04, 0.12)
"""Width of a frame on the face of its wall, m: it shows as two edges."""
BAND_SIGMA_MAX = 0.025
"""Edges known worse cannot be told to be the two of one frame, m."""
ALIKE = 3.0
"""Sigmas within which two places are the same."""
FRAME, FRAME_ERROR = 0.07, 0.015
"""Usual width of a frame and how far they differ from it, m."""
BESIDE = 3
"""Of the two beams on either side of an edge, how many must end on its wall."""
SAME_JAMB = 0.03
"""m between guesses that mean the same."""
EDGE_WORTH, CLEARLY = 2.0, 0.7
"""What an edge that a guess explains is worth, and by how much the best one must lead, in
log-likelihood."""


def sharpened(gap: Gap, edges: Placed) -> Gap:
    """Return a gap with its jambs where the edges say, as far as there are edges at them."""
    return replace(
        gap, first=_sharpened(gap.first, edges, -1.0), second=_sharpened(gap.second, edges, 1.0)
    )


def _sharpened(jamb: Jamb, edges: Placed, outwards: float) -> Jamb:
    """Return a jamb fused with the edges of its frame, unless it is doubtful which these are.

    A frame has an inner edge at the jamb and an outer one. `outwards`: on which side of the jamb
    it lies, by the sign of places along the wall.
    """
    reach = ALIKE * np.sqrt(jamb.variance) + FRAME
    near = np.abs(edges[0] - jamb.place) < reach
    places, variances = edges[0][near], edges[1][near] ** 2 + FRAME_ERROR**2
    guesses = np.concatenate([places, places - outwards * FRAME])
    if len(guesses) == 0:
        return jamb
    off = (guesses - jamb.place) ** 2 / (jamb.variance + np.tile(variances, 2))
    scores = _support(guesses, (places, variances), outwards) - 0.5 * off
    best = int(np.argmax(scores))
    rivals = scores[np.abs(guesses - guesses[best]) > SAME_JAMB]
    if off[best] > ALIKE**2 or scores[best] - rivals.max(initial=-np.inf) < CLEARLY:
        return jamb
    gain = jamb.variance / (jamb.variance + np.tile(variances, 2)[best])
    place = jamb.place + gain * (float(guesses[best]) - jamb.place)
    return Jamb(place, (1.0 - gain) * jamb.variance)


def _support(guesses: NDArray[np.float64], edges: Placed, outwards: float) -> NDArray[np.float64]:
    """Return how many edges (places and variances) each guess (n,) of a jamb explains, 0 to 2."""
    places, variances = edges
    inner = (places - guesses[:, None]) ** 2 / variances
    outer = (places - guesses[:, None] - outwards * FRAME) ** 2 / variances
    fit = [np.exp(-0.5 * off).max(axis=1) for off in (inner, outer)]
    support: NDArray[np.float64] = EDGE_WORTH * (fit[0] + fit[1])
    return support


def framed_doors(
    met: Crossings, edges: Placed, on_wall: float, widths: tuple[float, float]
) -> list[Gap]:
    """Return closed doors flush with their wall: two frames at the right distance, wall between.

    A poster has vertical edges too; what it lacks is a narrow band at either side. Frames of a
    nearer wall's door lie on this one only by their bearing: no beam beside them reaches it.
    """
    bands = [band for band in _bands(edges) if all(_reaches(met, jamb, on_wall) for jamb in band)]
    found = [
        gap
        for _, inner in bands
        for second, _ in bands
        if widths[0] <= second.place - inner.place <= widths[1]
        and (gap := _between(met, inner, second, on_wall)) is not None
    ]
    return [gap for gap in found if not any(_holds(gap, other) for other in found)]


def _reaches(met: Crossings, edge: Jamb, on_wall: float) -> bool:
    """Say whether the beams on either side of an edge end on the wall, but for one of them."""
    beside = np.searchsorted(met.places, edge.place) + np.arange(-2, 2)
    inside = beside[(beside >= 0) & (beside < len(met.places))]
    return bool((np.abs(met.depths[inside]) <= on_wall).sum() >= BESIDE)


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
    return Gap(first, second, met.ended[inside], met.depths[inside])


def _holds(gap: Gap, other: Gap) -> bool:
    """Say whether a gap holds another one: of several, the frame's inner edges count."""
    is_within = gap.first.place <= other.first.place and other.second.place <= gap.second.place
    return is_within and gap is not other
