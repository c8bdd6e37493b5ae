"""A topological map as people keep it: with its name, its floor and its links to other floors."""

from dataclasses import dataclass, replace
from typing import Literal

from pilotage.topology.topological_map import Spacing, TopologicalMap

BuiltFrom = Literal["map", "drive"]


@dataclass(frozen=True)
class Link:
    """A way, e.g. a lift, from `node` to the node `there` of the map kept as `name`.

    `cost` m: what going there counts for.
    """

    node: int
    name: str
    there: int
    cost: float


@dataclass(frozen=True)
class Floor:
    """A topological map and what is known about it.

    `name`: under which it is kept, empty if it is not. `label`: the floor, as people call it.
    `built_from` a finished map or a drive; `spacing` of its nodes.
    """

    map: TopologicalMap
    name: str = ""
    label: str = ""
    built_from: BuiltFrom = "map"
    spacing: Spacing = "variable"
    links: tuple[Link, ...] = ()

    def linked(self, link: Link) -> "Floor":
        """Return the floor with a link more, in place of an older one between the same nodes."""
        ends = (link.node, link.name, link.there)
        others = [one for one in self.links if (one.node, one.name, one.there) != ends]
        return replace(self, links=(*others, link))
