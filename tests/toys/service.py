"""What a toy does on the bus."""

import os
import signal
import sys
import threading
from pathlib import Path
from types import FrameType

from pilotage.bus.deployment import ConfigError, Deployment
from pilotage.bus.node import Node
from pilotage.bus.runner import run_service
from toys.config import ToySettings

SLOW_S = 1.5


class Toy:
    """Behaves as its settings say."""

    def __init__(self, settings: ToySettings, node: Node, _deployment: Deployment) -> None:
        sys.stderr.write(f"I am {node.name} and {settings.mood}\n")
        match settings.mood:
            case "crashing":
                os._exit(1)
            case "refusing":
                raise ConfigError("this toy refuses its settings")
            case "deaf":
                _ignore_requests()
            case "silent":
                node.every(0.5, _hang)
            case "slow":
                threading.Event().wait(SLOW_S)
            case "steady":
                pass


def run(file: str) -> int:
    """Run the toy that is named as its module's file."""
    return run_service(Path(file).stem, ToySettings, Toy)


def _hang() -> None:
    threading.Event().wait()


def _ignore_requests() -> None:
    def refuse(_number: int, _frame: FrameType | None) -> None:
        pass

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, refuse)
