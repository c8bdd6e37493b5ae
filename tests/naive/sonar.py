"""Sonar grids as formulas: every cell asked, every pair of arcs solved on paper."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.sonar_models import ARC_POINT, BAYES, CENTRE_LINE, GAUSSIAN, BeamShape

Floats = NDArray[np.float64]


def certainty(
    model: int, distance: float, offset: float, reading: Floats, beam: BeamShape
) -> float:
    """Twin of `sonar_kernels.certainty_at`, as the tables of the thesis have it."""
    measured = float(reading[3])
    if model == CENTRE_LINE:
        return _centre_line(distance, offset, measured, beam)
    if model == BAYES:
        return 2.0 * occupancy(distance, offset, measured, beam) - 1.0
    if model == GAUSSIAN:
        return _gaussian(distance, offset, measured, beam)
    if model == ARC_POINT:
        return _arc_point(distance, offset, reading, beam)
    return _uniform(distance, offset, measured, beam)


def occupancy(distance: float, offset: float, measured: float, beam: BeamShape) -> float:
    """Equation 3-10 in its continuous form, row by row."""
    weight = 1.0 / (beam.half_cone**2)
    angular = 1.0 - weight * offset**2 if abs(offset) <= beam.half_cone else 0.0
    trust = 1.0 - (1.0 + np.tanh(2.0 * (distance - beam.visible))) / 2.0
    lamb = beam.certainty * angular * trust
    depths = (distance - measured) / beam.depth
    if distance < measured - 2.0 * beam.depth:
        return float((1.0 - lamb) / 2.0)
    if distance < measured - beam.depth:
        return float((1.0 - lamb * (1.0 - (2.0 + depths) ** 2)) / 2.0)
    if distance < measured + beam.depth:
        return float((1.0 + lamb * (1.0 - depths**2)) / 2.0)
    return 0.5


def add_readings(
    log_odds: Floats,
    corner: tuple[float, float],
    resolution: float,
    echoes: Floats,
    setting: tuple[int, BeamShape],
) -> Floats:
    """Twin of `sonar_kernels.add_readings`: all cells for all echoes, summed in double."""
    model, beam = setting
    total = log_odds.astype(float)
    for row, col in np.ndindex(*log_odds.shape):
        centre = complex(*corner) + resolution * complex(col + 0.5, row + 0.5)
        for echo in echoes:
            seen = (centre - complex(echo[0], echo[1])) * np.exp(-1j * echo[2])
            if seen.real < 0.0:
                continue
            sure = certainty(model, abs(seen), float(np.angle(seen)), echo, beam)
            total[row, col] += 2.0 * math.atanh(min(0.999, max(-0.999, sure)))
    return total


def crossings(arcs: Floats, half_cone: float, least_angle: float) -> list[tuple[float, ...]]:
    """Twin of `sonar_arcs.all_crossings`: x, y, angle, the two arcs, in any order."""
    found: list[tuple[float, ...]] = []
    for first in range(len(arcs)):
        for second in range(first + 1, len(arcs)):
            for point in _circle_crossings(arcs[first], arcs[second]):
                radii = [point - complex(*arcs[i, :2]) for i in (first, second)]
                on_both = all(
                    abs(np.angle(radius * np.exp(-1j * arcs[i, 2]))) <= half_cone
                    for radius, i in zip(radii, (first, second), strict=True)
                )
                cosine = abs((radii[0].conjugate() * radii[1]).real) / abs(radii[0]) / abs(radii[1])
                angle = math.acos(min(1.0, cosine))
                if on_both and angle >= least_angle:
                    found.append((point.real, point.imag, angle, float(first), float(second)))
    return found


def place_on_arc(
    arcs: Floats, index: int, cone: float, rule: tuple[bool, float, Floats, float]
) -> tuple[float, int]:
    """Twin of `arc_median.place_echoes` for one arc: angle from its axis, crossings used."""
    improved, least_angle, weights, least_score = rule
    places = []
    for x, y, angle, first, second in crossings(arcs, cone / 2.0, least_angle):
        if index in (first, second):
            s_1, s_2 = (100.0 * cone * arcs[int(i), 3] for i in (first, second))
            step = min(11, math.floor((math.degrees(angle) - 30.0) / 5.0 + 1e-9))
            patch = 1.0 / math.sin(angle) + 1.0 / math.tan(angle)
            if not improved or 2.0 * patch * weights[step] / (s_1 + s_2) >= least_score:
                radius = complex(x, y) - complex(*arcs[index, :2])
                places.append(float(np.angle(radius * np.exp(-1j * arcs[index, 2]))))
    places.sort()
    if not places:
        return 0.0, 0
    if not improved:
        return float(np.median(places)), len(places)
    if len(places) == 1:
        return places[0], 1
    middles = [(a + b) / 2.0 for a, b in pairwise(places)]
    return sum(middles) / len(middles), len(places)


def close_slice(
    layers: tuple[Floats, Floats, NDArray[np.uint8], NDArray[np.uint8]], limit: float, least: float
) -> tuple[Floats, Floats, NDArray[np.uint8], NDArray[np.uint8]]:
    """Twin of `temporal_filter.close_slice`, by whole arrays."""
    log_odds, window, votes, counts = layers
    total = np.where(window == 0.0, log_odds, np.clip(log_odds + window, -limit, limit))
    says = np.abs(window) >= least
    shifted = ((votes.astype(int) * 2) % 256 + (window > 0.0)).astype(np.uint8)
    more = np.minimum(counts + 1, 8).astype(np.uint8)
    return (
        total,
        np.zeros_like(window),
        np.where(says, shifted, votes),
        np.where(says, more, counts),
    )


def _circle_crossings(first: Floats, second: Floats) -> list[complex]:
    """Where two circles cross, by the triangle of centres and crossing."""
    apart = complex(second[0] - first[0], second[1] - first[1])
    base, a, b = abs(apart), float(first[3]), float(second[3])
    if base < 1e-9 or base > a + b or base < abs(a - b):
        return []
    corner = math.acos(max(-1.0, min(1.0, (a * a + base * base - b * b) / (2.0 * a * base))))
    start = complex(first[0], first[1])
    return [start + a * apart / base * np.exp(1j * side * corner) for side in (1, -1)]


def _centre_line(distance: float, offset: float, measured: float, beam: BeamShape) -> float:
    half = beam.width / 2.0
    aside = distance * math.sin(offset)
    if abs(aside) > half or abs(offset) > math.pi / 2.0 or distance > measured + half:
        return 0.0
    return beam.certainty if distance >= measured - half else -beam.certainty


def _gaussian(distance: float, offset: float, measured: float, beam: BeamShape) -> float:
    if abs(offset) > beam.half_cone:
        return 0.0
    aside = math.exp(-0.5 * (offset / (beam.half_cone / 2.0)) ** 2)
    bell = math.exp(-0.5 * ((distance - measured) / (beam.depth / 2.0)) ** 2)
    return beam.certainty * aside * (bell if distance > measured else 2.0 * bell - 1.0)


def _uniform(distance: float, offset: float, measured: float, beam: BeamShape) -> float:
    if abs(offset) > beam.half_cone or distance > measured + beam.depth:
        return 0.0
    if distance < measured - beam.depth:
        return -beam.certainty
    return beam.certainty * min(1.0, beam.width / (2.0 * beam.half_cone * measured))


def _arc_point(distance: float, offset: float, reading: Floats, beam: BeamShape) -> float:
    measured, place = float(reading[3]), float(reading[4])
    across = measured * (offset - place) / beam.width
    depths = (distance - measured) / beam.depth
    trust = 1.0 - (1.0 + math.tanh(2.0 * (measured - beam.visible))) / 2.0
    if abs(across) < 1.0 and abs(depths) < 1.0:
        return beam.point_certainty * trust * (1.0 - across**2) * (1.0 - depths**2)
    return min(0.0, 2.0 * occupancy(distance, offset, measured, beam) - 1.0)
