"""The hybrid map: nodes bound to the features near them, and the ways between (Zhuang 2005)."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.features import Features

NodeKind = Literal["node", "door", "corner", "passage"]
EdgeKind = Literal["corridor", "room", "door", "passage"]
Spacing = Literal["variable", "equal"]
"""Whether nodes stand where features are, or evenly."""


@dataclass(frozen=True)
class Node:
    """A place: `pose` (3,) in map, heading along its way, with the `features` seen from it in map.

    `kind`: door and passage are nodes in an opening, corner one in a corridor's bend, node the
    rest. `name` is shown to people.
    """

    id: int
    kind: NodeKind
    name: str
    pose: NDArray[np.float64]
    features: Features


@dataclass(frozen=True)
class Edge:
    """A way that can be driven both ways: `way` (k, 2) in map from node `start` to node `end`.

    `length` m. `kind`: along a corridor, within a room, or through a door or a passage, where the
    robot leaves the one for the other.
    """

    id: int
    start: int
    end: int
    kind: EdgeKind
    length: float
    way: NDArray[np.float64]


@dataclass(frozen=True)
class TopologicalMap:
    """Nodes and edges over the map `map_id`. Ids are unique over nodes and edges together."""

    map_id: str
    nodes: tuple[Node, ...]
    edges: tuple[Edge, ...]

    @property
    def places(self) -> NDArray[np.float64]:
        """Poses (n, 3) of the nodes."""
        return np.array([node.pose for node in self.nodes]).reshape(-1, 3)
