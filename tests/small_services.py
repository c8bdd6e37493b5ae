"""Tiny services for tests of the bus, each a real process.

python tests/small_services.py mapper --deployment FILE
"""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from pilotage.bus.deployment import Deployment, Settings
from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.bus.runner import run_service
from pilotage_schemas.commands import Done, Drive, LoadMap, MapLoaded
from sample_messages import grid, odometry


class SmallSettings(Settings):
    """What a test may ask of a small service."""

    rate_hz: float = 50.0


@dataclass
class Mapper:
    """Publishes one map, and another whenever it is asked to load one."""

    settings: SmallSettings
    node: Node
    deployment: Deployment

    def __post_init__(self) -> None:
        self.node.answer("load_map", self.load)
        self.publish(rows=3)

    def publish(self, rows: int) -> None:
        """Publish a free map of that many rows."""
        self.node.publisher("map").publish(grid(self.node.clock.now_ns(), rows=rows))

    def load(self, request: LoadMap) -> MapLoaded:
        """Publish a map of as many rows as the path says."""
        if not request.path.isdigit():
            raise RefusedError(f"{request.path} is no number of rows")
        self.publish(rows=int(request.path))
        return MapLoaded(map_id="0123", rows=int(request.path), cols=2)


@dataclass
class Robot:
    """Publishes odometry at the set rate; drives for ever when told to go backward."""

    settings: SmallSettings
    node: Node
    deployment: Deployment

    def __post_init__(self) -> None:
        self.node.every(1.0 / self.settings.rate_hz, self.publish)
        self.node.answer("forward", self.forward)

    def publish(self) -> None:
        """Publish odometry of now."""
        self.node.publisher("odometry").publish(odometry(self.node.clock.now_ns()))

    def forward(self, drive: Drive) -> Done:
        """Say how far."""
        return Done(detail=f"{self.node.robot} went {drive.distance:g} m")


def started(service: str, deployment: Path) -> subprocess.Popen[str]:
    """Start one of these services as a process of its own."""
    command = [sys.executable, __file__, service, "--deployment", str(deployment)]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)


if __name__ == "__main__":
    kind = {"mapper": Mapper, "robot": Robot}[sys.argv.pop(1)]
    raise SystemExit(run_service(kind.__name__.lower(), SmallSettings, kind))
