"""Follows a robot that sees little at a time: many ways are held possible until scans decide.

One scan of a few beams cannot be matched. But each particle remembers its own recent way and so
where it saw points, and a later scan tells particles apart by whether its points lie on the walls
that these show (Rao-Blackwellised as Beevers & Huang 2006, SLAM with sparse sensing, but without
maps: a recent scan's points are few enough to be looked through). What odometry is worth is learnt
on the way: each particle has its own opinion, and those with a wrong one die out.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.odometry_drift import DriftParams, step_sigmas
from pilotage.mapper.odometry_sense import OdometryStep
from pilotage.mapper.particle_kernels import Cloud, Moved, Sight, note, propose, weigh

SIGHT = Sight(sigma=0.05, reach=0.3, stray=0.1, unknown=-1.2)
DRIFT = DriftParams(way_per_root_metre=0.02, standing=(0.005, 0.003))


@dataclass(frozen=True)
class ParticleParams:
    """How many ways are held possible, and what may happen on them."""

    particles: int = 200
    scans: int = 100
    """So many scans are remembered."""
    points: int = 16
    """Of a scan so many points are weighed at most."""
    sight: Sight = SIGHT
    drift: DriftParams = DRIFT
    temper: float = 0.7
    """Points err together a little: so much of their log-likelihood counts."""
    rough: float = 0.05
    """Share of the steps with errors four times as large."""
    slip: float = 0.01
    """Share of the steps with some of the way slipped."""
    wander: float = 0.05
    """By which the logarithms of what odometry is worth change per step."""
    scale_limits: tuple[float, float] = (0.06, 1.5)
    """Odometry's errors are between so many times what `drift` says."""


class ParticleFilter:
    """Particles with the ways that they believe in; the first scan is at the origin."""

    def __init__(self, params: ParticleParams, rng: np.random.Generator) -> None:
        self._params, self._rng = params, rng
        n, w = params.particles, params.scans
        low, high = np.log(params.scale_limits)
        self._cloud = Cloud(
            np.zeros((n, 3)),
            np.ones(n),
            # Odometry is trusted at first: where scans say little, it is all there is.
            low + (high - low) * rng.random((n, 2)) ** 2,
            np.zeros((n, w, 4)),
            np.zeros((n, w, params.points, 2), np.float32),
        )
        self._counts = np.zeros(w, np.int64)
        self._weights = np.zeros(n)
        self._taken = 0

    @property
    def scale(self) -> tuple[float, float]:
        """How many times as large as expected odometry's errors in way and turn are."""
        way, turn = np.exp(self._cloud.scales.mean(axis=0)).tolist()
        return way, turn

    def begin(self, points: NDArray[np.float64], pose: NDArray[np.float64]) -> None:
        """Take in the points (k, 2) of a scan whose pose (3,) is known."""
        self._cloud.poses[:] = pose
        self._note(self._few(points))

    def take(self, step: OdometryStep, points: NDArray[np.float64]) -> None:
        """Take in odometry since the last scan and the points (k, 2) of the scan after it."""
        params, rng, n = self._params, self._rng, len(self._weights)
        way, turn = step_sigmas(step.increment[None, :], params.drift)[0].tolist()
        low, high = np.log(params.scale_limits).tolist()
        moved = Moved(
            step.increment,
            *(way, turn, step.back, step.ahead),
            *(params.rough, params.slip, params.wander, (low, high)),
        )
        propose(self._cloud, moved, rng.standard_normal((n, 5)), rng.random((n, 4)))
        few = self._few(points)
        self._weights += params.temper * weigh(self._cloud, self._counts, few, params.sight)
        self._weights -= self._weights.max()
        self._survive()
        self._note(few)

    def way(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return poses (count, 3) and senses (count,) at the last scans, of the best particle."""
        best = self._cloud.ways[self._weights.argmax()][self._slots(count)]
        return best[:, :3], best[:, 3]

    def spread(self, count: int) -> NDArray[np.float64]:
        """Return the poses (2, n, 3) of particles so many scans ago, the last being one, and now.

        Drawn in proportion to the weights, so that each counts alike.
        """
        chosen = self._drawn()
        before, now = self._cloud.ways[chosen, self._slots(count)[0], :3], self._cloud.poses[chosen]
        return np.stack([before, now])

    def _few(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        every = max(1, -(-len(points) // self._params.points))
        return np.ascontiguousarray(points[::every], np.float64)

    def _note(self, points: NDArray[np.float64]) -> None:
        slot = self._taken % self._params.scans
        note(self._cloud, slot, points)
        self._counts[slot] = len(points)
        self._taken += 1

    def _slots(self, count: int) -> NDArray[np.int64]:
        return np.arange(self._taken - count, self._taken) % self._params.scans

    def _drawn(self) -> NDArray[np.int64]:
        """Draw particles by their weights, evenly."""
        n = len(self._weights)
        shares = np.exp(self._weights)
        marks = (self._rng.random() + np.arange(n)) / n * shares.sum()
        drawn: NDArray[np.int64] = np.searchsorted(np.cumsum(shares), marks)
        return np.minimum(drawn, n - 1)

    def _survive(self) -> None:
        """Replace unlikely particles by copies of likely ones once few carry most of the weight."""
        shares = np.exp(self._weights)
        if shares.sum() ** 2 / np.sum(shares**2) >= 0.5 * len(shares):
            return
        copies = np.bincount(self._drawn(), minlength=len(shares))
        lost = np.nonzero(copies == 0)[0]
        parents = np.repeat(np.arange(len(shares)), np.maximum(copies - 1, 0))
        for held in self._cloud:
            held[lost] = held[parents]
        self._weights[:] = 0.0
