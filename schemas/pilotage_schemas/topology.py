"""The geometric-topological map, what is seen of it, and the ways through it."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pilotage_schemas.arrays import Float32Array, Float64Array, Nd
from pilotage_schemas.commands import FileContent
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Finite, Message, Name, NonNegative, Part, Text

Id = Annotated[int, Field(ge=0, lt=2**31)]
Spacing = Literal["variable", "equal"]
BuiltFrom = Literal["map", "drive"]
Way = Annotated[Float32Array, Nd("float32", "n,2")]
"""Points of a way in the map, in order [m]."""

MOST_PAIRS = 1000


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
    """A way from `start` to `end` or back, and what it costs: its length [m] and its doors.

    `way` keeps clear of the walls; `kind`: along a corridor, within a room, or through a door or
    a passage.
    """

    id: Id
    start: Id
    end: Id
    cost: NonNegative
    way: Way
    kind: Literal["corridor", "room", "door", "passage"] = "corridor"


class Link(Part):
    """A way from `node` to the node `there` of the topological map `name`, e.g. a lift."""

    node: Id
    name: Name
    there: Id
    cost: NonNegative


class TopologicalMap(Message):
    """Nodes and edges over the map `map_id`; ids are unique over nodes and edges together.

    `name`: under which it is kept, empty for none. `floor`: for people. `built_from` a finished
    map or a drive; `spacing` of its nodes: equal, or where there is something to be bound to.
    """

    map_id: Name
    nodes: Annotated[tuple[Node, ...], Field(max_length=100_000, strict=False)]
    edges: Annotated[tuple[Edge, ...], Field(max_length=400_000, strict=False)]
    name: Name = ""
    floor: Name = ""
    built_from: BuiltFrom = "map"
    spacing: Spacing = "variable"
    links: Annotated[tuple[Link, ...], Field(max_length=10_000, strict=False)] = ()


class NodeArrival(Message):
    """The robot has reached a node: at `pose`, `matched` of its `bound` features seen again."""

    node: Id
    matched: Id
    name: Name = ""
    bound: Id = 0
    pose: Pose2 | None = None


class Relocalization(Message):
    """A pose of base_link in the map at `stamp_ns`, found anew from the features of a node.

    `cause`: the pose was `corrected` at a node, tracking had failed and the pose was `recovered`
    there, or the start was unknown and a `chain` of nodes told it.
    """

    node: Id
    pose: Pose2
    covariance: Annotated[Float64Array, Nd("float64", "3,3")]
    matched: Id
    map_id: Name = ""
    cause: Literal["corrected", "recovered", "chain"] = "corrected"


class MatchedPairs(Message):
    """What is seen now beside what the map has, pair by pair, in the map's frame.

    `seen` and `expected` (n, 4): x0, y0, x1, y1 [m] of a line, a door or a passage; both ends of
    a corner are its tip. `node`: the one whose features they are, None for those of the whole map.
    """

    kinds: Annotated[
        tuple[Literal["line", "corner", "door", "passage"], ...],
        Field(max_length=MOST_PAIRS, strict=False),
    ]
    seen: Annotated[Float32Array, Nd("float32", "n,4")]
    expected: Annotated[Float32Array, Nd("float32", "n,4")]
    node: Id | None = None

    @model_validator(mode="after")
    def _each_pair_has_a_kind(self) -> Self:
        if len(self.kinds) != len(self.seen):
            raise ValueError(f"{len(self.kinds)} kinds for {len(self.seen)} pairs")
        return self


class TopologyBuild(Part):
    """Build the topological map anew: from the map in use, or from what is driven from now on.

    `metres`: between nodes of equal spacing, and at most between those of variable spacing.
    """

    source: BuiltFrom = "map"
    spacing: Spacing = "variable"
    metres: Annotated[float, Field(ge=0.5, le=100.0)] | None = None


class TopologySave(Part):
    """Keep the topological map in use under this name in the library; `floor`: what people say."""

    name: Name
    floor: Name | None = None


class TopologySaved(Part):
    """The topological map as it was kept, and where."""

    name: Name
    map_id: Name
    path: Text


class TopologyLoad(Part):
    """Use a topological map of the library; it must be of the occupancy map in use."""

    name: Name


class TopologyDelete(Part):
    """Delete a topological map of the library."""

    name: Name


class TopologyFetch(Part):
    """Ask for a topological map of the library as GeoJSON, or for the one in use (no name)."""

    name: Name = ""


class TopologyFile(Part):
    """A topological map as GeoJSON, UTF-8."""

    content: FileContent


class TopologyStore(Part):
    """Take a topological map, as GeoJSON, into the library."""

    name: Name
    content: FileContent


class TopologyLoaded(Part):
    """The topological map that is now in use, and how much it has."""

    map_id: Name
    nodes: Id
    edges: Id


class Point(Part):
    """A point of the map in use [m]; the node nearest to it is meant."""

    x: Finite
    y: Finite


class NodeOf(Part):
    """A node of the topological map `name` of the library."""

    name: Name
    node: Id


class TopologyRoute(Part):
    """Ask for the cheapest way: a node of the map in use, a point of it, or a node elsewhere."""

    start: Id | Point | NodeOf
    end: Id | Point | NodeOf


class RouteFloor(Part):
    """How many of a route's nodes, edges and points of the way belong to one map, in order.

    `name` is empty for a map in use that is not in the library.
    """

    name: Name
    floor: Name
    nodes: Id
    edges: Id
    points: Id


class Route(Part):
    """The cheapest way over one or several floors: its nodes and edges in order, its polyline.

    Between two `floors` a link is taken. `cost` has the links and doors in it, in metres.
    """

    nodes: Annotated[tuple[Id, ...], Field(max_length=1_000_000, strict=False)]
    edges: Annotated[tuple[Id, ...], Field(max_length=1_000_000, strict=False)]
    cost: NonNegative
    way: Way
    floors: Annotated[tuple[RouteFloor, ...], Field(max_length=10_000, strict=False)]


class NearestNode(Part):
    """Ask for the node nearest to a point of the map in use [m]."""

    x: Finite
    y: Finite


class NodeFound(Part):
    """The nearest node and how far it is [m]."""

    node: Id
    name: Name
    pose: Pose2
    distance: NonNegative


class TopologyLink(Part):
    """Join a node of one map of the library with a node of another, both ways, e.g. by a lift.

    `cost` [m]: what the way between them counts for.
    """

    start: NodeOf
    end: NodeOf
    cost: NonNegative = 10.0


class StoredTopology(Part):
    """One topological map of the library."""

    name: Name
    map_id: Name
    floor: Name
    nodes: Id
    edges: Id
    saved_ns: Annotated[int, Field(ge=0, lt=2**63, description="Unix time, ns")]


class TopologyList(Part):
    """The topological maps of the library by name."""

    topologies: Annotated[tuple[StoredTopology, ...], Field(max_length=10_000, strict=False)]
