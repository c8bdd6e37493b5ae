"""A run of a deployment, from its check to the end of its last process."""

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

from pilotage import __version__
from pilotage.bus.clock import SystemClock
from pilotage.bus.deployment import ConfigError, Deployment, read_deployment, service_settings
from pilotage.bus.node import Node
from pilotage.bus.runner import LAUNCHER_PID, prepare_process
from pilotage.bus.session import open_fabric
from pilotage.launcher.addresses import is_accepting, page_address
from pilotage.launcher.child import Child
from pilotage.launcher.config import LauncherSettings
from pilotage.launcher.console import Console
from pilotage.launcher.effective import (
    Overrides,
    effective,
    gateway_address,
    require_free_gateway,
)
from pilotage.launcher.guarding import Guarding
from pilotage.launcher.process_table import PROCESSES, Entry, wanted
from pilotage.launcher.run_folder import run_folder, state_folder, write_deployment
from pilotage.launcher.service import LauncherService
from pilotage.launcher.stop_signals import StopSignals
from pilotage.launcher.supervised import Patience
from pilotage.launcher.supervisor import Ending, Supervisor

ROUTER_POLL_S = 0.02


def launch(
    path: Path,
    overrides: Overrides,
    when_served: Callable[[str], None] = lambda _address: None,
    table: tuple[Entry, ...] = PROCESSES,
) -> int:
    """Run the deployment of a file until a signal ends it; return the exit code.

    `when_served(address)` is called once the page can be opened. Raises ConfigError for what
    cannot be run; 1: the run had to end by itself; 2: a service refused its settings.
    """
    prepare_process("launcher")
    deployment = _checked(path, overrides, table)
    settings = service_settings(deployment, "launcher", LauncherSettings)
    with run_folder(state_folder(), settings.keep_runs) as folder:
        folders = {
            "run_dir": deployment.run_dir or folder,
            "state_dir": deployment.state_dir or state_folder(),
        }
        deployment = deployment.model_copy(update=folders)
        file = write_deployment(deployment, folder)
        ending = _run(deployment, settings, file, when_served, table)
    if ending is None:
        return 0
    sys.stderr.write(f"pilotage up: {ending.reason}\n")
    return ending.code


def _checked(path: Path, overrides: Overrides, table: tuple[Entry, ...]) -> Deployment:
    deployment = read_deployment(path)
    try:
        deployment = effective(deployment, overrides, table)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error
    require_free_gateway(deployment)
    return deployment


def _run(
    deployment: Deployment,
    settings: LauncherSettings,
    file: Path,
    when_served: Callable[[str], None],
    table: tuple[Entry, ...],
) -> Ending | None:
    console = Console()
    address = _greet(console, deployment, file)
    with Guarding() as guard:
        supervisor = Supervisor(
            wanted(table, deployment),
            _starter(file, guard, console),
            console.event,
            SystemClock(),
            Patience(settings.start_limit, settings.hang_grace),
        )
        with StopSignals(supervisor.kill) as stop:
            try:
                ending = _await_router(supervisor, deployment, stop)
                if ending is None and not stop.asked:
                    ending = _supervise(supervisor, deployment, stop, lambda: when_served(address))
            finally:
                if stop.asked:
                    # Not in the handler: the console's lock may be held where the signal came.
                    console.say(f"stopping ({stop.asked_by}); a second signal kills at once")
                supervisor.stop(settings.stop_within)
    return ending


def _greet(console: Console, deployment: Deployment, file: Path) -> str:
    place = gateway_address(deployment)
    address = page_address(*place) if place else ""
    console.say(f"Pilotage {__version__}, robot {deployment.robot} {address}".rstrip())
    console.say(f"settings in {file}; Ctrl-C ends all")
    return address


def _starter(file: Path, guard: Guarding, console: Console) -> Callable[[Entry], Child]:
    environment = os.environ | {LAUNCHER_PID: str(os.getpid()), "PYTHONUNBUFFERED": "1"}

    def start(entry: Entry) -> Child:
        command = [sys.executable, "-m", entry.module, "--deployment", str(file)]
        name = entry.name
        child = Child(name, command, environment, lambda line: console.output(name, line))
        guard.watch(child.pid)
        return child

    return start


def _await_router(
    supervisor: Supervisor, deployment: Deployment, stop: StopSignals
) -> Ending | None:
    while not stop.asked:
        supervisor.tick(bus_is_up=is_accepting(deployment.router))
        ending = supervisor.ending()
        if ending is not None:
            return ending
        if "router" not in supervisor.names() or supervisor.is_ready("router"):
            return None
        time.sleep(ROUTER_POLL_S)
    return None


def _supervise(
    supervisor: Supervisor,
    deployment: Deployment,
    stop: StopSignals,
    when_served: Callable[[], None],
) -> Ending | None:
    with open_fabric(deployment.router, deployment.user, deployment.password) as fabric:
        node = Node("launcher", deployment.robot, fabric, SystemClock())
        service = LauncherService(node, supervisor, when_served)
        stop.on_ask = node.stop
        node.ready()
        if not stop.asked:
            node.run()
    return service.ending
