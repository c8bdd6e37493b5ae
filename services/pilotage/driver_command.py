"""`pilotage driver check`: tries whether a driver keeps what the protocol promises."""

import re
import sys
import time
from pathlib import Path

from pilotage.bus.clock import SystemClock
from pilotage.bus.deployment import ConfigError, Deployment, read_deployment, service_settings
from pilotage.robot.config import RobotSettings
from pilotage.robot.conformance import check_driver
from pilotage.robot.driver_choice import make_driver

FOUND = 1
_CLASS = re.compile(r"[\w.]+:\w+")


def check(spec: str) -> int:
    """Print a line for each promise that the driver breaks; return 1 if there is any, else 0.

    Args:
        spec: `package.module:Class`, or a deployment file, whose `robot` is meant.

    Raises:
        ConfigError: there is no such driver or deployment.
    """
    driver = make_driver(_settings(spec))
    found = 0
    for finding in check_driver(driver, SystemClock(), time.sleep):
        sys.stdout.write(f"{finding}\n")
        found += 1
    sys.stdout.write(f"{spec}: {found or 'nothing'} to mend\n")
    return FOUND if found else 0


def _settings(spec: str) -> RobotSettings:
    if not spec.strip():
        raise ConfigError("driver check takes package.module:Class or a deployment file, not ''")
    if _CLASS.fullmatch(spec):
        deployment = Deployment(services={"robot": {"driver": spec}})
    else:
        deployment = read_deployment(Path(spec))
    return service_settings(deployment, "robot", RobotSettings)
