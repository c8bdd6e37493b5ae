"""Finds a robot that nobody knows anything of, by the chain of places that it passes.

The places are set as in a map that is built while driving, only in the frame of odometry; each
new one is a link of the chain that is sought in the map (Zhuang et al. 2005, 3.2).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.topology.features import Features
from pilotage.topology.from_drive.building import LiveBuilder
from pilotage.topology.node_chains.candidates import ChainParams, Link
from pilotage.topology.node_chains.chain import NodeChain
from pilotage.topology.node_chains.map import ChainMap
from pilotage.topology.topological_map import Node


@dataclass(frozen=True)
class DriftParams:
    """By how much odometry errs, as a share of the way: m per m, rad per m, rad per rad."""

    way: float = 0.03
    turn: float = 0.01
    heading: float = 0.02


@dataclass(frozen=True)
class StartFound:
    """Where the robot is: `pose` (3,) of base_link in map with its covariance (3, 3).

    `node` is the last link's, of which `matched` features fit.
    """

    node: int
    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]
    matched: int


class UnknownStart:
    """The chain of places passed since the pose was lost."""

    def __init__(
        self, places: ChainMap, params: ChainParams | None = None, drift: DriftParams | None = None
    ) -> None:
        self._places, self._params = places, params
        self._drift = drift or DriftParams()
        self.forget()

    def forget(self) -> None:
        """Begin anew: the pose is known, or odometry is counted anew."""
        self._builder = LiveBuilder()
        self._chain = NodeChain(self._places, self._params)
        self._last: Node | None = None
        self.is_begun = False

    def add(self, stamp: float, odom: NDArray[np.float64], seen: Features) -> StartFound | None:
        """Take in what is seen (base_link) at a pose (3,) in odom; say where that is, if certain.

        Once it has answered it begins anew.
        """
        self.is_begun = True
        if not self._builder.add(stamp, odom, seen):
            return None
        nodes = self._builder.topology("").nodes
        for node in nodes[len(self._chain.links) :]:
            self._chain.add(self._link(node))
            self._last = node
        found = self._here(odom)
        if found is not None:
            self.forget()
        return found

    def _link(self, node: Node) -> Link:
        seen = node.features.moved(se2.inverse(node.pose))
        if self._last is None:
            return Link(seen)
        moved = se2.between(self._last.pose, node.pose)
        return Link(seen, moved, self._spread(moved))

    def _here(self, odom: NDArray[np.float64]) -> StartFound | None:
        """Return where base_link is now, carried on by odometry from the last link."""
        chain, last = self._chain, self._last
        if last is None or chain.pose is None or chain.best is None or not chain.is_unique:
            return None
        moved = se2.between(last.pose, odom)
        pose = se2.compose(chain.pose, moved)
        covariance = chain.candidates.covariances[chain.best] + self._spread(moved)
        lever = _lever(moved)
        turned = _turn(float(chain.pose[2]))
        spread = turned @ lever @ covariance @ lever.T @ turned.T
        node = int(chain.nodes[chain.best])
        return StartFound(node, pose, spread, int(chain.candidates.pairs[chain.best]))

    def _spread(self, moved: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the covariance (3, 3) of a way by odometry, in the frame of its start."""
        way = float(np.hypot(moved[0], moved[1]))
        turn = self._drift.turn * way + self._drift.heading * abs(float(moved[2]))
        aside = self._drift.way * way
        return np.diag([aside**2, aside**2, turn**2])


def _lever(moved: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return what an error of the start's pose does to the end's, in the frame of the start."""
    lever = np.eye(3)
    lever[:2, 2] = -moved[1], moved[0]
    return lever


def _turn(angle: float) -> NDArray[np.float64]:
    turn = np.eye(3)
    cos, sin = np.cos(angle), np.sin(angle)
    turn[:2, :2] = [[cos, -sin], [sin, cos]]
    return turn
