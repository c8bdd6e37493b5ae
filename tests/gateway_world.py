"""A gateway on a fake bus with a clock turned by hand, and the services around it."""

import warnings
from collections.abc import Callable, Mapping
from typing import Any, Self

import numpy as np
from starlette.exceptions import StarletteDeprecationWarning

from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import Deployment
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.gateway.access import access_of
from pilotage.gateway.app import create_app
from pilotage.gateway.config import GatewaySettings
from pilotage.gateway.service import GatewayService
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.health import Deployment as DeploymentMessage
from pilotage_schemas.health import Process
from pilotage_schemas.localization import Belief, Mode, PoseEstimate
from pilotage_schemas.mapping import OccupancyGrid
from pilotage_schemas.message import Message, Part
from pilotage_schemas.planning import PlanningStatus
from pilotage_schemas.sensors import LaserScan, Odometry, RobotDescription, RobotStatus

with warnings.catch_warnings():
    # Starlette would rather have httpx2; the locked httpx serves it as well.
    warnings.simplefilter("ignore", StarletteDeprecationWarning)
    from starlette.testclient import TestClient, WebSocketDenialResponse, WebSocketTestSession

__all__ = ["TestClient", "WebSocketDenialResponse", "WebSocketTestSession"]

PORT = 8000
HOST = f"127.0.0.1:{PORT}"
ROBOT = "/api/v1/robots/demo"
PALETTE = {"#": 100, ".": 0, "?": -1}


class GatewayWorld:
    """The gateway of robot `demo`; `publish` as any service, `step` to let the gateway see it."""

    def __init__(self, **settings: object) -> None:
        self.fabric = FakeFabric()
        self.clock = HandClock()
        self.node = Node("gateway", "demo", self.fabric, self.clock)
        self.settings = GatewaySettings.model_validate(settings)
        self.service = GatewayService(self.settings, self.node, Deployment())
        self.client = TestClient(
            create_app(self.service, access_of(self.settings, PORT)),
            base_url=f"http://{HOST}",
            raise_server_exceptions=False,
        )
        self._others: dict[str, Node] = {}

    def __enter__(self) -> Self:
        self.client.__enter__()
        return self

    def __exit__(self, *reason: object) -> None:
        self.client.__exit__()

    @property
    def now_ns(self) -> int:
        return self.clock.now_ns()

    def other(self, service: str) -> Node:
        """Return the node of another service."""
        if service not in self._others:
            self._others[service] = Node(service, "demo", self.fabric, self.clock)
        return self._others[service]

    def publish(self, service: str, topic: str, message: Message) -> None:
        """Send a message and let the gateway handle it."""
        self.other(service).publisher(topic).publish(message)
        self.step()

    def answer(self, service: str, query: str, handler: Callable[[Any], Part]) -> None:
        """Let a service answer a query."""
        node = self.other(service)
        node.answer(query, handler)

        def pump() -> None:
            node.step()

        self.fabric.pump = pump

    def step(self) -> None:
        """Let the gateway's loop handle what has come and what is due."""
        assert self.client.portal is not None
        self.client.portal.call(self.node.step)

    def stream(
        self, query: str = "", headers: Mapping[str, str] | None = None
    ) -> WebSocketTestSession:
        """Open the live stream."""
        address = f"ws://{HOST}{ROBOT}/stream{query}"
        return self.client.websocket_connect(address, headers=dict(headers or {}))

    def events(self) -> list[str]:
        """Return the texts of all events, oldest first."""
        return [event.text for event in self.service.events.after(0)]


def pose_estimate(stamp_ns: int, x: float = 1.0, **changes: object) -> PoseEstimate:
    fields: dict[str, object] = {
        "pose": Pose2(x=x, y=2.0, theta=0.5),
        "covariance": np.eye(3) * 0.01,
        "state": "localized",
        "confidence": 0.97,
    }
    fields |= {"stamp_ns": stamp_ns, "frame_id": "map"}
    return PoseEstimate.model_validate(fields | changes)


def belief(stamp_ns: int) -> Belief:
    mode = Mode(mass=0.8, pose=Pose2(x=1.0, y=2.0, theta=0.5), covariance=np.eye(3))
    samples = np.array([[1.0, 2.0, 0.5, 0.8], [4.0, 2.0, 0.5, 0.2]], np.float32)
    return Belief(
        stamp_ns=stamp_ns,
        frame_id="map",
        map_id="abc",
        method="markov",
        samples=samples,
        entropy=0.72,
        modes=(mode,),
    )


def grid(drawing: str, stamp_ns: int = 1, map_id: str = "abc", **changes: object) -> OccupancyGrid:
    """Return the map of a drawing: `#` occupied, `.` free, `?` unknown; top line first."""
    lines = drawing.split()
    cells = np.array([[PALETTE[mark] for mark in line] for line in reversed(lines)], np.int8)
    fields: dict[str, object] = {
        "name": "drawn",
        "resolution": 0.5,
        "origin": Pose2(x=-1.0, y=-2.0, theta=0.0),
    }
    fields |= {"stamp_ns": stamp_ns, "frame_id": "map", "map_id": map_id, "cells": cells}
    return OccupancyGrid.model_validate(fields | changes)


def scan(stamp_ns: int, *ranges: float) -> LaserScan:
    return LaserScan(
        stamp_ns=stamp_ns,
        frame_id="laser",
        angle_min=-1.5,
        angle_increment=0.01,
        range_min=0.0,
        range_max=20.0,
        ranges=np.array(ranges, np.float32),
    )


def odometry(stamp_ns: int) -> Odometry:
    return Odometry(
        stamp_ns=stamp_ns,
        frame_id="odom",
        pose=Pose2(x=0.0, y=0.0, theta=0.0),
        twist=Twist2(vx=0.3, vy=0.0, omega=0.0),
        covariance=np.zeros((3, 3)),
    )


def status(stamp_ns: int, **changes: object) -> RobotStatus:
    fields: dict[str, object] = {"source": "simulation", "mode": "wandering", "reason": ""}
    fields |= {"stamp_ns": stamp_ns, "frame_id": ""}
    return RobotStatus.model_validate(fields | changes)


def description(stamp_ns: int) -> RobotDescription:
    return RobotDescription(
        stamp_ns=stamp_ns,
        frame_id="base_link",
        name="simulator",
        driver="simulator",
        footprint=np.array([[0.2, 0.2], [-0.2, 0.2], [0.0, -0.2]], np.float32),
        mounts=(),
        max_linear=0.5,
        max_angular=1.0,
        commands=("forward", "stop", "kidnap"),
    )


def process(name: str, state: str, **changes: object) -> Process:
    fields: dict[str, object] = {
        "pid": 4711,
        "since_ns": 1,
        "late_for": None,
        "limit": 1.0,
        "restarts": 0,
        "try_number": 0,
        "max_tries": 5,
        "reason": "",
    }
    return Process.model_validate(fields | {"name": name, "state": state} | changes)


def deployment(stamp_ns: int, *processes: Process) -> DeploymentMessage:
    return DeploymentMessage(stamp_ns=stamp_ns, frame_id="", processes=processes)


def planning_status(stamp_ns: int, **fields: object) -> PlanningStatus:
    """What the planner says, idle unless told otherwise."""
    usual = {"mode": "idle", "always_localizes": False, "reason": "nothing to do"}
    return PlanningStatus.model_validate({"stamp_ns": stamp_ns, "frame_id": "map"} | usual | fields)
