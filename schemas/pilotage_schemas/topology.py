"""The geometric-topological map."""

from typing import Annotated, Literal

from pydantic import Field

from pilotage_schemas.arrays import Float64Array, Nd
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Message, Name, NonNegative, Part

Id = Annotated[int, Field(ge=0, lt=2**31)]


class Feature(Part):
    """A corner, door or passage bound to a node; `width` where it has one."""

    kind: Literal["corner", "door", "passage"]
    pose: Pose2
    width: NonNegative | None = None


class Node(Part):
    """A place, with the features seen from it."""

    id: Id
    kind: Literal["node", "door", "corner", "passage"]
    name: Name
    pose: Pose2
    features: Annotated[tuple[Feature, ...], Field(max_length=64, strict=False)]


class Edge(Part):
    """A way from one node to another and what it costs, in metres."""

    id: Id
    start: Id
    end: Id
    cost: NonNegative


class TopologicalMap(Message):
    """Nodes and edges over the map `map_id`."""

    map_id: Name
    nodes: Annotated[tuple[Node, ...], Field(max_length=100_000, strict=False)]
    edges: Annotated[tuple[Edge, ...], Field(max_length=400_000, strict=False)]


class NodeArrival(Message):
    """The robot has reached a node; `matched` of its features were seen again."""

    node: Id
    matched: Id


class Relocalization(Message):
    """A pose found anew from the features of a node."""

    node: Id
    pose: Pose2
    covariance: Annotated[Float64Array, Nd("float64", "3,3")]
    matched: Id
