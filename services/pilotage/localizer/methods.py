"""The ways of localizing by name, and how what is known passes from one to the next."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.ekf_localizer import EkfLocalizer, EkfParams
from pilotage.localizer.estimate import Memory
from pilotage.localizer.markov_localizer import MarkovLocalizer, MarkovParams
from pilotage.localizer.method import LocalizationMethod
from pilotage.localizer.particle_localizer import ParticleLocalizer, ParticleParams
from pilotage.localizer.pose_grid import PoseGridParams
from pilotage.localizer.range_model import RangeTable
from pilotage.localizer.visibility import VisibilityParams

CARRIED = 5_000
"""States that pass from one method to the next."""

KNOWN_FROM = 0.5
"""Share of the belief that these must hold; a belief that is spread wider knows no place."""


SightParams = tuple[PoseGridParams, VisibilityParams]


@dataclass(frozen=True)
class MethodSetup:
    """What the methods are made with.

    `landmarks`: where those stand that the robot sees. `start`: pose (3,) and covariance (3, 3)
    that AMCL's file begins the particles from. `seed`: of the particles' random generator.
    """

    markov: MarkovParams = field(default_factory=MarkovParams)
    particles: ParticleParams = field(default_factory=ParticleParams)
    ekf: EkfParams = field(default_factory=EkfParams)
    landmarks: LandmarkMap | None = None
    start: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    seed: int = 0

    def sight_of(self, name: str) -> SightParams | None:
        """Return what a method's table of optimistic ranges depends on; None: it has no table."""
        if name == "markov":
            return self.markov.grid, self.markov.visibility
        if name == "ekf":
            return None
        evidence = self.particles.evidence
        return None if evidence.visibility is None else (evidence.tables, evidence.visibility)


Make = Callable[
    [OccupancyMap, MethodSetup, np.random.Generator, RangeTable | None], LocalizationMethod
]

METHODS: dict[str, Make] = {
    "markov": lambda world, setup, _rng, sight: MarkovLocalizer(
        world, setup.markov, sight, setup.landmarks
    ),
    "mcl": lambda world, setup, rng, sight: ParticleLocalizer(
        world, setup.particles, rng, sight, setup.landmarks
    ),
    "ekf": lambda world, setup, _rng, _sight: EkfLocalizer(world, setup.ekf),
}

FINDERS = "markov", "mcl"
"""Those that find a robot from an unknown start; ekf follows one whose start is known."""


class NoMethodError(ValueError):
    """A method that cannot be had; the text says which ones can."""


def require_method(name: str) -> None:
    """Raise NoMethodError unless there is a method of this name."""
    if name not in METHODS:
        raise NoMethodError(f"there is no method '{name}'; there are {', '.join(METHODS)}")


def make_method(
    name: str,
    world: OccupancyMap,
    setup: MethodSetup,
    rng: np.random.Generator,
    sight: RangeTable | None = None,
) -> LocalizationMethod:
    """Return the method on a map, starting anywhere; `sight` is the map's table, if at hand.

    Raises:
        NoMethodError: there is no such method.
        ValueError: the map cannot be localized on.
    """
    require_method(name)
    return METHODS[name](world, setup, rng, sight)


def known(
    method: LocalizationMethod, odom_from_base: NDArray[np.float64], stamp_ns: int
) -> Memory | None:
    """Return what is known of the pose, or None if that is nothing: lost, or spread too wide.

    Before the first measurement the belief is taken to stand where odometry is now.
    """
    if method.estimate.state == "lost":
        return None
    memory = method.remember()
    if memory is None:
        poses, weights = method.belief.heaviest(CARRIED)
        memory = Memory(poses, weights, odom_from_base, stamp_ns, was_localized=False)
    return memory if memory.weights.sum() >= KNOWN_FROM else None
