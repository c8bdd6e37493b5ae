"""The life of a service process: settings, node, service, loop, graceful end.

A service's `__main__` is one call:

    raise SystemExit(run_service("localizer", LocalizerSettings, LocalizerService))
"""

import argparse
import ctypes
import logging
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TypeVar

from pilotage.bus.clock import SystemClock
from pilotage.bus.deployment import (
    ConfigError,
    Deployment,
    Settings,
    read_deployment,
    service_settings,
)
from pilotage.bus.fabric import BusError
from pilotage.bus.node import Node
from pilotage.bus.session import open_fabric

LAUNCHER_PID = "PILOTAGE_LAUNCHER_PID"
"""Set by the launcher: a service dies with it (prctl is asked by the child itself, because code
between fork and exec is not safe in a process with Zenoh's threads)."""

PR_SET_PDEATHSIG = 1

Config = TypeVar("Config", bound=Settings)
Service = TypeVar("Service")


def run_node(node: Node, _service: object) -> None:
    """Say that the service is ready and run the node's own loop until it is stopped."""
    node.ready()
    node.run()


def run_service(
    name: str,
    settings: type[Config],
    build: Callable[[Config, Node, Deployment], Service],
    live: Callable[[Node, Service], None] = run_node,
) -> int:
    """Run the service until it is asked to stop; return the exit code.

    `build(settings, node, deployment)` subscribes, answers and publishes on the node; what it
    returns is kept alive until the end. `live(node, service)` lasts until the node is stopped;
    a service that has a loop of its own steps the node there. 2: bad settings; 1: no router.
    """
    prepare_process(name)
    try:
        deployment = deployment_of_arguments(name)
        config = service_settings(deployment, name, settings)
        with open_node(name, deployment) as node:
            service = build(config, node, deployment)
            live(node, service)
    except ConfigError as error:
        return complain(name, error, 2)
    except BusError as error:
        return complain(name, error, 1)
    return 0


def prepare_process(name: str) -> None:
    """Log to stderr with the service's name; die with the launcher, if there is one."""
    logging.basicConfig(level=logging.INFO, format="%(levelname)s %(name)s %(message)s")
    launcher = os.environ.get(LAUNCHER_PID)
    if launcher is None:
        return
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(launcher):
        raise SystemExit(complain(name, "the launcher is gone", 1))


def deployment_of_arguments(name: str) -> Deployment:
    """Return the deployment named on the command line, or the default one."""
    parser = argparse.ArgumentParser(f"pilotage.{name}")
    parser.add_argument("--deployment", type=Path, help="YAML file with this service's settings")
    path = parser.parse_args().deployment
    return Deployment() if path is None else read_deployment(path)


@contextmanager
def open_node(name: str, deployment: Deployment) -> Iterator[Node]:
    """Connect the node of service `name`; the first signal asks it to stop, the second forces."""
    with open_fabric(deployment.router, deployment.user, deployment.password) as fabric:
        node = Node(name, deployment.robot, fabric, SystemClock())
        _stop_on_signals(node)
        yield node


def complain(name: str, reason: object, code: int) -> int:
    """Print one clear line to stderr and return the exit code."""
    sys.stderr.write(f"pilotage {name}: {' '.join(str(reason).split())}\n")
    return code


def _stop_on_signals(node: Node) -> None:
    def ask(_signal: int, _frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, force)
        signal.signal(signal.SIGTERM, force)
        node.stop()

    def force(number: int, _frame: FrameType | None) -> None:
        os._exit(128 + number)

    signal.signal(signal.SIGINT, ask)
    signal.signal(signal.SIGTERM, ask)
