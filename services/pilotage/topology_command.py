"""`pilotage topology`: a topological map of a finished map, as nav2_route reads it, and drawn."""

import json
import sys
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from pilotage.bus.deployment import ConfigError
from pilotage.core.map_files import MapFileError, load_map, map_digest
from pilotage.core.whole_files import write_whole
from pilotage.topology.from_map.building import Building, BuildParams, build
from pilotage.topology.from_map.nodes import NodeParams
from pilotage.topology.routes.floors import Floor
from pilotage.topology.routes.geojson import floor_to_geojson
from pilotage.topology.topological_map import Spacing
from pilotage.topology_picture import topology_picture


@dataclass(frozen=True)
class TopologyOptions:
    """What the command line says; `distance` between nodes in m."""

    map: Path
    out: Path
    spacing: Spacing
    distance: float


def topology(options: TopologyOptions) -> None:
    """Write FILE.geojson and, beside it, FILE.png; ConfigError or OSError if that cannot be."""
    if options.out.suffix.lower() not in {".geojson", ".json"}:
        raise ConfigError(f"{options.out}: the file to write must end in .geojson or .json")
    if options.out.is_dir():
        raise ConfigError(f"{options.out}: that is a folder; name a file to write")
    try:
        world = load_map(options.map)
    except MapFileError as error:  # which names the file
        raise ConfigError(str(error)) from error
    params = BuildParams(nodes=NodeParams(options.spacing, options.distance))
    with Console(file=sys.stderr).status(f"building the topological map of {options.map.name}"):
        building = build(world, map_digest(world), params)
    if not building.topology.nodes:
        raise ConfigError(f"{options.map}: nothing in it is large enough for a robot to stand in")
    name = options.map.stem
    floor = Floor(building.topology, name=name, spacing=options.spacing)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(floor_to_geojson(floor), allow_nan=False)
    picture = topology_picture(world, building, _title(name, building))
    files = {options.out.with_suffix(".png").name: picture, options.out.name: text.encode()}
    write_whole(options.out.parent, files)


def _title(name: str, building: Building) -> str:
    kinds = [node.kind for node in building.topology.nodes]
    doors, passages = kinds.count("door"), kinds.count("passage")
    edges = len(building.topology.edges)
    return f"{name}: {len(kinds)} nodes ({doors} doors, {passages} passages), {edges} edges"
