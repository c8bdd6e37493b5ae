"""What a world file says: the map, where the robot starts, what the map lacks.

map: office_map.yaml          # a map_server map, relative to this file
start: random                 # or [x, y, theta] in m and rad
unmapped: [[3, 4, 4, 4.5]]    # furniture that the map lacks: boxes x0, y0, x1, y1 in m
people: 3
landmarks: [{class: beacon, x: 1, y: 2}]   # or a file of them; a camera sees them
doors: [{ends: [[1, 2], [1.9, 2]], state: closed}]   # or a file of them; its picture shows them
robot: {laser: {range_max: 8.0}}
"""

import math
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import yaml
from pydantic import (
    BeforeValidator,
    ConfigDict,
    Field,
    InstanceOf,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
)

from pilotage.bus.deployment import ConfigError, ConfigPath, Settings
from pilotage.core.grid import GridGeometry
from pilotage.core.landmark_map import (
    NO_LANDMARKS,
    LandmarkMap,
    landmarks_of,
    read_landmarks,
)
from pilotage.core.map_files import MapFileError, load_map
from pilotage.robot.simulator.doors import NO_DOORS, Doors, doors_of, read_doors
from pilotage.robot.simulator.simulation import NoPlaceError, RobotParams, Simulation
from pilotage.robot.simulator.walls import Walls


class StrayError(ValueError):
    """The world speaks of a landmark that cannot be there; the text says which."""


def _start(value: object) -> object:
    """Say in one sentence what a start is, in place of one complaint per alternative."""
    is_pose = (
        isinstance(value, list | tuple)
        and len(value) == 3
        and all(isinstance(v, int | float) and math.isfinite(v) for v in value)
    )
    if value != "random" and not is_pose:
        raise ValueError("it must be random or [x, y, theta] in m and rad")
    return value


def _landmarks(value: object, info: ValidationInfo) -> LandmarkMap:
    """Return the landmarks that stand in the world file, or in the file that it names."""
    if isinstance(value, list):
        return landmarks_of(value)
    return read_landmarks(_file(value, info, "landmarks"))


def _doors(value: object, info: ValidationInfo) -> Doors:
    """Return the doors that stand in the world file, or in the file that it names."""
    if isinstance(value, list):
        return doors_of(value)
    return read_doors(_file(value, info, "doors"))


def _file(value: object, info: ValidationInfo, what: str) -> Path:
    if not isinstance(value, str):
        raise ValueError(f"it must be a list of {what} or a file with one")  # noqa: TRY004 - for pydantic
    return TypeAdapter(ConfigPath).validate_python(value, context=info.context)


class WorldFile(Settings):
    """A world; everything but the map has a default.

    `seed` None: another run each time. `people`: how many walk about. `landmarks`: as in
    `core.landmark_map`. `doors`: as in `robot.simulator.doors`.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    map: ConfigPath
    start: Annotated[Literal["random"] | tuple[float, float, float], BeforeValidator(_start)] = (
        "random"
    )
    unmapped: tuple[tuple[float, float, float, float], ...] = ()
    people: Annotated[int, Field(ge=0, le=100)] = 0
    landmarks: Annotated[InstanceOf[LandmarkMap], BeforeValidator(_landmarks)] = NO_LANDMARKS
    doors: Annotated[InstanceOf[Doors], BeforeValidator(_doors)] = NO_DOORS
    seed: Annotated[int, Field(ge=0)] | None = None
    robot: RobotParams = RobotParams()


def read_world(path: Path) -> WorldFile:
    """Return the world in a YAML file; ConfigError says what is wrong with it, in one line."""
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ConfigError(f"world {path}: cannot be read: {reason}") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise ConfigError(f"world {path}: not valid YAML: {reason}") from error
    if not isinstance(data, dict):
        raise ConfigError(f"world {path}: a map of settings is needed, see deploy/worlds")
    try:
        return WorldFile.model_validate(data, context={"base": path.resolve().parent})
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        raise ConfigError(f"world {path}: {place}: {first['msg']}") from error


def open_world(path: Path, seed: int | None = None) -> Simulation:
    """Return the simulation of a world file, its robot in place; ConfigError if it cannot be.

    `seed` overrides that of the file.
    """
    world = read_world(path)
    rng = np.random.default_rng(world.seed if seed is None else seed)
    try:
        walls = Walls.of(load_map(world.map), world.unmapped, world.doors)
        _refuse_strays(world, walls.geometry)
        simulation = Simulation(walls, world.robot, world.people, rng, world.landmarks)
        if world.start == "random":
            simulation.put_anywhere()
        else:
            simulation.put(np.array(world.start))
    except MapFileError as error:
        raise ConfigError(f"world {path}: map: {error}") from error
    except NoPlaceError as error:
        raise ConfigError(f"world {path}: start: {error}") from error
    except StrayError as error:
        raise ConfigError(f"world {path}: {error}") from error
    return simulation


def _refuse_strays(world: WorldFile, geometry: GridGeometry) -> None:
    """Refuse landmarks beyond the map, and figures of classes that no landmark has; StrayError."""
    landmarks, camera = world.landmarks, world.robot.camera
    in_cells = geometry.grid_from_map(landmarks.positions) / geometry.resolution
    is_inside = ((in_cells >= 0.0) & (in_cells < (geometry.cols, geometry.rows))).all(axis=1)
    if not is_inside.all():
        stray = int(np.argmin(is_inside))
        x, y = landmarks.positions[stray]
        place = f"landmark {stray + 1} ({landmarks.classes[stray]}) at ({x:g}, {y:g})"
        raise StrayError(f"landmarks: {place} lies outside of the map")
    _refuse_stray_doors(world.doors, geometry)
    named = () if camera is None else sorted(camera.recognition_by_class)
    unknown = next((name for name in named if name not in landmarks.classes), None)
    if unknown is not None:
        raise StrayError(f"robot.camera.recognition_by_class: no landmark is a '{unknown}'")


def _refuse_stray_doors(doors: Doors, geometry: GridGeometry) -> None:
    """Refuse doors beyond the map; StrayError."""
    cells = geometry.cells_of(doors.jambs.reshape(-1, 2))
    is_inside = geometry.contains(cells).reshape(-1, 2).all(axis=1)
    if not is_inside.all():
        stray = int(np.argmin(is_inside))
        x, y = doors.jambs[stray].mean(axis=0)
        raise StrayError(f"doors: door {stray + 1} at ({x:g}, {y:g}) lies outside of the map")
