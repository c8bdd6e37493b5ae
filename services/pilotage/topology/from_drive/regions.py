"""Corridors and rooms: what the doors and passages of a trail part from each other."""

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.from_drive.nodes import Leg, Placed
from pilotage.topology.topological_map import EdgeKind

MANY_OPENINGS = 3
"""A space with so many openings that the robot went through is a corridor."""
LONG = 6.0
"""m that the robot drove from end to end of a corridor without many openings."""
SLENDER = 4.0
"""Times that the way along such a corridor is longer than wide."""


def leg_kinds(nodes: list[Placed], legs: list[Leg], poses: NDArray[np.float64]) -> list[EdgeKind]:
    """Return what each leg is: into a door or a passage, else within a corridor or a room.

    `poses` (n, 3) of the stops of the trail.
    """
    space_of = _spaces(nodes, legs)
    corridors = {
        number for number in set(space_of.values()) if _is_corridor(number, space_of, legs, poses)
    }
    return [_kind(leg, nodes, space_of, corridors) for leg in legs]


def _spaces(nodes: list[Placed], legs: list[Leg]) -> dict[int, int]:
    """Return which space each node that is in no opening lies in."""
    space_of = {k: k for k, node in enumerate(nodes) if node.opening < 0}
    for leg in legs:
        one, other = space_of.get(leg.start), space_of.get(leg.end)
        if one is not None and other is not None and one != other:
            space_of = {k: one if space == other else space for k, space in space_of.items()}
    return space_of


def _kind(leg: Leg, nodes: list[Placed], space_of: dict[int, int], corridors: set[int]) -> EdgeKind:
    for end in (leg.start, leg.end):
        if nodes[end].opening >= 0:
            return "door" if nodes[end].kind == "door" else "passage"
    return "corridor" if space_of[leg.start] in corridors else "room"


def _is_corridor(
    number: int, space_of: dict[int, int], legs: list[Leg], poses: NDArray[np.float64]
) -> bool:
    """Say whether a space is one: it has many openings, or it is long and slender."""
    touching = [leg for leg in legs if number in (space_of.get(leg.start), space_of.get(leg.end))]
    openings = {end for leg in touching for end in (leg.start, leg.end) if end not in space_of}
    if len(openings) >= MANY_OPENINGS:
        return True
    inside = [leg for leg in touching if leg.start in space_of and leg.end in space_of]
    if not inside:
        return False
    way = np.concatenate([poses[leg.first : leg.last + 1, :2] for leg in inside])
    _, _, axes = np.linalg.svd(way - way.mean(axis=0), full_matrices=False)
    along, across = np.ptp((way - way.mean(axis=0)) @ axes.T, axis=0)
    return bool(along >= LONG and along >= SLENDER * across)
