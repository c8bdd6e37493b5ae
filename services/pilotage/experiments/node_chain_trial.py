"""One unknown start in a corridor of alike doors: drive on until one candidate is left."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.experiments.corridor_doors import (
    SHARED_WITHIN,
    Corridor,
    Spacing,
    corridor_of,
    floor_of,
    topology_of,
    walkable,
)
from pilotage.experiments.corridor_ride import CorridorRide
from pilotage.experiments.node_chain_robot import SIDE, NodeSeen, NodeWatch
from pilotage.topology.node_chains.candidates import ChainParams
from pilotage.topology.node_chains.chain import NodeChain
from pilotage.topology.node_chains.map import ChainMap
from pilotage.topology.topological_map import TopologicalMap

LENGTH = 60.0
"""m of the corridor."""
STEP = 0.2
"""m from look to look."""
MOST_NODES = 12
"""A robot that does not know by then has failed."""
MOST_WAY = 80.0
"""The same for its way, m."""
PEOPLE = 4
END = 1.2
"""m before a closed end of the corridor at which the robot turns round."""
NEAR = 0.5, float(np.deg2rad(15.0))
"""m and rad within which the pose of a candidate is right."""

PARAMS = ChainParams(half_view=SIDE)

Verdict = Literal["right", "wrong", "unknown"]


@dataclass(frozen=True)
class ChainPlace:
    """A corridor, its map, and its nodes as chains are searched in them."""

    spacing: Spacing
    corridor: Corridor
    floor: OccupancyMap
    busy: OccupancyMap
    topology: TopologicalMap
    places: ChainMap

    @classmethod
    def of(cls, spacing: Spacing, seed: int) -> "ChainPlace":
        """Return a corridor without a hall, closed at both ends."""
        drawn = corridor_of(LENGTH, seed, spacing)
        corridor = Corridor(drawn.length, drawn.doors, has_hall=False)
        topology = topology_of(corridor)
        floor, busy = floor_of(corridor), walkable(corridor)
        return cls(spacing, corridor, floor, busy, topology, ChainMap.of(topology))


@dataclass(frozen=True)
class Step:
    """What was believed after a node: `candidates` left, the best one's `share` and `pose` (3,).

    `truth` (3,): where the robot was; `node`: id of the best candidate's node.
    """

    candidates: int
    share: float
    pose: NDArray[np.float64]
    node: int
    truth: NDArray[np.float64]


@dataclass(frozen=True)
class Start:
    """One start: how it went, and what it ended with."""

    steps: tuple[Step, ...]
    verdict: Verdict
    way: float


def start_anywhere(place: ChainPlace, rng: np.random.Generator, people: int = PEOPLE) -> Start:
    """Put a robot down anywhere in the corridor, either way round, and let it find out."""
    x = rng.uniform(END, place.corridor.length - END)
    heading = float(rng.choice([0.0, np.pi])) + rng.normal(0.0, 0.1)
    begin = np.array([x, rng.normal(0.0, 0.1), heading])
    robot = CorridorRide(place.floor, begin, rng, (people, place.busy) if people else None)
    watch, chain = NodeWatch(), NodeChain(place.places, PARAMS)
    steps: list[Step] = []
    way = 0.0
    while way < MOST_WAY and len(steps) < MOST_NODES and not chain.is_unique:
        node = watch.see(robot.look())
        if node is not None:
            chain.add(node.link)
            steps.append(_step(chain, node))
        if _is_at_end(place, robot.truth):
            robot.turn_round()
        robot.drive(STEP)
        way += STEP
    return Start(tuple(steps), _verdict(place, chain, steps), way)


def _step(chain: NodeChain, node: NodeSeen) -> Step:
    pose = chain.pose if chain.pose is not None else np.full(3, np.nan)
    found = -1 if chain.node is None else chain.node
    return Step(len(chain.candidates), chain.share, pose, found, node.truth)


def _verdict(place: ChainPlace, chain: NodeChain, steps: list[Step]) -> Verdict:
    """Say whether the only candidate is the node that the robot was at; unknown without one.

    A robot between two nodes may have taken its place for either.
    """
    if not chain.is_unique:
        return "unknown"
    last = steps[-1]
    nodes = {node.id: float(node.pose[0]) for node in place.topology.nodes}
    is_node = abs(nodes[last.node] - last.truth[0]) <= SHARED_WITHIN
    x, y, theta = se2.between(last.truth, last.pose)
    is_near = np.hypot(x, y) <= NEAR[0] and abs(float(theta)) <= NEAR[1]
    return "right" if is_node and is_near else "wrong"


def _is_at_end(place: ChainPlace, truth: NDArray[np.float64]) -> bool:
    """Say whether the robot faces an end of the corridor that it has come to."""
    if np.cos(truth[2]) > 0.0:
        return bool(truth[0] > place.corridor.length - END)
    return bool(truth[0] < END)
