"""Places and ways of a map as nodes and edges: numbered, named and bound to what is seen there."""

from collections import Counter
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.topology.features import Features
from pilotage.topology.from_map.bound_features import seen_from
from pilotage.topology.from_map.nodes import Site
from pilotage.topology.from_map.rooms import Room
from pilotage.topology.from_map.ways import Way
from pilotage.topology.topological_map import Edge, EdgeKind, Node

LEAVING = 1.5
"""m along a way that say in which direction it leaves a node."""
STRAIGHT = float(np.deg2rad(45.0))
"""rad: where the two ways of a place in a corridor turn by more than this, it bends."""


def nodes_of(
    world: OccupancyMap, sites: list[Site], rooms: dict[int, Room], features: Features
) -> tuple[Node, ...]:
    """Return the nodes of sites, numbered in their order, bound to the features seen from each."""
    counted: Counter[str] = Counter()
    nodes = []
    for i, site in enumerate(sites):
        place = site.kind if site.opening is not None else rooms[site.room].name
        counted[place] += 1
        mark = " " if site.opening is not None else "."
        bound = seen_from(world, site.pose, features)
        nodes.append(Node(i, site.kind, f"{place}{mark}{counted[place]}", site.pose, bound))
    return tuple(nodes)


def with_bends(sites: list[Site], rooms: dict[int, Room], ways: list[Way]) -> list[Site]:
    """Return the sites, those where a corridor bends as corners.

    Before a door it does not bend: the way to it leads aside.
    """
    leaving: list[list[NDArray[np.float64]]] = [[] for _ in sites]
    for way in ways:
        leaving[way.start].append(_direction(way.points))
        leaving[way.end].append(_direction(way.points[::-1]))
    ends = {(way.start, way.end) for way in ways} | {(way.end, way.start) for way in ways}
    before_door = {end for end, other in ends if sites[other].kind == "door"}
    return [
        replace(site, kind="corner")
        if i not in before_door and _is_bend(site, rooms, out)
        else site
        for i, (site, out) in enumerate(zip(sites, leaving, strict=True))
    ]


def _is_bend(site: Site, rooms: dict[int, Room], out: list[NDArray[np.float64]]) -> bool:
    if site.opening is not None or rooms[site.room].kind != "corridor" or len(out) != 2:
        return False
    turn = np.pi - np.arccos(np.clip(float(out[0] @ out[1]), -1.0, 1.0))
    return bool(STRAIGHT < turn < np.pi - STRAIGHT)


def _direction(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit vector (2,) in which a way through points (k, 2) leaves the first."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    gone = np.concatenate([[0.0], np.cumsum(steps)])
    ahead = [np.interp(LEAVING, gone, column) for column in points.T]
    step = np.array(ahead) - points[0]
    unit: NDArray[np.float64] = step / max(float(np.hypot(*step)), 1e-9)
    return unit


def edges_of(sites: list[Site], rooms: dict[int, Room], ways: list[Way]) -> tuple[Edge, ...]:
    """Return the edges of ways between sites, numbered after the nodes."""
    return tuple(
        Edge(
            id=len(sites) + i,
            start=way.start,
            end=way.end,
            kind=_edge_kind(sites[way.start], sites[way.end], rooms),
            length=way.length,
            way=way.points,
        )
        for i, way in enumerate(ways)
    )


def _edge_kind(start: Site, end: Site, rooms: dict[int, Room]) -> EdgeKind:
    kinds = {start.kind, end.kind}
    if "door" in kinds:
        return "door"
    if "passage" in kinds:
        return "passage"
    is_corridor = all(rooms[site.room].kind == "corridor" for site in (start, end))
    return "corridor" if is_corridor else "room"
