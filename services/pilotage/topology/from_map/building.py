"""A topological map from a finished occupancy map (Zhuang et al. 2005, 2.2)."""

from dataclasses import dataclass, field

import numpy as np

from pilotage.core.corners import find_corners
from pilotage.core.grid import OccupancyMap
from pilotage.core.map_lines import map_lines
from pilotage.topology.features import Features
from pilotage.topology.from_map.bound_features import corner_features, opening_features
from pilotage.topology.from_map.chords import ChordParams, find_chords
from pilotage.topology.from_map.graph import edges_of, nodes_of, with_bends
from pilotage.topology.from_map.ground import GroundParams, cell_costs, on_ground
from pilotage.topology.from_map.nodes import NodeParams, middle_line, place_nodes
from pilotage.topology.from_map.openings import (
    OpeningParams,
    Openings,
    find_openings,
    opening_cells,
)
from pilotage.topology.from_map.rooms import Room, rooms_of
from pilotage.topology.from_map.space import Space, SpaceParams, drivable_space, space_of
from pilotage.topology.from_map.ways import Gates, find_ways
from pilotage.topology.topological_map import TopologicalMap

WELL_SEEN = 0.8
"""m: a wall of this length is more than a jamb or a pilaster."""


@dataclass(frozen=True)
class BuildParams:
    """How a topological map is built from an occupancy map."""

    space: SpaceParams = field(default_factory=SpaceParams)
    chords: ChordParams = field(default_factory=ChordParams)
    openings: OpeningParams = field(default_factory=OpeningParams)
    nodes: NodeParams = field(default_factory=NodeParams)
    ground: GroundParams = field(default_factory=GroundParams)


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
    ground = drivable_space(world)
    costs = cell_costs(ground, params.ground)
    line = middle_line(space, openings, params.nodes.least_clearance, np.isfinite(costs))
    sites = place_nodes(line, openings, rooms, corners, params.nodes)
    sites, cells = on_ground(ground, costs, sites)
    in_opening = np.array([site.opening is not None for site in sites], bool)
    gates = Gates(in_opening, opening_cells(space, openings.chords))
    ways = find_ways(ground, cells, costs, gates)
    sites = with_bends(sites, rooms, ways)
    resolution = world.geometry.resolution
    features = [opening_features(openings, resolution), corner_features(find_corners(lines))]
    nodes = nodes_of(world, sites, rooms, Features.joined(features))
    topology = TopologicalMap(map_id, nodes, edges_of(sites, rooms, ways))
    return Building(topology, space, openings, rooms)
