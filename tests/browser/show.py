"""A scripted robot in a small building: every message the page shows, ten times a second."""

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from browser.live_gateway import LiveGateway
from pilotage.bus.fabric import RefusedError
from pilotage_schemas.commands import Done, Kidnapped, SetPose, Stopped, Wander
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.health import Deployment, Health, Heartbeat, Process, TopicHealth
from pilotage_schemas.localization import Belief, Marginal, Mode, PoseEstimate
from pilotage_schemas.mapping import OccupancyGrid
from pilotage_schemas.message import Message, Part
from pilotage_schemas.sensors import (
    GroundTruth,
    LaserScan,
    RobotDescription,
    RobotStatus,
    SensorMount,
)

CELL = 0.05
MAP_ID = "5f3c0a9be2d41c77"
WIDTH, HEIGHT = 26.0, 13.0
PERIOD_S = 0.1
COMMANDS = ("forward", "backward", "turn", "velocity", "stop", "wander", "kidnap")
PLACES = ((0.58, 15.5, 6.5, 0.03), (0.27, 9.0, 6.5, 0.0), (0.09, 3.5, 3.0, 1.5))
"""Mass, x, y and theta of each place the robot could be."""

STREAMS = {"robot": ("odometry", 20.0), "mapper": None, "localizer": ("pose", 9.8), "router": None}


@dataclass(frozen=True)
class Script:
    """What the show tells; replaced by the test as it goes."""

    state: str = "ambiguous"
    source: str = "simulation"
    mode: str = "wandering"
    places: tuple[tuple[float, float, float, float], ...] = PLACES
    confidence: float = 0.55
    pose: tuple[float, float, float] | None = None
    silent: frozenset[str] = frozenset()
    localizer: tuple[tuple[str, Any], ...] = ()
    planner: str = ""
    topology: str = ""
    commands: tuple[str, ...] = COMMANDS


class Show:
    """Publishes what its `script` says until it ends."""

    def __init__(self, gateway: LiveGateway, script: Script | None = None) -> None:
        self.gateway = gateway
        self.script = script or Script()
        self.asked: list[tuple[str, Part]] = []
        self.refusal = ""
        self._ended = threading.Event()
        self._ticks = 0
        self._thread = threading.Thread(target=self._run)
        self._listen()

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *reason: object) -> None:
        self._ended.set()
        self._thread.join(10.0)

    def change(self, **changes: object) -> None:
        """Let the show go on differently."""
        self.script = replace(self.script, **changes)  # type: ignore[arg-type]  # names are the fields

    def _run(self) -> None:
        while not self._ended.is_set():
            self.tick()
            self._ended.wait(PERIOD_S)

    def tick(self) -> None:
        """Publish one round; what comes rarely every tenth time."""
        script, now = self.script, self.gateway.clock.now_ns()
        if self._ticks % 10 == 0:
            self._tell("mapper", "map", building(now))
            self._tell("robot", "description", description(now, script))
            self._tell("launcher", "deployment", deployment(now, script))
            for service in STREAMS:
                self._tell(service, "health", health(now, service))
        if self._ticks % 5 == 0:
            self._tell("robot", "status", status(now, script))
            self._tell("localizer", "belief", belief(now, script.places))
            for service in STREAMS:
                self._tell(service, "heartbeat", heartbeat(now, service))
        pose = script.pose or self._track()
        self._tell("localizer", "pose", estimate(now, script, pose))
        self._tell("robot", "scan", scan(now))
        if script.source == "simulation":
            self._tell("robot", "ground_truth", truth(now, pose))
        self._ticks += 1

    def _tell(self, service: str, topic: str, message: Message) -> None:
        if service not in self.script.silent and topic not in self.script.silent:
            self.gateway.publish(service, topic, message)

    def _track(self) -> tuple[float, float, float]:
        """Return a pose on the way along the corridor to where the best place is."""
        x = 2.0 + min(13.5, 0.35 * self._ticks)
        return x, 6.5 + 0.3 * math.sin(x), 0.3 * math.cos(x)

    def _listen(self) -> None:
        robot = {
            "forward": Done(),
            "backward": Done(),
            "turn": Done(),
            "velocity": Done(),
            "stop": Stopped(after=0.08),
        }
        for name, reply in robot.items():
            self.gateway.answer("robot", name, self._answer(name, reply))
        self.gateway.answer("robot", "wander", self._wander)
        here = Kidnapped(pose=Pose2(x=3.0, y=2.0, theta=0.0))
        self.gateway.answer("robot", "kidnap", self._answer("kidnap", here))
        self.gateway.answer("localizer", "relocalize", self._answer("relocalize", Done()))
        self.gateway.answer("localizer", "set_pose", self._set_pose)

    def _answer(self, name: str, reply: Part) -> Callable[[Part], Part]:
        def answer(request: Part) -> Part:
            self.asked.append((name, request))
            return reply

        return answer

    def _wander(self, request: Wander) -> Done:
        self.asked.append(("wander", request))
        self.change(mode="wandering" if request.enabled else "stopped")
        return Done()

    def _set_pose(self, request: SetPose) -> Done:
        self.asked.append(("set_pose", request))
        if self.refusal:
            raise RefusedError(self.refusal)
        return Done()


