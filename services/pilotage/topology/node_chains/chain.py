"""Unknown start: the chain of nodes seen so far, searched in the map (Zhuang et al. 2005, 3.2).

A candidate is a node of the map and the way round in which the robot came to it. With each node
that the robot sees, the candidates are followed along the map's edges: a place fits as well as
its features do and as well as odometry agrees with the way to it. Nodes may have been missed, and
what was seen may have been no node of the map at all. The weights are those of the forward
algorithm: what leads to the same place adds up. Several candidates that are left are several.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.topology.node_chains.candidates import (
    NOWHERE,
    Candidates,
    ChainParams,
    Link,
)
from pilotage.topology.node_chains.fits import fitted, within
from pilotage.topology.node_chains.map import ChainMap
from pilotage.topology.node_chains.steps import (
    arrived_by,
    carried_on,
    joined,
    kept_of,
    strayed_to,
    ways_on,
)
from pilotage.topology.topological_map import TopologicalMap


class NodeChain:
    """The nodes seen since the robot knew nothing, and where in the map they may be."""

    def __init__(self, places: ChainMap, params: ChainParams | None = None) -> None:
        self.places = places
        self.params = params or ChainParams()
        self.links: list[Link] = []
        self.candidates = Candidates.unknown()

    @classmethod
    def over(cls, topology: TopologicalMap, params: ChainParams | None = None) -> "NodeChain":
        """Return an empty chain over a map; a ChainMap made once serves many chains."""
        return cls(ChainMap.of(topology), params)

    def add(self, link: Link) -> None:
        """Go on by one node seen."""
        carried = carried_on(self.candidates, link, self.params)
        ways = ways_on(carried, self.places, self.params)
        fits = fitted(link.seen, np.unique(ways.places), self.places, self.params)
        arrived = arrived_by(ways, carried, fits, self.places.at_node, self.params)
        strayed = strayed_to(link.seen, carried, self.places, self.params)
        self.candidates = kept_of(joined(arrived, strayed), self.params)
        self.links.append(link)

    @property
    def best(self) -> int | None:
        """Index of the likeliest candidate that is somewhere; None if there is none."""
        somewhere = np.flatnonzero(self.candidates.places != NOWHERE)
        return int(somewhere[0]) if len(somewhere) else None

    @property
    def node(self) -> int | None:
        """Id of the likeliest candidate's node, None if there is no candidate."""
        best = self.best
        return None if best is None else int(self.nodes[best])

    @property
    def nodes(self) -> NDArray[np.int64]:
        """Ids (n,) of the candidates' nodes, NOWHERE for none."""
        places = self.candidates.places
        if len(self.places.nodes) == 0:
            return np.full(len(places), NOWHERE)
        return np.where(places == NOWHERE, NOWHERE, self.places.ids[self.places.nodes[places]])

    @property
    def pose(self) -> NDArray[np.float64] | None:
        """Pose (3,) of base_link at the last link by the likeliest candidate, map frame."""
        best = self.best
        return None if best is None else self.candidates.poses[best]

    @property
    def share(self) -> float:
        """Share of the weight that agrees with `pose`, whatever the node."""
        is_same = self._agrees
        return float(self.candidates.shares[is_same].sum())

    @property
    def is_unique(self) -> bool:
        """Say whether one candidate is left: nearly all the weight, and nothing else comes near."""
        best, is_same = self.best, self._agrees
        if best is None:
            return False
        others = self.candidates.log_weights[~is_same].max(initial=-np.inf)
        ahead = self.candidates.log_weights[best] - others
        is_alone = self.share >= self.params.share and bool(ahead >= np.log(self.params.ratio))
        return is_alone and self.explained >= self.params.explained

    @property
    def explained(self) -> float:
        """Share of the features seen so far that the likeliest candidate matches."""
        seen = sum(len(within(link.seen, self.params.seen_within)) for link in self.links)
        best = self.best
        return 0.0 if best is None or not seen else float(self.candidates.explained[best]) / seen

    @property
    def _agrees(self) -> NDArray[np.bool_]:
        """Mask (n,) of the candidates whose pose is that of the likeliest."""
        pose = self.pose
        if pose is None:
            return np.zeros(len(self.candidates), bool)
        off = self.candidates.poses - pose
        metres, radians = self.params.same_place
        is_near: NDArray[np.bool_] = np.hypot(off[:, 0], off[:, 1]) <= metres
        return is_near & (np.abs(wrap(off[:, 2])) <= radians)
