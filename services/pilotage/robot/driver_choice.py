"""Makes the driver that the settings name; ConfigError if it cannot be had."""

import importlib
from typing import cast

from pilotage.bus.deployment import ConfigError
from pilotage.robot.config import RobotSettings
from pilotage.robot.driver import DriverError, RobotDriver


def make_driver(settings: RobotSettings) -> RobotDriver:
    """Return the driver, not yet opened."""
    match settings.driver:
        case "simulator":
            return _simulator(settings)
        case "replay":
            return _replay(settings)
        case spec:
            return load_driver(spec, settings.driver_settings)


def load_driver(spec: str, settings: dict[str, object]) -> RobotDriver:
    """Return an instance of the class `package.module:Class`, made with `settings`."""
    module_name, _, class_name = spec.partition(":")
    try:
        kind = getattr(importlib.import_module(module_name), class_name)
        return cast("RobotDriver", kind(**settings))
    except ImportError as error:
        raise ConfigError(f"driver {spec}: {error}") from error
    except AttributeError as error:
        raise ConfigError(f"driver {spec}: {module_name} has no {class_name}") from error
    except (TypeError, ValueError, DriverError) as error:
        raise ConfigError(f"driver {spec}: {error}") from error


def _simulator(settings: RobotSettings) -> RobotDriver:
    # Imported here: a real robot and a replay need neither numba nor a world.
    from pilotage.robot.simulator.config import open_world  # noqa: PLC0415 - start-up time
    from pilotage.robot.simulator.simulator import Simulator  # noqa: PLC0415 - start-up time

    if settings.world is None:
        raise ConfigError("settings of robot: the simulator needs a world, see deploy/worlds")
    return Simulator(open_world(settings.world, settings.seed))


def _replay(settings: RobotSettings) -> RobotDriver:
    from pilotage.core.logs import LogError, read_log  # noqa: PLC0415 - start-up time
    from pilotage.robot.replay import Replay  # noqa: PLC0415 - start-up time

    if settings.log is None:
        raise ConfigError("settings of robot: replay needs a log")
    try:
        log = read_log(settings.log)
    except LogError as error:
        raise ConfigError(str(error)) from error
    return Replay(log, settings.log.name, settings.speed, loop=settings.loop)
