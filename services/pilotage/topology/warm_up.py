"""Machine code for what the topology service calculates, made or loaded before it is asked."""

import math
from functools import cache

import numpy as np

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.topology.at_nodes.matching import match_features
from pilotage.topology.features import Features
from pilotage.topology.from_map.building import build_topology
from pilotage.topology.node_chains.candidates import Link
from pilotage.topology.node_chains.chain import NodeChain
from pilotage.topology.routes import route_kernels
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.seeing.seen_features import seen_features

ROWS, COLS, CELL = 60, 80, 0.1
"""Cells of the flat that is gone through, and m of each."""

BEAMS, REACH = 181, 8.0
POSE = (1.5, 3.0, 0.0)
WINDOW = (0.5, 0.35)


@cache
def warm_up() -> None:
    """Compile all kernels, or load them: half a minute after a change, else a second; once.

    Everything is done once on a flat of two rooms, with the types that it meets in service.
    """
    flat = _flat()
    world = build_topology(flat, "flat")
    bearings = np.linspace(-0.5 * math.pi, 0.5 * math.pi, BEAMS)
    ranges = cast_scan(flat, POSE, bearings, REACH).astype(np.float32)
    step = float(bearings[1] - bearings[0])
    seen = seen_features(ScanView.of(ranges, (float(bearings[0]), step)))
    everything = Features.joined([node.features for node in world.nodes])
    match_features(seen, everything, POSE, WINDOW)
    NodeChain.over(world).add(Link(seen))
    route_kernels.warm_up()


def _flat() -> OccupancyMap:
    """Two rooms with a door between them."""
    cells = np.zeros((ROWS, COLS), np.int8)
    cells[[0, 1, -2, -1]] = cells[:, [0, 1, -2, -1]] = 100
    cells[:, 39:41] = 100
    cells[25:35, 39:41] = 0
    # As a map is that came by the bus; to a kernel that is another type.
    cells.flags.writeable = False
    return OccupancyMap(GridGeometry(ROWS, COLS, CELL), cells)
