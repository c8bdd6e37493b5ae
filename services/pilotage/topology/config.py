"""Settings of the topology service."""

from pathlib import Path
from typing import Annotated

from pydantic import Field

from pilotage.bus.deployment import ConfigPath, Deployment, Settings
from pilotage.topology.from_map.nodes import NodeParams
from pilotage.topology.routes.floors import BuiltFrom
from pilotage.topology.routes.route import RouteCosts
from pilotage.topology.topological_map import Spacing


class TopologySettings(Settings):
    """How the topological map is built, and how the robot is found on it.

    `build`: from a finished map, or from what is driven. `spacing` of the nodes: where there is
    something to be bound to, or equal; `metres`: between nodes of equal spacing, and about half of
    the most between the others. `door_cost`: what a door adds to a way [m]. `topologies_dir`: the
    library; without one the folder `topologies` of what outlives a run, beside the mapper's.
    `scan_period`: least time [s] between two scans that features are sought in; a fifth of a second
    is 12 cm of way. `show_period`, `keep_period`: least time [s] between two messages, and two
    files, of a map that is built while driving. `relocalizes`: publish poses found at nodes.
    """

    build: BuiltFrom = "map"
    spacing: Spacing = "variable"
    metres: Annotated[float, Field(ge=0.5, le=100.0)] = NodeParams.distance
    door_cost: Annotated[float, Field(ge=0.0, le=1e6)] = RouteCosts.door
    topologies_dir: ConfigPath | None = None
    scan_period: Annotated[float, Field(ge=0.05, le=10.0)] = 0.2
    show_period: Annotated[float, Field(ge=0.2, le=60.0)] = 1.0
    keep_period: Annotated[float, Field(ge=0.5, le=60.0)] = 4.0
    relocalizes: bool = True

    @property
    def costs(self) -> RouteCosts:
        """What ways cost."""
        return RouteCosts(self.door_cost)

    def library(self, deployment: Deployment) -> Path | None:
        """Return the folder of the library, None if there is no place for one."""
        state = deployment.state_dir or deployment.run_dir
        return self.topologies_dir or (None if state is None else state / "topologies")
