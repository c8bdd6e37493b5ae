"""What a finished map consists of, as the bytes of files that other programs read.

`map.yaml` and `map.pgm` are map_server's, `trajectory.tum` is what evo and the TUM benchmark read,
`pose_graph.g2o` what g2o, GTSAM and Ceres read.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import FREE, OCCUPIED, OCCUPIED_FROM, UNKNOWN, OccupancyMap
from pilotage.core.map_files import map_documents
from pilotage.mapper.method import MappingMethod, PoseGraph

MAP_FILE = "map.yaml"
TRAJECTORY_FILE = "trajectory.tum"
POSE_GRAPH_FILE = "pose_graph.g2o"

FREE_BELOW = 50
"""A cell that is more likely free than not counts as free; from there to occupied is unknown."""

UPPER = np.triu_indices(3)
"""g2o states a symmetric matrix by its upper triangle, row by row."""


@dataclass(frozen=True, eq=False)
class FinishedMap:
    """A method's results, taken from it once: the map, `decided`, the way and the pose graph.

    `stamps` (n,) in s and `poses` (n, 3) are the way.
    """

    world: OccupancyMap
    stamps: NDArray[np.float64]
    poses: NDArray[np.float64]
    graph: PoseGraph

    @property
    def free_area(self) -> float:
        """What was seen free, m²."""
        return float(np.sum(self.world.is_free)) * self.world.geometry.resolution**2

    @property
    def way_length(self) -> float:
        """What the robot drove, m."""
        return float(np.hypot(*np.diff(self.poses[:, :2], axis=0).T).sum())


def finish(method: MappingMethod) -> FinishedMap:
    """Return what a method has come to; it may go on afterwards."""
    method.settle()
    stamps, poses = method.trajectory()
    return FinishedMap(decided(method.map()), stamps, poses, method.pose_graph())


def products(finished: FinishedMap) -> dict[str, bytes]:
    """Return all files of a map by name; its YAML and image come first."""
    return {
        **map_documents(finished.world, MAP_FILE),
        TRAJECTORY_FILE: trajectory_document(finished.stamps, finished.poses),
        POSE_GRAPH_FILE: pose_graph_document(finished.graph),
    }


def decided(world: OccupancyMap) -> OccupancyMap:
    """Return a map whose cells are free, occupied or unknown.

    So it is written in map_server's trinary mode, which every program reads; degrees of
    probability would need mode raw, which shows as a black image and which ROS 1 does not know.
    """
    cells = np.full(world.cells.shape, UNKNOWN, np.int8)
    cells[(world.cells >= 0) & (world.cells < FREE_BELOW)] = FREE
    cells[world.cells >= OCCUPIED_FROM] = OCCUPIED
    return OccupancyMap(world.geometry, cells)


def trajectory_document(stamps: NDArray[np.float64], poses: NDArray[np.float64]) -> bytes:
    """Return stamps (n,) in s and poses (n, 3) as lines `stamp x y z qx qy qz qw`."""
    half = poses[:, 2] / 2.0
    lines = [
        f"{stamp:.6f} {x:.6f} {y:.6f} 0 0 0 {sin:.9f} {cos:.9f}\n"
        for stamp, (x, y, _), sin, cos in zip(
            stamps.tolist(), poses.tolist(), np.sin(half), np.cos(half), strict=True
        )
    ]
    return "".join(lines).encode()


def pose_graph_document(graph: PoseGraph) -> bytes:
    """Return a pose graph in g2o's lines VERTEX_SE2 and EDGE_SE2, the first pose fixed.

    g2o has no word for times: they stand in comments `# STAMP vertex seconds`, and `# CLOSURE i j`
    marks the edges that close loops.
    """
    lines = [f"# STAMP {i} {stamp:.6f}" for i, stamp in enumerate(graph.stamps.tolist())]
    lines += [f"# CLOSURE {i} {j}" for i, j in graph.edges[graph.is_closure].tolist()]
    lines += [f"VERTEX_SE2 {i} {_words(pose)}" for i, pose in enumerate(graph.poses)]
    lines += ["FIX 0"] if len(graph.poses) else []
    for (i, j), seen, known in zip(
        graph.edges.tolist(), graph.relative, graph.information, strict=True
    ):
        lines.append(f"EDGE_SE2 {i} {j} {_words(seen)} {_words(known[UPPER])}")
    return ("\n".join(lines) + "\n").encode()


def _words(values: NDArray[np.float64]) -> str:
    return " ".join(f"{value:.9g}" for value in values.tolist())
