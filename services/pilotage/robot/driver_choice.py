"""Makes the driver that the settings name; ConfigError if it cannot be had."""

import importlib
from typing import Any, cast

from pilotage.bus.deployment import ConfigError
from pilotage.robot.config import RobotSettings
from pilotage.robot.driver import DriverError, RobotDriver, in_words

METHODS = ("__enter__", "__exit__", "describe", "sense", "drive", "stop")


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
    """Return an instance of the class `package.module:Class`, made with `settings`.

    Raises:
        ConfigError: the module cannot be imported, the class not be made, or it is no driver.
    """
    kind = _kind(spec)
    try:
        driver = kind(**settings)
    except DriverError as error:
        raise ConfigError(f"driver {spec}: {error}") from error
    except (Exception, SystemExit) as error:
        raise ConfigError(f"driver {spec}: cannot be made: {in_words(error)}") from error
    missing = [name for name in METHODS if not callable(getattr(driver, name, None))]
    if missing:
        raise ConfigError(f"driver {spec}: is no driver: it has no {', '.join(missing)}")
    return cast("RobotDriver", driver)


def _kind(spec: str) -> Any:  # noqa: ANN401 - whatever stands there: it is tried next
    """Return what `package.module:Class` names."""
    module_name, _, class_name = spec.partition(":")
    try:
        module = importlib.import_module(module_name)
    except ImportError as error:
        raise ConfigError(f"driver {spec}: {error}") from error
    except (Exception, SystemExit) as error:
        # Foreign code runs here: a fault in it is its owner's news, not our traceback.
        reason = f"{module_name} cannot be imported: {in_words(error)}"
        raise ConfigError(f"driver {spec}: {reason}") from error
    if not hasattr(module, class_name):
        raise ConfigError(f"driver {spec}: {module_name} has no {class_name}")
    return getattr(module, class_name)


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
