"""When a graph of keyframes looks for loops, is relaxed, and leaves keyframes out."""

from dataclasses import dataclass, field

import numpy as np

from pilotage.mapper.front_end import NewKeyframe
from pilotage.mapper.keyframes import KeyframeGraph
from pilotage.mapper.loop_closure import ClosureParams, find_closures
from pilotage.mapper.pose_edges import Edge
from pilotage.mapper.scan_tracker import TrackerParams
from pilotage.mapper.slam_memory import Arrays


@dataclass(frozen=True)
class UpkeepParams:
    """When what is done."""

    closures: ClosureParams = field(default_factory=ClosureParams)
    relax_after: tuple[int, float] = (10, 0.05)
    """With new closures the graph is relaxed after so many keyframes, or this share of all."""
    urgent: tuple[float, int] = (0.2, 3)
    """m; a closure that moves a keyframe so far waits for so many keyframes only."""
    crowd: tuple[float, float, int] = (0.5, 0.35, 3)
    """A place is known well enough with so many older keyframes within m and rad of it: what is
    driven over again and again costs no more memory."""


class GraphUpkeep:
    """Keeps a graph of keyframes closed and small."""

    def __init__(self, graph: KeyframeGraph, params: UpkeepParams, tracker: TrackerParams) -> None:
        self._graph, self._params, self._tracker = graph, params, tracker
        self.waiting = 0
        """So many closures came since the graph was relaxed."""
        self._relaxed_at = 0

    def append(self, new: NewKeyframe) -> bool:
        """Take in a keyframe; say whether the graph should be relaxed."""
        graph, params = self._graph, self._params
        graph.append(new.keyframe, new.relative, new.covariance)
        self._leave_out_crowded()
        closures = find_closures(graph, params.closures, self._tracker)
        graph.close(closures)
        self.waiting += len(closures)
        return self._is_due(closures)

    def relax(self) -> None:
        """Relax the graph."""
        self._graph.relax()
        self.waiting, self._relaxed_at = 0, self._graph.newest

    def state(self) -> Arrays:
        """Return what `resume` needs."""
        return {"counts": np.array([self.waiting, self._relaxed_at])}

    def resume(self, memory: Arrays) -> None:
        """Go on from a state."""
        self.waiting, self._relaxed_at = memory["counts"].astype(int).tolist()

    def _is_due(self, closures: list[Edge]) -> bool:
        least, share = self._params.relax_after
        way, soon = self._params.urgent
        since = self._graph.newest - self._relaxed_at
        is_urgent = any(self._graph.moves(edge) > way for edge in closures)
        wait = soon if is_urgent else max(least, share * len(self._graph.keyframes))
        return self.waiting > 0 and since >= wait

    def _leave_out_crowded(self) -> None:
        """Leave out the keyframe that stops being recent if older ones know its place."""
        numbers = list(self._graph.keyframes)
        recent = self._params.closures.recent
        if len(numbers) > recent + 1:
            leaving = numbers[-recent - 1]
            if leaving != numbers[0] and self._graph.is_crowded(leaving, *self._params.crowd):
                self._graph.leave_out(leaving)