def building(now: int) -> OccupancyGrid:
    """Return rooms on both sides of a corridor, with doors and some furniture."""
    cells = np.full((round((HEIGHT + 2) / CELL), round((WIDTH + 2) / CELL)), -1, np.int8)

    def fill(x: float, y: float, width: float, height: float, value: int) -> None:
        low, left = round((y + 1) / CELL), round((x + 1) / CELL)
        cells[low : low + round(height / CELL), left : left + round(width / CELL)] = value

    fill(0, 0, WIDTH, HEIGHT, 100)
    fill(0.15, 5.3, WIDTH - 0.3, 2.4, 0)
    for x, width in ((0.15, 6.0), (6.3, 6.0), (12.45, 6.0), (18.6, 7.25)):
        fill(x, 7.85, width, 5.0, 0)
        fill(x + 2.5, 7.6, 1.1, 0.4, 0)
    for x, width in ((0.15, 8.0), (8.3, 8.5), (16.95, 8.9)):
        fill(x, 0.15, width, 5.0, 0)
        fill(x + 3.0, 5.1, 1.1, 0.4, 0)
    for x, y in ((1.2, 11.0), (14.0, 11.5), (22.5, 10.0), (2.0, 1.0), (19.0, 1.5)):
        fill(x, y, 1.3, 0.9, 100)
    origin = Pose2(x=-1.0, y=-1.0, theta=0.0)
    return OccupancyGrid(
        stamp_ns=now,
        frame_id="map",
        map_id=MAP_ID,
        name="building",
        resolution=CELL,
        origin=origin,
        cells=cells,
    )


def belief(now: int, places: tuple[tuple[float, float, float, float], ...]) -> Belief:
    """Return a belief of Gaussians 0.45 m wide at the places, the rest spread everywhere."""
    resolution = 0.2
    rows, cols = round(HEIGHT / resolution), round(WIDTH / resolution)
    y, x = (np.indices((rows, cols)) + 0.5) * resolution
    mass: NDArray[np.float64] = np.full((rows, cols), 0.0)
    is_corridor = (y > 5.3) & (y < 7.7)
    for weight, px, py, _ in places:
        peak = np.exp(-((x - px) ** 2 + (y - py) ** 2) / (2 * 0.45**2))
        peak[is_corridor != (5.3 < py < 7.7)] = 0.0
        mass += weight * peak / peak.sum()
    rest = 1.0 - sum(weight for weight, *_ in places)
    mass += rest / mass.size
    modes = tuple(
        Mode(mass=w, pose=Pose2(x=px, y=py, theta=t), covariance=np.diag([0.2, 0.2, 0.01]))
        for w, px, py, t in places
    )
    return Belief(
        stamp_ns=now,
        frame_id="map",
        map_id=MAP_ID,
        method="markov",
        samples=np.array([[px, py, t, w] for w, px, py, t in places], np.float32),
        entropy=3.4 + 6.0 * rest,
        modes=modes,
        marginal=Marginal(
            resolution=resolution,
            origin=Pose2(x=0.0, y=0.0, theta=0.0),
            mass=mass.astype(np.float32),
        ),
        matched=0.9,
    )


