"""Walls that several lines of a scan lie on, and where each beam ends with respect to them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.lines import Lines
from pilotage.topology.seeing.door_edges import SeenEdges
from pilotage.topology.seeing.scan_view import ScanView

SAME_DIRECTION = float(np.cos(np.deg2rad(6.0)))
SAME_WALL = 0.06
"""m that the ends of lines of one wall may lie off it."""
DEEPEST_LEAF = 0.25
"""m behind the face of a wall."""
STEEPEST = float(np.sin(np.deg2rad(4.0)))
"""Beams more grazing than this say nothing about a wall."""


@dataclass(frozen=True)
class Wall:
    """A straight wall as seen from the origin of the laser.

    It is where `normal` . p = `rho`, m; `normal` (2,) points to the laser, so `rho` < 0. A place on
    it is its coordinate along `tangent` (2,). `sigma` m: how exactly it is known.
    """

    normal: NDArray[np.float64]
    rho: float
    sigma: float

    @property
    def tangent(self) -> NDArray[np.float64]:
        """Direction along the wall, the free side on its left."""
        return np.array([self.normal[1], -self.normal[0]])

    def point(self, place: float) -> NDArray[np.float64]:
        """Return the point (2,) at a place along the wall."""
        return self.rho * self.normal + place * self.tangent


@dataclass(frozen=True)
class Crossings:
    """Where rays cross a wall, by place along it.

    `places` (n,) m ascending; `ended` (n,) m: places beside which the beams ended; `depths` (n,) m
    by which they went on beyond the wall, measured along the normal, negative if they ended before;
    `steps` (n,) m along the wall between one beam and the next.
    """

    places: NDArray[np.float64]
    ended: NDArray[np.float64]
    depths: NDArray[np.float64]
    steps: NDArray[np.float64]


def walls_of(view: ScanView, least_support: float) -> list[Wall]:
    """Return the walls of a scan, the longest first: lines that continue each other are one.

    `least_support` m of seen wall in all. What lies a little behind a longer one is no wall, but
    the leaves of its doors.
    """
    left = view.lines.chosen(np.argsort(-view.lines.lengths))
    walls: list[Wall] = []
    while len(left):
        belongs = _continues(left, 0)
        own, left = left.chosen(belongs), left.chosen(~belongs)
        wall = _fitted(own)
        if own.lengths.sum() >= least_support and not any(_is_leaf(wall, other) for other in walls):
            walls.append(wall)
    return walls


def _is_leaf(wall: Wall, other: Wall) -> bool:
    """Say whether a wall lies behind a longer one as a leaf would."""
    behind = other.rho - wall.rho
    return bool(wall.normal @ other.normal > SAME_DIRECTION and 0.0 < behind < DEEPEST_LEAF)


def _continues(lines: Lines, which: int) -> NDArray[np.bool_]:
    """Say which lines (n,) lie on the same wall as one of them."""
    alpha, rho = lines.polar[which]
    normal = np.array([np.cos(alpha), np.sin(alpha)])
    facing = np.cos(lines.polar[:, 0] - alpha) > SAME_DIRECTION
    off = np.abs(lines.ends @ normal - rho).max(axis=1)
    belongs: NDArray[np.bool_] = facing & (off < SAME_WALL)
    belongs[which] = True
    return belongs


def _fitted(lines: Lines) -> Wall:
    """Return the wall through lines: their ends' straight line, weighted by length."""
    weights = np.repeat(lines.lengths, 2)
    points = lines.ends.reshape(-1, 2)
    middle = weights @ points / weights.sum()
    spread = (points - middle).T @ ((points - middle) * weights[:, None])
    normal = np.linalg.eigh(spread)[1][:, 0]
    alpha = lines.polar[0, 0]
    normal = normal if normal @ (np.cos(alpha), np.sin(alpha)) > 0.0 else -normal
    sigma = float(np.sqrt(lines.covariances[:, 1, 1].min()))
    return Wall(normal, float(normal @ middle), sigma)


def crossings(view: ScanView, wall: Wall, reach: float) -> Crossings:
    """Return where beams meet a wall within `reach` m, and how far beyond it they went."""
    towards = -view.directions @ wall.normal
    meets = (towards > STEEPEST) & ~np.isnan(view.ranges)
    meets &= -wall.rho <= reach * towards
    towards, ranges = towards[meets], view.ranges[meets]
    distances = -wall.rho / towards
    along = view.directions[meets] @ wall.tangent
    places, ended = along * distances, along * ranges
    depths = (ranges - distances) * towards
    steps = np.abs(view.angles[1]) * distances / towards
    order = np.argsort(places)
    return Crossings(places[order], ended[order], depths[order], steps[order])


def edges_on(
    edges: SeenEdges, wall: Wall, reach: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places (n,) along a wall where edges would lie on it, ascending, and their sigmas.

    The bearing of an edge and the wall line of the laser give the place (Zhuang 2005, 2.2).
    """
    directions = np.stack([np.cos(edges.bearings), np.sin(edges.bearings)], axis=1)
    towards = -directions @ wall.normal
    meets = towards > STEEPEST
    distances = (wall.normal @ edges.origin - wall.rho) / np.where(meets, towards, 1.0)
    meets &= (distances > 0.0) & (distances <= reach)
    places = edges.origin @ wall.tangent + (directions @ wall.tangent * distances)[meets]
    sigmas = (edges.sigma * distances / towards)[meets]
    order = np.argsort(places)
    return places[order], sigmas[order]
