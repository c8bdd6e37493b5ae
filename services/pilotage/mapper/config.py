"""Settings of the mapper."""

from pathlib import Path
from typing import Annotated

from pydantic import Field

from pilotage.bus.deployment import ConfigPath, Deployment, Settings
from pilotage_schemas.mapping import MappingSensor


class MapperSettings(Settings):
    """Which map to serve, or to make, and where maps are kept.

    `map`: a map_server YAML file or the CMU Wean Hall map; without one the mapper waits for a
    command. `mapping`: begin to map by this sensor at once. `maps_dir`: the map library; without
    one the folder `maps` of what outlives a run. `show_period`: least time [s] between two
    messages of a map in the making; `keep_period`: mapping that a crash may cost [s].
    """

    map: ConfigPath | None = None
    mapping: MappingSensor | None = None
    maps_dir: ConfigPath | None = None
    show_period: Annotated[float, Field(ge=0.1, le=10.0)] = 0.5
    keep_period: Annotated[float, Field(ge=0.5, le=5.0)] = 4.0

    def library(self, deployment: Deployment) -> Path | None:
        """Return the folder of the map library, None if there is no place for one."""
        state = deployment.state_dir or deployment.run_dir
        return self.maps_dir or (None if state is None else state / "maps")