def estimate(now: int, script: Script, pose: tuple[float, float, float]) -> PoseEstimate:
    """Return the pose with the script's state."""
    x, y, theta = pose
    fields = {"state": script.state, "confidence": script.confidence}
    return PoseEstimate.model_validate(
        {
            "stamp_ns": now,
            "frame_id": "map",
            "pose": Pose2(x=x, y=y, theta=theta),
            "covariance": np.diag([0.01, 0.01, 0.001]),
        }
        | fields
    )


def scan(now: int) -> LaserScan:
    """Return a fan of ranges, some without a return."""
    ranges = np.full(181, 1.1, np.float32)
    ranges[80:100] = np.inf
    return LaserScan(
        stamp_ns=now,
        frame_id="laser",
        angle_min=-math.pi / 2,
        angle_increment=math.pi / 180,
        range_min=0.02,
        range_max=12.0,
        ranges=ranges,
    )


def truth(now: int, pose: tuple[float, float, float]) -> GroundTruth:
    """Return the true pose, a little beside the estimate."""
    x, y, theta = pose
    still = Twist2(vx=0.0, vy=0.0, omega=0.0)
    place = Pose2(x=x + 0.05, y=y + 0.02, theta=theta)
    return GroundTruth(stamp_ns=now, frame_id="map", pose=place, twist=still)


def description(now: int, script: Script) -> RobotDescription:
    """Return a small round robot with a laser."""
    angles = np.arange(12) * (2 * math.pi / 12)
    laser = SensorMount(frame_id="laser", kind="laser", pose=Pose2(x=0.1, y=0.0, theta=0.0))
    return RobotDescription(
        stamp_ns=now,
        frame_id="base_link",
        name="simulator",
        driver="simulator",
        footprint=np.column_stack([np.cos(angles), np.sin(angles)]).astype(np.float32) * 0.2,
        mounts=(laser,),
        max_linear=0.5,
        max_angular=1.0,
        commands=script.commands,
    )


def status(now: int, script: Script) -> RobotStatus:
    """Return what the robot does."""
    fields: dict[str, object] = {"source": script.source, "mode": script.mode, "reason": ""}
    fields |= {"progress": 0.42} if script.source == "replay" else {}
    return RobotStatus.model_validate({"stamp_ns": now, "frame_id": ""} | fields)


def deployment(now: int, script: Script) -> Deployment:
    """Return all processes well, but for what the script says; without planner if it says none."""

    def process(name: str, **changes: object) -> Process:
        fields: dict[str, object] = {"name": name, "state": "ready", "pid": 4711}
        fields |= {"since_ns": now, "late_for": None}
        fields |= {"limit": 1.0, "restarts": 0, "try_number": 0, "max_tries": 5, "reason": ""}
        return Process.model_validate(fields | changes)

    names = ["router", "mapper", "robot", "localizer", "gateway"]
    changes: dict[str, dict[str, Any]] = {"localizer": dict(script.localizer)}
    for name in ("planner", "topology"):
        if state := getattr(script, name):
            names.append(name)
            changes[name] = {"state": state}
    processes = tuple(process(name, **changes.get(name, {})) for name in names)
    return Deployment(stamp_ns=now, frame_id="", processes=processes)


def health(now: int, service: str) -> Health:
    """Return a service's account of its main stream."""
    stream = STREAMS[service]
    topics: tuple[TopicHealth, ...] = ()
    if stream is not None:
        name, rate = stream
        fields: dict[str, object] = {"topic": name, "direction": "out", "count": 100}
        fields |= {"rate_hz": rate}
        fields |= {"dropped": 0, "age": 0.05, "limit": 1.0}
        topics = (TopicHealth.model_validate(fields),)
    return Health(
        stamp_ns=now,
        frame_id="",
        service=service,
        uptime=60.0,
        cpu_percent=12.0,
        rss_mb=80.0,
        topics=topics,
        dropped=0,
        last_error="",
    )


def heartbeat(now: int, service: str) -> Heartbeat:
    """Return a heartbeat of a service that is well."""
    return Heartbeat(stamp_ns=now, frame_id="", service=service, state="ready", within=1.0)
