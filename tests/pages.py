"""What the page knows of a running robot, over HTTP, for tests of whole runs."""

import math
import time
from collections import deque
from typing import Any, Self

import httpx

from waiting import eventually

NEAR_M = 0.5
NEAR_RAD = math.radians(15.0)
SAME_TIME_NS = 60_000_000
"""Pose and truth are compared when measured at the same time, to a period of odometry."""


class Page:
    """The gateway of the robot `demo` at a port of this machine."""

    def __init__(self, port: int) -> None:
        self._client = httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=5.0)
        self._truths: deque[dict[str, Any]] = deque(maxlen=200)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()

    def answers(self, path: str) -> bool:
        """Say whether a path is served."""
        try:
            return self._client.get(path).status_code == httpx.codes.OK
        except httpx.TransportError:
            return False

    def get(self, what: str) -> dict[str, Any] | None:
        """Return the newest of something, None without one."""
        try:
            answer = self._client.get(f"/api/v1/robots/demo/{what}")
        except httpx.TransportError:
            return None
        return answer.json() if answer.status_code == httpx.codes.OK else None

    def command(self, name: str, /, **arguments: object) -> dict[str, Any]:
        """Give a command that must be carried out."""
        answer = self._client.post(f"/api/v1/robots/demo/commands/{name}", json=arguments)
        assert answer.status_code == httpx.codes.OK, answer.text
        reply: dict[str, Any] = answer.json()
        return reply

    def process(self, name: str) -> dict[str, Any]:
        """Return what the deployment says of a process."""
        deployment = self.get("deployment")
        found = deployment["processes"] if deployment else []
        return next((one for one in found if one["name"] == name), {})

    def is_back(self, name: str, restarts: int) -> bool:
        """Say whether a process is ready again after so many restarts."""
        one = self.process(name)
        return bool(one) and one["state"] == "ready" and one["restarts"] > restarts

    def is_localized_since(self, stamp_ns: int) -> bool:
        """Say whether a pose measured after `stamp_ns` is localized where the robot truly is."""
        truth, pose = self.get("sensors/ground_truth"), self.get("pose")
        if truth is not None:
            self._truths.append(truth)
        if pose is None or pose["stamp_ns"] < stamp_ns or pose["state"] != "localized":
            return False
        return any(
            is_near(pose["pose"], truth["pose"])
            for truth in self._truths
            if abs(truth["stamp_ns"] - pose["stamp_ns"]) < SAME_TIME_NS
        )

    def localized(self, within: float) -> None:
        """Wait until a pose measured from now on is localized where the robot truly is."""
        began = time.time_ns()
        eventually(lambda: self.is_localized_since(began), within, "a localized pose")


def is_near(pose: dict[str, float], truth: dict[str, float]) -> bool:
    """Say whether two poses are the same place."""
    way = math.hypot(pose["x"] - truth["x"], pose["y"] - truth["y"])
    turn = math.remainder(pose["theta"] - truth["theta"], math.tau)
    return way < NEAR_M and abs(turn) < NEAR_RAD
