"""The particle filter: move, weigh by 60 beams and draw anew, with as many particles as asked."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pilotage.bench.building_cases import OFFICE_CORRIDOR
from pilotage.bench.entry import Entry, Size, Stopwatch
from pilotage.bench.reference_particles import PlainParticles
from pilotage.bench.walk import BEAMS, corridor_walk, increments
from pilotage.core.grid import OccupancyMap
from pilotage.localizer.markov_grid import MotionSpread
from pilotage.localizer.measurement import Measurement
from pilotage.localizer.particle_evidence import EvidenceParams, ParticleEvidence
from pilotage.localizer.particle_filter import ParticleFilter
from pilotage.localizer.particle_resampling import KldParams
from pilotage.localizer.particle_start import free_space
from pilotage.robot.simulator.floor_plans import office_floor

COUNTS = (10_000, 100_000)
SPREAD = np.diag([0.5**2, 0.5**2, np.deg2rad(15.0) ** 2])
"""Covariance of the particles before the first update while tracking."""

UPDATES, PLAIN_UPDATES = 10, 2
FIELD_ONLY = EvidenceParams(visibility=None)
"""As other particle filters do: the likelihood field, not looking through walls."""


def particle_cases(watch: Stopwatch) -> Iterator[Entry]:
    """Yield updates along a corridor of the office, while tracking and from an unknown start."""
    world = office_floor()
    evidence = ParticleEvidence(world, FIELD_ONLY)
    for count in COUNTS:
        for name, is_known in (("tracking", True), ("unknown start", False)):
            track = Track(world, evidence, count, is_known=is_known)
            spent = track.updates_ms(watch)
            yield Entry(
                f"particles in the office: update, {name}",
                Size(count, BEAMS, "particles"),
                float(np.median(spent)),
                float(np.median(track.plain_updates_ms(watch))),
                1.0,
            )


class Track:
    """So many particles that follow a robot: from near it, or from anywhere every time."""

    def __init__(
        self, world: OccupancyMap, evidence: ParticleEvidence, count: int, *, is_known: bool
    ) -> None:
        self._world, self._evidence = world, evidence
        self._count, self._is_known = count, is_known
        self._walk = corridor_walk(world, OFFICE_CORRIDOR, UPDATES + 2)
        self._rng = np.random.default_rng(0)
        kld = KldParams(least=count, most=count)
        self.filter = ParticleFilter(free_space(world), MotionSpread(), kld)
        self._begin()

    def updates_ms(self, watch: Stopwatch) -> list[float]:
        """Return what each update takes but the first, which compiles."""
        spent = []
        for increment, sight in self._steps():
            if not self._is_known:
                self._begin()
            spent.append(watch.ms(lambda: self._update(increment, sight)))  # noqa: B023 - at once
        return spent[1:]

    def plain_updates_ms(self, watch: Stopwatch) -> list[float]:
        """Return the same of the plain twin."""
        self._begin()
        tempering = FIELD_ONLY.tempering
        plain = PlainParticles(self._world, FIELD_ONLY.beam, self.filter.poses, tempering)
        spent = []
        for increment, sight in self._steps()[:PLAIN_UPDATES]:
            if sight.ends is not None:
                ends = sight.ends
                spent.append(watch.ms(lambda: plain.update(increment, ends, self._rng)))  # noqa: B023 - at once
            if not self._is_known:
                plain.poses = self.filter.poses
        return spent

    def _steps(self) -> list[tuple[NDArray[np.float64], Measurement]]:
        scans = [sight.scan for sight in self._walk[1:]]
        return [*zip(increments(self._walk), scans, strict=True)]

    def _begin(self) -> None:
        if self._is_known:
            self.filter.set_gaussian(self._walk[0].pose, SPREAD, self._rng)
        else:
            self.filter.set_uniform(self._count, self._rng)

    def _update(self, increment: NDArray[np.float64], scan: Measurement) -> None:
        self.filter.predict(increment, self._rng)
        self.filter.weigh(self._evidence.weigh(self.filter.poses, scan).logs)
        self.filter.resample(self._rng)
