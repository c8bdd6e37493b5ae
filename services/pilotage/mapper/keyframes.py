"""Keyframes: the scans that the map consists of, each with a pose in a graph."""

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_scans import DrawnScan, redraw
from pilotage.mapper.method import PoseGraph
from pilotage.mapper.pose_edges import Edge, inverted, joined, reversed_edge
from pilotage.mapper.pose_graph import GraphParams, optimise

MOST_CLOSURES = 2
"""A keyframe takes closures over from one that is left out, until it has so many."""


@dataclass(frozen=True, eq=False)
class Keyframe:
    """What was seen from a place, in its frame: `points` (n, 2) to match, `scans` to draw."""

    stamp: float
    points: NDArray[np.float64]
    scans: tuple[DrawnScan, ...]


class KeyframeGraph:
    """Keyframes by number with their poses (3,) in the map, and the edges between them."""

    def __init__(self, params: GraphParams) -> None:
        self._params = params
        self.keyframes: dict[int, Keyframe] = {}
        self.poses: dict[int, NDArray[np.float64]] = {}
        self.edges: list[Edge] = []
        self.replaced: dict[int, tuple[int, NDArray[np.float64]]] = {}
        """What became of keyframes left out: another one, and their pose seen from it."""

    @property
    def newest(self) -> int:
        """The number of the newest keyframe."""
        return next(reversed(self.keyframes))

    def append(
        self, keyframe: Keyframe, relative: NDArray[np.float64], covariance: NDArray[np.float64]
    ) -> None:
        """Take in a keyframe at a pose (3,) seen from the newest; the first is the map's origin."""
        if not self.keyframes:
            self.keyframes[0], self.poses[0] = keyframe, relative
            return
        before = self.newest
        self.keyframes[before + 1] = keyframe
        self.poses[before + 1] = se2.compose(self.poses[before], relative)
        self.edges.append(Edge(before, before + 1, relative, covariance))

    def moves(self, closure: Edge) -> float:
        """Return by how many m a closure would move its second keyframe."""
        wanted = se2.compose(self.poses[closure.first], closure.relative)
        x, y, _ = wanted - self.poses[closure.second]
        return float(np.hypot(x, y))

    def is_crowded(self, number: int, way: float, turn: float, enough: int) -> bool:
        """Say whether `enough` older keyframes lie within `way` m and `turn` rad of one."""
        older = [key for key in self.keyframes if key < number]
        if len(older) < enough:
            return False
        seen = se2.between(self.poses[number], np.array([self.poses[key] for key in older]))
        near = (np.hypot(seen[:, 0], seen[:, 1]) < way) & (np.abs(seen[:, 2]) < turn)
        return int(near.sum()) >= enough

    def drawn(self) -> LaserGrid:
        """Return the map drawn from all keyframes where they are now."""
        drawings = [
            (self.poses[number], scan)
            for number, keyframe in self.keyframes.items()
            for scan in keyframe.scans
        ]
        return redraw(np.array([pose for pose, _ in drawings]), [scan for _, scan in drawings])

    def listed(self) -> PoseGraph:
        """Return poses and edges, the keyframes numbered without gaps."""
        place = {number: k for k, number in enumerate(self.poses)}
        ends = [(place[edge.first], place[edge.second]) for edge in self.edges]
        return PoseGraph(
            stamps=np.array([keyframe.stamp for keyframe in self.keyframes.values()]),
            poses=np.array(list(self.poses.values())).reshape(-1, 3),
            edges=np.array(ends, np.int64).reshape(-1, 2),
            relative=np.array([edge.relative for edge in self.edges]).reshape(-1, 3),
            information=np.array([inverted(edge.covariance) for edge in self.edges]).reshape(
                -1, 3, 3
            ),
            is_closure=np.array([edge.is_closure for edge in self.edges], np.bool_),
        )

    def close(self, closures: list[Edge]) -> None:
        """Take in closures; poses move when the graph is relaxed."""
        self.edges.extend(closures)

    def relax(self) -> None:
        """Move all poses to where the edges agree best, and leave out closures that do not."""
        self.poses, wrong = optimise(self.poses, self.edges, self._params)
        self.edges = [edge for k, edge in enumerate(self.edges) if k not in wrong]

    def lengths_from(self, start: int) -> dict[int, float]:
        """Return the shortest way in m along the edges to every keyframe: doubt grows with it."""
        ways = self._ways()
        reached = {start: 0.0}
        queue = [(0.0, start)]
        while queue:
            length, here = heapq.heappop(queue)
            if length > reached[here]:
                continue
            for there, step in ways[here]:
                if length + step < reached.get(there, np.inf):
                    reached[there] = length + step
                    heapq.heappush(queue, (length + step, there))
        return reached

    def latest(self, count: int) -> list[int]:
        """Return the numbers of the newest keyframes, oldest first."""
        return list(self.keyframes)[-count:]

    def points_of(self, numbers: list[int], seen_from: int) -> NDArray[np.float64]:
        """Return the points (n, 2) of keyframes, seen from another one's pose."""
        origin = self.poses[seen_from]
        return np.concatenate(
            [
                se2.transform_points(
                    se2.between(origin, self.poses[number]), self.keyframes[number].points
                )
                for number in numbers
            ]
        )

    def leave_out(self, number: int) -> None:
        """Drop a keyframe that is not an end; its neighbours keep what it said of them.

        Its closures go to the one before, or else to the one after, unless these have enough of
        their own: however often a place is driven over, the graph does not grow.
        """
        into = next(e for e in self.edges if e.second == number and not e.is_closure)
        out = next(e for e in self.edges if e.first == number and not e.is_closure)
        closures = [edge for edge in self.edges if edge.is_closure and number in edge.ends]
        self.edges = [edge for edge in self.edges if number not in edge.ends]
        self.edges.append(joined(into, out))
        for edge in closures:
            told = edge if edge.first == number else reversed_edge(edge)
            if not self._pass_on(joined(into, told)):
                self._pass_on(joined(reversed_edge(out), told))
        self.replaced[number] = _seen_from_others(number, [into, *closures])
        del self.keyframes[number], self.poses[number]

    def _pass_on(self, closure: Edge) -> bool:
        """Take a closure over from a neighbour unless there are enough; say whether it was."""
        its_own = [e for e in self.edges if e.is_closure and max(e.ends) == closure.first]
        if closure.second >= closure.first or len(its_own) >= MOST_CLOSURES:
            return False
        self.edges.append(closure)
        return True

    def anchored(self, number: int) -> tuple[int, NDArray[np.float64]]:
        """Return a keyframe still here and the pose (3,) of keyframe `number` seen from it."""
        pose = np.zeros(3)
        while number in self.replaced:
            number, relative = self.replaced[number]
            pose = se2.compose(relative, pose)
        return number, pose

    def _ways(self) -> dict[int, list[tuple[int, float]]]:
        ways: dict[int, list[tuple[int, float]]] = {number: [] for number in self.keyframes}
        for edge in self.edges:
            ways[edge.first].append((edge.second, edge.length))
            ways[edge.second].append((edge.first, edge.length))
        return ways


def _seen_from_others(number: int, edges: list[Edge]) -> tuple[int, NDArray[np.float64]]:
    """Return another keyframe and the pose (3,) of one seen from there, by the surest edge."""
    told = [edge if edge.second == number else reversed_edge(edge) for edge in edges]
    surest = min(told, key=lambda edge: float(np.trace(edge.covariance[:2, :2])))
    return surest.first, surest.relative
