"""A topological map from a finished occupancy map (Zhuang et al. 2005, 2.2)."""

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core.corners import find_corners
from pilotage.core.grid import OccupancyMap
from pilotage.core.map_lines import map_lines
from pilotage.topology.features import Features
from pilotage.topology.map_chords import ChordParams, find_chords
from pilotage.topology.map_features import corner_features, opening_features, seen_from
from pilotage.topology.map_nodes import NodeParams, Site, middle_line, place_nodes
from pilotage.topology.map_openings import OpeningParams, Openings, find_openings
from pilotage.topology.map_rooms import Room, rooms_of
from pilotage.topology.map_space import Space, SpaceParams, drivable_space, space_of
from pilotage.topology.map_ways import Way, WayParams, cell_costs, find_ways
from pilotage.topology.topological_map import Edge, EdgeKind, Node, TopologicalMap

NEAR = 0.6
"""m within which a node may move to ground that a robot can stand on."""
WELL_SEEN = 0.8
"""m: a wall of this length is more than a jamb or a pilaster."""


@dataclass(frozen=True)
class BuildParams:
    """How a topological map is built from an occupancy map."""

    space: SpaceParams = field(default_factory=SpaceParams)
    chords: ChordParams = field(default_factory=ChordParams)
    openings: OpeningParams = field(default_factory=OpeningParams)
    nodes: NodeParams = field(default_factory=NodeParams)
    ways: WayParams = field(default_factory=WayParams)


@dataclass(frozen=True)
class Building:
    """A topological map and what it was made from, for pictures: the space, openings, rooms."""

    topology: TopologicalMap
    space: Space
    openings: Openings
    rooms: dict[int, Room]


def build_topology(
    world: OccupancyMap, map_id: str, params: BuildParams = BuildParams()
) -> TopologicalMap:
    """Return the topological map of an occupancy map; empty if nothing in it is free."""
    return build(world, map_id, params).topology


def build(world: OccupancyMap, map_id: str, params: BuildParams = BuildParams()) -> Building:
    """Return the topological map of an occupancy map, and the rooms and openings behind it."""
    space = space_of(world, params.space)
    openings = find_openings(space, find_chords(space, params.chords), params.openings)
    rooms = rooms_of(space, openings)
    lines = map_lines(world)
    corners = find_corners(lines.chosen(lines.lengths >= WELL_SEEN))
    line = middle_line(space, openings, params.nodes.least_clearance)
    sites = place_nodes(line, openings, rooms, corners, params.nodes)
    ground = drivable_space(world)
    costs = cell_costs(ground, params.ways)
    sites, cells = _on_ground(ground, costs, sites)
    ways = find_ways(ground, cells, costs)
    resolution = world.geometry.resolution
    features = [opening_features(openings, resolution), corner_features(find_corners(lines))]
    nodes = _nodes(world, sites, rooms, Features.joined(features))
    return Building(
        TopologicalMap(map_id, nodes, _edges(sites, rooms, ways)), space, openings, rooms
    )


def _on_ground(
    ground: Space, costs: NDArray[np.float32], sites: list[Site]
) -> tuple[list[Site], NDArray[np.int64]]:
    """Return the sites that a robot can stand on or right beside, and their cells (n, 2)."""
    kept, cells = [], []
    taken: set[tuple[int, int]] = set()
    for site in sites:
        cell = _standing(ground, costs, site.pose)
        if cell is not None and cell not in taken:
            taken.add(cell)
            x, y = ground.geometry.centres_of([cell])[0]
            pose = np.array([x, y, site.pose[2]])
            kept.append(Site(site.kind, pose, site.room, site.opening))
            cells.append(cell)
    return kept, np.array(cells, np.int64).reshape(-1, 2)


def _standing(
    ground: Space, costs: NDArray[np.float32], pose: NDArray[np.float64]
) -> tuple[int, int] | None:
    """Return the cell nearest to a pose (3,) that a robot fits in; None if none is near."""
    row, col = ground.geometry.cells_of([pose[:2]])[0]
    reach = int(np.ceil(NEAR / ground.resolution))
    top, left = max(row - reach, 0), max(col - reach, 0)
    near = np.argwhere(np.isfinite(costs[top : row + reach + 1, left : col + reach + 1]))
    if len(near) == 0:
        return None
    near += (top, left)
    best = near[int(np.argmin(np.hypot(*(near - (row, col)).T)))]
    return int(best[0]), int(best[1])


def _nodes(
    world: OccupancyMap, sites: list[Site], rooms: dict[int, Room], features: Features
) -> tuple[Node, ...]:
    counted: Counter[str] = Counter()
    nodes = []
    for i, site in enumerate(sites):
        place = site.kind if site.opening is not None else rooms[site.room].name
        counted[place] += 1
        mark = " " if site.opening is not None else "."
        bound = seen_from(world, site.pose, features)
        nodes.append(Node(i, site.kind, f"{place}{mark}{counted[place]}", site.pose, bound))
    return tuple(nodes)


def _edges(sites: list[Site], rooms: dict[int, Room], ways: list[Way]) -> tuple[Edge, ...]:
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
