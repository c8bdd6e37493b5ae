"""Lines in a scan in plain numpy: split and merge as the product does it, without compiled code.

The twin that the product is measured against and, in the tests, compared with. A wall is a list
of beams here, and every line is laid through it anew.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.line_extraction import FARTHEST, LineParams
from pilotage.core.line_fit import ROUNDS, BeamNoise
from pilotage.core.line_merging import BEHIND
from pilotage.core.line_splitting import FRAGMENTS, GRAZING, LOST, REFINED
from pilotage.core.lines import Lines

Beams = NDArray[np.float64]
"""(n, 2): bearing in rad, range in m."""


@dataclass(frozen=True)
class _Wall:
    """A line (alpha, distance) away from the laser, laid through beams."""

    beams: Beams
    noise: BeamNoise

    @cached_property
    def fit(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Alpha and distance (2,), and their covariance (2, 2)."""
        bearings, ranges = self.beams.T
        ends = np.column_stack([ranges * np.cos(bearings), ranges * np.sin(bearings)])
        _, vectors = np.linalg.eigh((ends - ends.mean(0)).T @ (ends - ends.mean(0)))
        normal = vectors[:, 0] * (1.0 if ends.mean(0) @ vectors[:, 0] >= 0.0 else -1.0)
        line = np.array([np.arctan2(normal[1], normal[0]), ends.mean(0) @ normal])
        covariance: NDArray[np.float64] = np.zeros((2, 2))
        for _ in range(ROUNDS):
            off, variances, along = _residuals(line, self.beams, self.noise)
            rows = np.column_stack([along, -np.ones(len(along))])
            covariance = np.asarray(np.linalg.inv(rows.T @ (rows / variances[:, None])), float)
            line = line - covariance @ (rows.T @ (off / variances))
        return line, covariance

    def misfits(self, beams: Beams) -> NDArray[np.float64]:
        """Return the squared residuals (n,) of beams in variances."""
        off, variances, _ = _residuals(self.fit[0], beams, self.noise)
        squared: NDArray[np.float64] = off**2 / variances
        return squared

    def places(self, beams: Beams) -> NDArray[np.float64]:
        """Return where beams end along the line (n,), m from the foot of its normal."""
        along: NDArray[np.float64] = beams[:, 1] * np.sin(beams[:, 0] - self.fit[0][0])
        return along


