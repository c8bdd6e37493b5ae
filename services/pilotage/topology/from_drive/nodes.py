"""Where nodes are set along a trail: in openings, abreast of them, in bends, and between.

Variable spacing sets a node only where enough features can be bound; equal spacing sets one every
so many metres, whatever is seen there (Zhuang et al. 2005, section 2.2).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.topology.features import KINDS, Features
from pilotage.topology.from_drive.record import Record
from pilotage.topology.topological_map import NodeKind

SAME_STOP, ROUNDING = 0.02, 1e-6
"""m between stops that are one place, and between distances that are the same."""
CORNER, DOOR = KINDS.index("corner"), KINDS.index("door")


@dataclass(frozen=True)
class NodeParams:
    """Where nodes are set; lengths in m, angles in rad."""

    spacing: Literal["variable", "equal"] = "variable"
    usual: float = 4.0
    """Between nodes where nothing asks for one; equal spacing sets all of them so far apart."""
    longest: float = 8.0
    """Without a node, however little there is to bind."""
    least: float = 1.2
    """Between nodes that are not in an opening."""
    least_features: int = 2
    """That a node of variable spacing binds."""
    abreast: float = 2.5
    """How far away an opening may be that the robot passes."""
    bend: float = 0.9
    """By how much the robot turns in a bend, within `bend_length` before and after."""
    bend_length: float = 1.0
    merge: float = 1.0
    """How near a node is reached again if it shares a feature with what is seen."""
    same: float = 0.4
    """How near a node is reached again whatever is seen; no wall fits between."""
    lag: float = 2.5
    """How far the robot has driven on before a place is decided: it has seen more by then."""
    margin: float = 0.15
    """How far beside its jambs an opening may seem to be crossed."""


@dataclass
class Placed:
    """A node on the trail: its stop, its pose (3,) in map and the opening that it is in, or -1."""

    kind: NodeKind
    stop: int
    pose: NDArray[np.float64]
    opening: int


@dataclass(frozen=True)
class Leg:
    """A stretch of the trail, stops `first` to `last`, between nodes `start` and `end`."""

    start: int
    end: int
    first: int
    last: int


class NodeWalk:
    """Goes along a trail once and sets nodes; nodes once set keep their number."""

    def __init__(self, params: NodeParams) -> None:
        self.params = params
        self.nodes: list[Placed] = []
        self.legs: list[Leg] = []
        self._current: tuple[int, int] | None = None
        self._next = 0

    def advance(self, record: Record, *, to_the_end: bool = False) -> None:
        """Decide about all stops that lie behind the robot by the lag, or about all there are."""
        lengths = record.lengths
        if len(lengths) == 0:
            return
        reach = lengths[-1] if to_the_end else lengths[-1] - self.params.lag
        openings = np.flatnonzero(record.is_certain & (record.features.kinds != CORNER))
        while self._next < len(lengths) and lengths[self._next] <= reach:
            if self._next + 1 < len(lengths) or to_the_end:
                self._decide(record, openings, self._next)
            self._next += 1

    def _decide(self, record: Record, openings: NDArray[np.int64], stop: int) -> None:
        crossed = self._crossed(record, openings, stop)
        if crossed >= 0:
            self._cross(record, crossed, stop)
            return
        again = self._again(record, stop)
        if again >= 0:
            self._arrive(again, stop)
        elif self._has_room(record, stop):
            kind = self._reason(record, openings, stop)
            if kind is not None and not self._soon_crosses(record, openings, stop):
                self._set(Placed(kind, stop, record.poses[stop].copy(), -1))

    def _set(self, node: Placed) -> None:
        self.nodes.append(node)
        self._arrive(len(self.nodes) - 1, node.stop)

    def _arrive(self, node: int, stop: int) -> None:
        if self._current is not None and self._current[0] != node:
            start, first = self._current
            self.legs.append(Leg(start, node, first, stop))
        self._current = (node, stop)

    def _crossed(self, record: Record, openings: NDArray[np.int64], stop: int) -> int:
        """Return the opening that the robot went through on its way to this stop, or -1."""
        if stop == 0 or len(openings) == 0:
            return -1
        doors = record.features.chosen(openings)
        before = _in_opening(record.poses[stop - 1], doors)
        after = _in_opening(record.poses[stop], doors)
        passes = (before[:, 0] < 0.0) != (after[:, 0] < 0.0)
        share = before[:, 0] / np.where(passes, before[:, 0] - after[:, 0], 1.0)
        aside = before[:, 1] + share * (after[:, 1] - before[:, 1])
        passes &= np.abs(aside) < doors.widths / 2.0 + self.params.margin
        if not passes.any():
            return -1
        return int(openings[np.argmin(np.where(passes, np.abs(aside), np.inf))])

    def _soon_crosses(self, record: Record, openings: NDArray[np.int64], stop: int) -> bool:
        """Say whether the robot goes through an opening just after this stop: a node is there."""
        until = np.searchsorted(record.lengths, record.lengths[stop] + self.params.least)
        return any(
            self._crossed(record, openings, later) >= 0 for later in range(stop + 1, int(until))
        )

    def _cross(self, record: Record, opening: int, stop: int) -> None:
        for number, node in enumerate(self.nodes):
            if node.opening == opening:
                self._arrive(number, stop)
                return
        feature = record.features.chosen(np.array([opening]))
        kind: NodeKind = "door" if feature.kinds[0] == DOOR else "passage"
        pose = feature.poses[0].copy()
        if np.cos(pose[2] - record.poses[stop, 2]) < 0.0:
            pose[2] = wrap(float(pose[2]) + np.pi)
        self._set(Placed(kind, stop, pose, opening))

    def _again(self, record: Record, stop: int) -> int:
        """Return the node that the robot passes again at this stop, or -1."""
        if not self.nodes:
            return -1
        places = np.array([node.pose[:2] for node in self.nodes])
        here = _apart(places, record.poses[stop])
        nearest = _is_nearest(places, record, stop) & (here < self.params.merge)
        for number in np.flatnonzero(nearest)[np.argsort(here[nearest])]:
            if here[number] < self.params.same or self._shares(record, int(number), stop):
                return int(number)
        return -1

    def _shares(self, record: Record, number: int, stop: int) -> bool:
        """Say whether a node and a stop see the same; those in openings are crossed or not."""
        node = self.nodes[number]
        if node.opening >= 0:
            return False
        bound = record.seen_near(node.stop)
        return bool(np.isin(bound, record.seen_near(stop)).any())

    def _has_room(self, record: Record, stop: int) -> bool:
        """Say whether a node may be set here: none is near that sees the same."""
        pose = record.poses[stop]
        return not any(
            np.hypot(*(node.pose[:2] - pose[:2])) < self.params.least
            and (node.opening >= 0 or self._shares(record, number, stop))
            for number, node in enumerate(self.nodes)
        )

    def _reason(self, record: Record, openings: NDArray[np.int64], stop: int) -> NodeKind | None:
        """Return the kind of node to set here, None where there is no reason to."""
        params = self.params
        if self._current is None:
            return "node"
        driven = float(record.lengths[stop] - record.lengths[self._current[1]])
        if params.spacing == "equal":
            return "node" if driven >= params.usual else None
        if driven >= params.longest:
            return "node"
        if len(record.seen_near(stop)) < params.least_features:
            return None
        if self._bends(record, stop):
            return "corner"
        passes = self._passes(record, openings, stop)
        return "node" if passes or driven >= params.usual else None

    def _bends(self, record: Record, stop: int) -> bool:
        """Say whether the way turns here, more than just before and just after."""
        stops = [max(stop - 1, 0), stop, min(stop + 1, len(record.poses) - 1)]
        before, here, after = (abs(self._turn(record, one)) for one in stops)
        return here > self.params.bend and here >= before and here >= after

    def _turn(self, record: Record, stop: int) -> float:
        lengths = record.lengths
        ends = lengths[stop] + self.params.bend_length * np.array([-1.0, 1.0])
        first = max(int(np.searchsorted(lengths, ends[0], side="right")) - 1, 0)
        last = min(int(np.searchsorted(lengths, ends[1])), len(lengths) - 1)
        return wrap(float(record.poses[last, 2] - record.poses[first, 2]))

    def _passes(self, record: Record, openings: NDArray[np.int64], stop: int) -> bool:
        """Say whether an opening that is seen from here is nearest here."""
        near = openings[np.isin(openings, record.seen_near(stop))]
        places = record.features.poses[near, :2]
        is_abreast = _apart(places, record.poses[stop]) < self.params.abreast
        return bool((_is_nearest(places, record, stop) & is_abreast).any())


def _apart(places: NDArray[np.float64], pose: NDArray[np.float64]) -> NDArray[np.float64]:
    apart: NDArray[np.float64] = np.hypot(places[:, 0] - pose[0], places[:, 1] - pose[1])
    return apart


def _is_nearest(places: NDArray[np.float64], record: Record, stop: int) -> NDArray[np.bool_]:
    """Say which places (n, 2) are nearer to a stop than to those before and after it.

    Stops at which the robot only turned count as one.
    """
    lengths, here = record.lengths, _apart(places, record.poses[stop])
    before = int(np.searchsorted(lengths, lengths[stop] - SAME_STOP)) - 1
    after = int(np.searchsorted(lengths, lengths[stop] + SAME_STOP))
    nearest = np.ones(len(places), np.bool_)
    if before >= 0:
        nearest &= here <= _apart(places, record.poses[before]) + ROUNDING
    if after < len(lengths):
        nearest &= here < _apart(places, record.poses[after]) - ROUNDING
    return nearest


def _in_opening(pose: NDArray[np.float64], doors: Features) -> NDArray[np.float64]:
    """Return the place (n, 2) of a pose beyond and beside the middle of each opening, m."""
    offset = pose[:2] - doors.poses[:, :2]
    cos, sin = np.cos(doors.poses[:, 2]), np.sin(doors.poses[:, 2])
    beyond, aside = cos * offset[:, 0] + sin * offset[:, 1], cos * offset[:, 1] - sin * offset[:, 0]
    return np.stack([beyond, aside], axis=1)
