"""Topological maps, routes and matches as messages, and messages as what the mathematics takes."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.topology.features import KINDS, Features
from pilotage.topology.finding import Finding, FoundPose
from pilotage.topology.routes.floor_routes import FloorRoute
from pilotage.topology.routes.floors import Floor
from pilotage.topology.routes.route import RouteCosts, edge_cost, way_along
from pilotage.topology.topological_map import Node
from pilotage_schemas import topology as t
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.mapping import OccupancyGrid

MOST_FEATURES = 64
"""Of a node, as a message holds them: the nearest ones."""


def pose_of(pose: NDArray[np.float64]) -> Pose2:
    """Return a pose (3,) as a message part."""
    x, y, theta = (float(value) for value in pose)
    return Pose2(x=x, y=y, theta=float(wrap(theta)))


def pose_array(pose: Pose2) -> NDArray[np.float64]:
    """Return a message part as a pose (3,)."""
    return np.array([pose.x, pose.y, pose.theta])


def world_of(grid: OccupancyGrid) -> OccupancyMap:
    """Return a map message as a map."""
    rows, cols = grid.cells.shape
    origin = (grid.origin.x, grid.origin.y, grid.origin.theta)
    return OccupancyMap(GridGeometry(rows, cols, grid.resolution, origin), grid.cells)


def map_message(floor: Floor, stamp_ns: int, costs: RouteCosts) -> t.TopologicalMap:
    """Return a topological map as a message."""
    doors = frozenset(node.id for node in floor.map.nodes if node.kind == "door")
    edges = tuple(
        t.Edge(
            id=edge.id,
            start=edge.start,
            end=edge.end,
            cost=float(edge_cost(edge, doors, costs)),
            way=edge.way.astype(np.float32),
            kind=edge.kind,
        )
        for edge in floor.map.edges
    )
    links = tuple(
        t.Link(node=link.node, name=link.name, there=link.there, cost=link.cost)
        for link in floor.links
    )
    return t.TopologicalMap(
        stamp_ns=stamp_ns,
        frame_id="map",
        map_id=floor.map.map_id,
        nodes=tuple(_node(node) for node in floor.map.nodes),
        edges=edges,
        name=floor.name,
        floor=floor.label,
        built_from=floor.built_from,
        spacing=floor.spacing,
        links=links,
    )


def _node(node: Node) -> t.Node:
    features = node.features
    if len(features) > MOST_FEATURES:
        off = features.poses[:, :2] - node.pose[:2]
        features = features.chosen(np.argsort(np.hypot(off[:, 0], off[:, 1]))[:MOST_FEATURES])
    return t.Node(
        id=node.id,
        kind=node.kind,
        name=node.name[:64],
        pose=pose_of(node.pose),
        features=tuple(_features(features)),
    )


def _features(features: Features) -> list[t.Feature]:
    rows = zip(features.kinds, features.poses, features.widths, strict=True)
    return [
        t.Feature(
            kind=KINDS[kind], pose=pose_of(pose), width=None if np.isnan(width) else float(width)
        )
        for kind, pose, width in rows
    ]


def route_message(found: FloorRoute, floors: dict[str, Floor]) -> t.Route:
    """Return a route as a message, its legs one after the other."""
    ways = [way_along(floors[leg.floor].map, leg.route) for leg in found.legs]
    parts = tuple(
        t.RouteFloor(
            name=leg.floor,
            floor=floors[leg.floor].label,
            nodes=len(leg.route.nodes),
            edges=len(leg.route.edges),
            points=len(way),
        )
        for leg, way in zip(found.legs, ways, strict=True)
    )
    return t.Route(
        nodes=tuple(node for leg in found.legs for node in leg.route.nodes),
        edges=tuple(edge for leg in found.legs for edge in leg.route.edges),
        cost=found.cost,
        way=np.concatenate(ways).astype(np.float32),
        floors=parts,
    )


def arrival_message(node: Node, finding: Finding, stamp_ns: int) -> t.NodeArrival:
    """Return that the robot has reached a node."""
    matched = 0 if finding.seen is None else len(finding.seen)
    pose = None if finding.pose is None else pose_of(finding.pose)
    return t.NodeArrival(
        stamp_ns=stamp_ns,
        frame_id="map",
        node=node.id,
        name=node.name[:64],
        matched=matched,
        bound=len(node.features),
        pose=pose,
    )


def relocalization_message(found: FoundPose, map_id: str, stamp_ns: int) -> t.Relocalization:
    """Return a pose that was found at a node."""
    return t.Relocalization(
        stamp_ns=stamp_ns,
        frame_id="map",
        node=found.node,
        pose=pose_of(found.pose),
        covariance=0.5 * (found.covariance + found.covariance.T),
        matched=found.matched,
        map_id=map_id,
        cause=found.cause,
    )


def pairs_message(finding: Finding, stamp_ns: int) -> t.MatchedPairs:
    """Return the pairs at a node; none where the robot is at none, or sees nothing of it."""
    seen, expected = finding.seen or Features.none(), finding.expected or Features.none()
    here, there = stretches(seen), stretches(expected)
    turned = there[:, [2, 3, 0, 1]]
    # An opening can be gone through either way: whichever side comes first.
    is_turned = np.abs(turned - here).sum(axis=1) < np.abs(there - here).sum(axis=1)
    return t.MatchedPairs(
        stamp_ns=stamp_ns,
        frame_id="map",
        kinds=tuple(KINDS[kind] for kind in seen.kinds),
        seen=here,
        expected=np.where(is_turned[:, None], turned, there),
        node=None if finding.node is None else finding.node.id,
    )


def stretches(features: Features) -> NDArray[np.float32]:
    """Return features in map as ends (n, 4): an opening's sides, a corner's tip twice."""
    half = 0.5 * np.nan_to_num(features.widths)
    across = features.poses[:, 2] + 0.5 * np.pi
    offset = half[:, None] * np.stack([np.cos(across), np.sin(across)], axis=1)
    places = features.poses[:, :2]
    return np.concatenate([places - offset, places + offset], axis=1).astype(np.float32)