def _residuals(
    line: NDArray[np.float64], beams: Beams, noise: BeamNoise
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return how far beams end beyond a line, the variances and the places along it (n,)."""
    bearings, ranges = beams.T
    cos, sin = np.cos(bearings - line[0]), np.sin(bearings - line[0])
    ahead = cos > 1e-6
    foretold = np.where(ahead, line[1] / np.where(ahead, cos, 1.0), ranges)
    along = np.clip(foretold, 0.5 * ranges, 2.0 * ranges) * sin
    variances = (noise.range_sigma * cos) ** 2 + (noise.bearing_sigma * along) ** 2
    return ranges * cos - line[1], variances + noise.wall_sigma**2 + 1e-10, along


def plain_lines(
    ranges: NDArray[np.float64], angles: tuple[float, float], params: LineParams
) -> Lines:
    """Return the walls in a scan (n,), as `line_extraction.extract_lines` does."""
    scan = np.column_stack([angles[0] + angles[1] * np.arange(len(ranges)), ranges])
    scan = scan[:: 1 if angles[1] > 0.0 else -1]
    scan[~((scan[:, 1] > 0.0) & (scan[:, 1] < FARTHEST)), 1] = 0.0
    twin = _Twin(scan, abs(angles[1]), params)
    return twin.lines()


@dataclass(frozen=True)
class _Twin:
    """One scan (n, 2), 0 where nothing came back, and what a wall in it is."""

    scan: Beams
    step: float
    params: LineParams

    def lines(self) -> Lines:
        """Return the walls: split, settle the borders, merge, drop what is no wall."""
        hits = [int(k) for k in np.flatnonzero(self.scan[:, 1] > 0.0)]
        pieces = [piece for chain in self._chains(hits) for piece in self._split(chain)]
        walls = self._merged(self._settled(pieces))
        return _as_lines([self._wall(hits) for hits in walls if self._is_wall(hits)])

    def _wall(self, hits: list[int]) -> _Wall:
        return _Wall(self.scan[hits], self.params.noise)

    def _chains(self, hits: list[int]) -> list[list[int]]:
        """Cut hits where neighbours lie too far apart."""
        chains: list[list[int]] = []
        for k in hits:
            if chains and not self._breaks(chains[-1][-1], k):
                chains[-1].append(k)
            else:
                chains.append([k])
        return chains

    def _breaks(self, one: int, two: int) -> bool:
        (b1, r1), (b2, r2) = self.scan[[one, two]]
        apart = abs(r1 * np.exp(1j * b1) - r2 * np.exp(1j * b2))
        turn = min(b2 - b1, 2.0 * self.step)
        return bool(apart > self.params.gap + turn * min(r1, r2) / np.tan(GRAZING))

    def _split(self, hits: list[int]) -> list[list[int]]:
        """Split a chain until every piece is straight."""
        if len(hits) < 3:
            return [hits]
        wall = self._wall(hits)
        beams = self.scan[hits]
        if wall.misfits(beams).max() > self.params.split_sigmas**2:
            ends = beams[:, 1] * np.exp(1j * beams[:, 0])
            aside = np.abs(np.imag(np.conj(ends[-1] - ends[0]) * (ends - ends[0])))
            at = 1 + int(np.argmax(aside[1:-1]))
            return self._split(hits[:at]) + self._split(hits[at:])
        apart = np.diff(wall.places(beams))
        open_at = [i for i in range(1, len(hits)) if apart[i - 1] > self._widest(wall, hits[i - 1])]
        if open_at:
            return self._split(hits[: open_at[0]]) + self._split(hits[open_at[0] :])
        return [hits]

    def _widest(self, wall: _Wall, hit: int) -> float:
        return max(self.params.gap, self._lost(wall, hit))

    def _lost(self, wall: _Wall, hit: int) -> float:
        """Return how far apart beams meet a wall if others between them were lost, m."""
        bearing, measured = self.scan[hit]
        return float(LOST * self.step * measured / max(np.cos(bearing - wall.fit[0][0]), 0.05))

    def _settled(self, pieces: list[list[int]]) -> list[list[int]]:
        """Let beams near the border of two pieces join the one that they fit better."""
        settled = [list(piece) for piece in pieces]
        for i in range(len(settled) - 1):
            one, two = settled[i], settled[i + 1]
            if len(one) < 3 or len(two) < 3:
                continue
            far = self._distance(self._wall(one), self._wall(two), self.scan[two[0]])
            if far <= self.params.merge_chi2 or self._breaks(one[-1], two[0]):
                continue
            both, border = one + two, len(one)
            beams = self.scan[both]
            worse = self._wall(one).misfits(beams) - self._wall(two).misfits(beams)
            # What it costs, against the border as it is, to have it at each place.
            costs = np.concatenate([[0.0], np.cumsum(worse)])
            low, high = max(2, border - REFINED), min(len(both) - 2, border + REFINED)
            order = [border, *range(border + 1, high + 1), *range(border - 1, low - 1, -1)]
            best = min(order, key=lambda at: costs[at])
            settled[i], settled[i + 1] = both[:best], both[best:]
        return settled

    def _merged(self, pieces: list[list[int]]) -> list[list[int]]:
        """Put pieces of one wall together, each with those that follow."""
        count = len(pieces)
        walls = {i: list(piece) for i, piece in enumerate(pieces) if len(piece) > 1}
        for i in range(count):
            reached = i
            for j in range(i + 1, count):
                near = j - reached <= FRAGMENTS or i + count - j <= FRAGMENTS
                if not (near and i in walls and j in walls):
                    continue
                if self._is_one(walls[i], walls[j], (pieces[i], pieces[j])):
                    way = self._goes_on(walls[i], walls[j])
                    if way > 0:
                        walls[i], reached = walls[i] + walls.pop(j), j
                    elif way < 0:
                        walls[i] = walls.pop(j) + walls[i]
        return list(walls.values())

    def _is_one(self, one: list[int], two: list[int], cores: tuple[list[int], list[int]]) -> bool:
        """Say whether two walls are one; `cores` are the pieces that they began as."""
        first, second = self._wall(one), self._wall(two)
        unsure = cores[0] if first.fit[1][0, 0] > second.fit[1][0, 0] else cores[1]
        middle = self.scan[unsure[(len(unsure) - 1) // 2]]
        if self._distance(first, second, middle) > self.params.merge_chi2:
            return False
        together = self._wall(one + two)
        return bool(together.misfits(together.beams).max() <= self.params.split_sigmas**2)

    @staticmethod
    def _distance(one: _Wall, two: _Wall, beam: NDArray[np.float64]) -> float:
        """Return the squared Mahalanobis distance of two lines as they pass a beam's end."""
        off, spread = np.zeros(2), np.zeros((2, 2))
        for sign, (line, covariance) in ((1.0, one.fit), (-1.0, two.fit)):
            cos, sin = np.cos(beam[0] - line[0]), np.sin(beam[0] - line[0])
            to_here = np.array([[1.0, 0.0], [-beam[1] * sin, 1.0]])
            off += sign * np.array([line[0], line[1] - beam[1] * cos])
            spread += to_here @ covariance @ to_here.T
        off[0] = wrap(float(off[0]))
        return float(off @ np.linalg.solve(spread, off))

    def _goes_on(self, wall_hits: list[int], piece: list[int]) -> int:
        """Say whether a piece goes on beyond the end (1) or before the start (-1) of a wall."""
        wall = self._wall(wall_hits)
        start, end = wall_hits[0], wall_hits[-1]
        at = wall.places(self.scan)
        if at[piece[0]] < at[end]:
            return -1 if at[start] - at[piece[-1]] <= self._widest(wall, start) else 0
        apart = at[piece[0]] - at[end]
        if apart <= self._widest(wall, end):
            return 1
        hidden = not self._is_open(wall, end, piece[0])
        return 1 if hidden and apart <= self.params.hidden_gap else 0

    def _is_open(self, wall: _Wall, before: int, after: int) -> bool:
        between = self.scan[before + 1 : after]
        depth = between[:, 1] * np.cos(between[:, 0] - wall.fit[0][0])
        return bool(((between[:, 1] == 0.0) | (depth > wall.fit[0][1] + BEHIND)).any())

    def _is_wall(self, hits: list[int]) -> bool:
        if len(hits) < self.params.least_beams:
            return False
        wall = self._wall(hits)
        along = wall.places(wall.beams)
        openings = [
            apart
            for before, after, apart in zip(hits, hits[1:], np.diff(along), strict=False)
            if apart > self._lost(wall, before) and self._is_open(wall, before, after)
        ]
        if sum(openings) > self.params.open_share * np.ptp(along):
            return False
        rough = wall.misfits(wall.beams).mean() > self.params.most_rough
        short = np.ptp(along) < self.params.least_length
        return not (rough or short or self._is_round(wall))

    def _is_round(self, wall: _Wall) -> bool:
        """Fit a parabola over the line: is it plain, and as curved as a person?"""
        along, noise = wall.places(wall.beams), self.params.noise
        half = np.ptp(along) / 2.0
        shape = ((along - along.min()) / half - 1.0) ** 2
        off = wall.beams[:, 1] * np.cos(wall.beams[:, 0] - wall.fit[0][0])
        power = np.sum((shape - shape.mean()) ** 2)
        bulge = abs(np.sum((shape - shape.mean()) * off) / power)
        sigma = np.hypot(noise.range_sigma, noise.wall_sigma) / np.sqrt(power)
        return bool(bulge > 3.0 * sigma and half**2 / (2.0 * bulge) < self.params.round_radius)


def _as_lines(walls: list[_Wall]) -> Lines:
    """Return walls as lines whose normals point to the laser."""
    if not walls:
        return Lines.none()
    ends, polar, covariances = [], [], []
    for wall in walls:
        (alpha, distance), covariance = wall.fit
        along = wall.places(wall.beams)
        normal = np.array([np.cos(alpha), np.sin(alpha)])
        to_the_left = np.array([-normal[1], normal[0]])
        ends.append([distance * normal + at * to_the_left for at in (along.min(), along.max())])
        polar.append([wrap(alpha + np.pi), -distance])
        covariances.append(covariance * [[1.0, -1.0], [-1.0, 1.0]])
    return Lines(np.array(ends), np.array(polar), np.array(covariances))
