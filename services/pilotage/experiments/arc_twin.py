"""The arc-transversal methods in plain numpy: what the compiled ones are measured against.

Written from the thesis (Li 2008, 4.3 and 4.4), arc by arc, without a look at the kernels.
"""

import numpy as np

from pilotage.core.angles import wrap
from pilotage.experiments.wall_segments import Floats
from pilotage.mapper.arc_median import CrossingParams


def place_echoes_plainly(
    arcs: Floats, cone: float, params: CrossingParams, *, improved: bool
) -> Floats:
    """Return for arcs (n, 4) the angle (n,) from the axis that the echo came from.

    Arcs are x, y, direction of the axis and range, as in the mapper.
    """
    return np.array(
        [_place(arcs, index, cone, params, improved=improved) for index in range(len(arcs))]
    )


def _place(
    arcs: Floats, index: int, cone: float, params: CrossingParams, *, improved: bool
) -> float:
    places, angles, others = _crossings_with(arcs, index, cone)
    kept = angles >= params.least_angle
    if improved:
        step = np.clip((np.rad2deg(angles) - 30.0) / 5.0 + 1e-9, 0.0, len(params.weights) - 1.0)
        weights = np.array(params.weights)[step.astype(int)]
        lengths_cm = 100.0 * cone * (arcs[index, 3] + arcs[others, 3])
        patch = 1.0 / np.sin(angles) + 1.0 / np.tan(angles)
        kept &= 2.0 * patch * weights / lengths_cm >= params.least_score
    places = np.sort(places[kept])
    if len(places) == 0:
        return 0.0
    if improved and len(places) > 1:
        return float(((places[:-1] + places[1:]) / 2.0).mean())
    return float(np.median(places))


def _crossings_with(arcs: Floats, index: int, cone: float) -> tuple[Floats, Floats, Floats]:
    """Return the places (m,) of crossings on an arc, their angles in rad, and the other arcs."""
    x, y, axis, reach = arcs[index]
    away = arcs[:, :2] - np.array([x, y])
    apart = np.hypot(away[:, 0], away[:, 1])
    meet = (apart > 1e-9) & (apart <= reach + arcs[:, 3]) & (apart >= np.abs(reach - arcs[:, 3]))
    others = np.flatnonzero(meet)
    away, apart, theirs = away[others], apart[others], arcs[others]
    near = (reach**2 - theirs[:, 3] ** 2 + apart**2) / (2.0 * apart)
    up = np.sqrt(np.maximum(0.0, reach**2 - near**2))
    towards = np.arctan2(away[:, 1], away[:, 0])
    here = towards + np.outer([1.0, -1.0], np.arctan2(up, near))
    there = towards + np.outer([1.0, -1.0], np.arctan2(up, near - apart))
    place = wrap(here - axis)
    held = (np.abs(place) <= cone / 2.0) & (np.abs(wrap(there - theirs[:, 2])) <= cone / 2.0)
    between = np.abs(wrap(here - there))
    angle = np.minimum(between, np.pi - between)
    both = np.broadcast_to(others, held.shape)
    return place[held], angle[held], both[held]
