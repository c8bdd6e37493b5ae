"""What a chain of nodes is made of: links, and the candidates that are left after each."""

from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.features import Features

NOWHERE = -1
"""Place of the candidate that says: at no node of the map so far."""


@dataclass(frozen=True)
class ChainParams:
    """How nodes are seen, and when a candidate is given up or believed."""

    place: float = 0.25
    """m, standard deviation of an arrival beside its node, along either axis."""
    turn: float = 0.15
    """rad, standard deviation of the heading of an arrival."""
    blur: float = 0.06
    """m, what a feature's position varies by beyond its covariance."""
    direction: float = 0.15
    """rad, standard deviation of a feature's direction."""
    width: float = 0.12
    """m, standard deviation of a feature's width."""
    detection: float = 0.7
    """Probability that a bound feature in view is seen."""
    strays: tuple[float, float, float] = (3.0, 10.0, 5.0)
    """Corners, doors and passages that the map lacks, per m^2, any direction and metre of width.

    They are not just anywhere: along the faces of walls, square to them and as wide as others. A
    door in three metres of wall, told to 0.1 m, 0.15 rad and 0.12 m, is as dense as this.
    """
    reach: float = 3.5
    """m within which bound features are surely in view; those beyond need not be seen."""
    seen_within: float = 4.5
    """m within which features seen are weighed at all."""
    half_view: float = float(np.deg2rad(80.0))
    """rad to either side within which they are."""
    missed: float = 0.1
    """Probability to pass a node of the map without noticing; the price of each one skipped."""
    most_missed: int = 3
    """At most so many are skipped in a row."""
    false: float = 0.1
    """Probability that what was taken for a node is none of the map, but a place along an edge."""
    off_map: float = 0.1
    """Of those at the beginning, the share that is nowhere near any node or edge."""
    way_growth: float = 0.03
    """Share of a way by which odometry may err beyond its covariance."""
    turn_growth: float = 0.02
    """The same in rad a metre."""
    stray_ways: float = 5.0
    """How likely a displacement to no node is, per m^2 and rad: somewhere on, along the way."""
    gate: float = 25.0
    """Squared Mahalanobis distance from which a way is impossible (3 degrees of freedom)."""
    prune: float = 18.0
    """Candidates whose log-weight is lower than the best one's by so much are given up."""
    share: float = 0.95
    """Share of the weight that the only candidate has."""
    ratio: float = 1000.0
    """How many times as likely it is as any other."""
    explained: float = 0.6
    """Share of the features seen all along the chain that it has to match: where a map shows less
    of what is there, the best that it offers need not be right."""
    same_place: tuple[float, float] = (0.5, float(np.deg2rad(30.0)))
    """m and rad within which two candidates' poses are the same."""


@dataclass(frozen=True)
class Link:
    """A node seen: its features in base_link on arrival, and how the robot came there.

    `moved` (3,): this base_link as seen from the one at the node before, by odometry; `covariance`
    (3, 3) of x, y, theta in the frame of the one before. Both say nothing for the first node.
    """

    seen: Features
    moved: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True, eq=False)
class Candidates:
    """Candidates (n,), the most likely first.

    `places`: index in the ChainMap of the nearest node and the way round it, or of a place along an
    edge; NOWHERE for the one that was at none so far; `at_node`: False if what was seen last was no
    node of the map; `poses` (n, 3) of base_link at the last link in map, NaN for nowhere;
    `covariances` (n, 3, 3) of x, y, theta in base_link; `log_weights`, whose exponentials sum to
    one; `parents`: index among the candidates before the last link, the heaviest of those it comes
    from; `pairs`: features matched at the last link, `explained`: at all links so far.
    """

    places: NDArray[np.int64]
    at_node: NDArray[np.bool_]
    poses: NDArray[np.float64]
    covariances: NDArray[np.float64]
    log_weights: NDArray[np.float64]
    parents: NDArray[np.int64]
    pairs: NDArray[np.int64]
    explained: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.places)

    @property
    def shares(self) -> NDArray[np.float64]:
        """Shares of the weight (n,), which sum to one."""
        shares: NDArray[np.float64] = np.exp(self.log_weights)
        return shares

    def chosen(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> "Candidates":
        """Return those that a mask (n,) or indices (k,) choose."""
        return Candidates(*(getattr(self, one.name)[which] for one in fields(self)))

    @classmethod
    def unknown(cls) -> "Candidates":
        """Return what there is before any node was seen: nowhere, with all the weight."""
        return cls(
            np.array([NOWHERE]),
            np.array([False]),
            np.full((1, 3), np.nan),
            np.zeros((1, 3, 3)),
            *(np.zeros(1), np.array([-1]), np.array([0]), np.array([0])),
        )
