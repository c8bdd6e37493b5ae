"""Any valid message, however odd, in any order: no service that listens to it fails."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import Deployment
from pilotage.bus.endpoints import reason_of
from pilotage.bus.fabric import RefusedError
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.localizer import method_setup
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.particle_localizer import ParticleParams
from pilotage.localizer.particle_search import SearchParams
from pilotage.localizer.service import LocalizerService
from pilotage.mapper.config import MapperSettings
from pilotage.mapper.service import MapperService
from pilotage.planner.config import PlannerSettings
from pilotage.planner.service import PlannerService
from pilotage.robot.config import RobotSettings
from pilotage.robot.service import RobotService
from pilotage.topology.config import TopologySettings
from pilotage.topology.service import TopologyService
from pilotage_schemas.codec import decode, encode
from pilotage_schemas.localization import Belief, PoseEstimate
from pilotage_schemas.mapping import MappingSensor
from pilotage_schemas.message import Message, Part
from pilotage_schemas.sensors import RobotDescription, RobotStatus, SensorMount
from pilotage_schemas.topics import QUERIES, TOPICS, Query, encoding, query_key, topic_key
from sample_messages import HERE, grid, odometry, scan
from strategies import parts

FEW = replace(ParticleParams(), search=SearchParams(candidates=5_000, kept=1_000))
"""Particles that look for a start in the hall of 20 x 20 cells, not in a building."""

REPOSITORY = Path(__file__).resolve().parents[2]
Build = Callable[[Node], object]
EXAMPLES = {
    "localizer": 80,
    "localizer by mcl": 40,
    "mapper": 40,
    "mapper by laser": 60,
    "mapper by sonar": 40,
    "robot": 20,
    "planner": 60,
    "topology": 60,
    "topology by driving": 60,
}


def localizer_by(method: Literal["markov", "mcl"]) -> Build:
    settings = LocalizerSettings(
        method=method,
        sensors=("laser", "sonar", "compass", "landmark"),
        landmarks=Path(__file__).parent / "beacons.yaml",
        resolution=0.5,
        headings=8,
        belief_period=0.05,
    )

    def build(node: Node) -> object:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(method_setup, "ParticleParams", lambda: FEW)
            return LocalizerService(settings, node, Deployment())

    return build


def mapper_by(sensor: MappingSensor | None) -> Build:
    def build(node: Node) -> object:
        return MapperService(MapperSettings(mapping=sensor), node, Deployment())

    return build


def robot(node: Node) -> object:
    assert isinstance(node.clock, HandClock)
    settings = RobotSettings(world=REPOSITORY / "deploy" / "worlds" / "hall.yaml", seed=1)
    service = RobotService(settings, node, Deployment(), wait=node.clock.advance)
    service.driver.__enter__()
    service.begin()
    return service


def planner(node: Node) -> object:
    return PlannerService(
        PlannerSettings(always_localizes=True, doubt=0.1, settled=0.1), node, Deployment()
    )


def topology_from(source: Literal["map", "drive"]) -> Build:
    def build(node: Node) -> object:
        return TopologyService(TopologySettings(build=source), node, Deployment())

    return build


SERVICES: dict[str, Build] = {
    "localizer": localizer_by("markov"),
    "localizer by mcl": localizer_by("mcl"),
    "mapper": mapper_by(None),
    "mapper by laser": mapper_by("laser"),
    "mapper by sonar": mapper_by("sonar"),
    "robot": robot,
    "planner": planner,
    "topology": topology_from("map"),
    "topology by driving": topology_from("drive"),
}


class Bench:
    """One service on a fake bus, in a small hall, with a laser."""

    def __init__(self, name: str) -> None:
        self.fabric = FakeFabric()
        self.clock = HandClock()
        self.node = Node(name.split(maxsplit=1)[0], "demo", self.fabric, self.clock)
        self.service = SERVICES[name](self.node)
        self.fabric.pump = self.step
        now = self.clock.now_ns()
        mount = SensorMount(frame_id="laser", kind="laser", pose=HERE)
        for topic, message in {
            "map": grid(now, rows=20, cols=20),
            "description": description(now, mount),
            "odometry": odometry(now),
            "scan": scan(now),
            "status": status(now),
            "pose": lost(now),
            "belief": nowhere_known(now),
        }.items():
            self.send(topic, message)

    def send(self, topic_name: str, message: Message) -> None:
        topic = TOPICS[topic_name]
        key = topic_key("demo", topic, "somebody")
        put = self.fabric.declare_publisher(key, encoding(topic.message), topic.delivery)
        put(encode(message))
        self.step()

    def step(self) -> None:
        """Let the service do what has come."""
        self.clock.advance(0.1)
        self.node.step()

    def ask(self, query: Query, request: Part) -> bytes:
        """Ask the service; BusError in the absence of an answer."""
        return self.fabric.ask(query_key("demo", query), encode(request), 1.0)


def description(stamp_ns: int, mount: SensorMount) -> RobotDescription:
    return RobotDescription(
        stamp_ns=stamp_ns,
        frame_id="base_link",
        name="demo",
        driver="test",
        footprint=np.zeros((0, 2), np.float32),
        mounts=(mount,),
        max_linear=1.0,
        max_angular=1.0,
        commands=("velocity",),
    )


def status(stamp_ns: int) -> RobotStatus:
    return RobotStatus(
        stamp_ns=stamp_ns,
        frame_id="base_link",
        source="simulation",
        mode="wandering",
        reason="going about",
    )


def lost(stamp_ns: int) -> PoseEstimate:
    return PoseEstimate(
        stamp_ns=stamp_ns,
        frame_id="map",
        pose=HERE,
        covariance=np.eye(3),
        state="lost",
        confidence=0.0,
    )


def nowhere_known(stamp_ns: int) -> Belief:
    places = [[0.2, 0.5, 0.0, 0.5], [0.5, 0.2, 1.0, 0.3], [30.0, -1e6, 2.0, 0.2]]
    return Belief(
        stamp_ns=stamp_ns,
        frame_id="map",
        map_id="0123",
        method="markov",
        samples=np.array(places, np.float32),
        entropy=1.5,
        modes=(),
    )


def heard_by(name: str) -> list[str]:
    """The topics that the service listens to."""
    traffic = Bench(name).node.vitals._traffic
    return sorted({line.topic.name for line in traffic if line.direction == "in"})


@st.composite
def messages(draw: st.DrawFn, names: list[str]) -> tuple[str, Message]:
    """A topic, and any valid message on it, often of the laser."""
    name = draw(st.sampled_from(names))
    message = draw(parts(TOPICS[name].message))
    assert isinstance(message, Message)
    frame_id = draw(st.sampled_from(["laser", message.frame_id]))
    return name, message.model_copy(update={"frame_id": frame_id})


@pytest.mark.parametrize("name", [name for name in SERVICES if heard_by(name)])
def test_no_valid_message_stops_a_service(name: str) -> None:
    @settings(max_examples=EXAMPLES[name], suppress_health_check=list(HealthCheck))
    @given(st.lists(messages(heard_by(name)), max_size=8), st.floats(-1.0, 5.0))
    def attack(sent: list[tuple[str, Message]], seconds: float) -> None:
        bench = Bench(name)
        stamp_ns = bench.clock.now_ns()
        for seq, (topic, message) in enumerate(sent, start=1):
            stamp_ns += round(seconds * 1e9)
            bench.send(topic, message.model_copy(update={"stamp_ns": stamp_ns, "seq": seq}))

    attack()


ANSWERED = [query for query in QUERIES.values() if query.service in SERVICES]


@pytest.mark.parametrize("query", ANSWERED, ids=lambda query: query.name)
@settings(max_examples=15, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_no_valid_question_stops_a_service(query: Query, data: st.DataObject) -> None:
    bench = Bench(query.service)
    assert answer(bench, query, data.draw(parts(query.request)))
    bench.send("odometry", odometry(bench.clock.now_ns()))


def answer(bench: Bench, query: Query, request: Part) -> str:
    """What the service answers, or why it does not."""
    try:
        return repr(decode(query.reply, bench.ask(query, request)))
    except RefusedError as refused:
        return reason_of(refused)
