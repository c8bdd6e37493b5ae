"""Commands over HTTP: carried out, refused, unanswered."""

import json
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from gateway_world import ROBOT, GatewayWorld
from pilotage.bus.fabric import BusError, NoAnswerInTimeError, RefusedError
from pilotage.gateway.commander import MAX_WAITING
from pilotage.gateway.json_form import from_json, to_json
from pilotage.gateway.routes.commands import COMMANDS, EXAMPLES
from pilotage_schemas.codec import DecodeError
from pilotage_schemas.commands import (
    Done,
    Drive,
    Kidnap,
    Kidnapped,
    MapLoaded,
    SetMap,
    SetMethod,
    SetPose,
    Stopped,
)
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Part
from waiting import eventually


@pytest.fixture
def world() -> Iterator[GatewayWorld]:
    with GatewayWorld() as world:
        yield world


def raising(error: Exception) -> Callable[[str, Part], Part]:
    def ask(_name: str, _request: Part) -> Part:
        raise error

    return ask


def test_a_command_reaches_the_service_and_its_reply_comes_back(world: GatewayWorld) -> None:
    asked: list[Drive] = []

    def drive(request: Drive) -> Done:
        asked.append(request)
        return Done(detail="on the way")

    world.answer("robot", "forward", drive)
    answer = world.client.post(f"{ROBOT}/commands/forward", json={"distance": 1, "speed": 0.2})
    assert answer.status_code == 200
    assert answer.json() == {"detail": "on the way"}
    assert asked == [Drive(distance=1.0, speed=0.2)]


def test_a_command_without_arguments_needs_no_body(world: GatewayWorld) -> None:
    world.answer("robot", "stop", lambda _request: Stopped(after=0.08))
    assert world.client.post(f"{ROBOT}/commands/stop").json() == {"after": 0.08}
    assert world.client.post(f"{ROBOT}/commands/stop", json={}).status_code == 200


def test_an_array_travels_as_nested_lists(world: GatewayWorld) -> None:
    asked: list[SetPose] = []

    def set_pose(request: SetPose) -> Done:
        asked.append(request)
        return Done()

    world.answer("localizer", "set_pose", set_pose)
    body = {"pose": {"x": 1, "y": 2, "theta": 0}, "covariance": np.diag([1, 2, 3]).tolist()}
    assert world.client.post(f"{ROBOT}/commands/set_pose", json=body).status_code == 200
    assert asked[0].covariance is not None
    np.testing.assert_array_equal(asked[0].covariance, np.diag([1.0, 2.0, 3.0]))


def test_the_method_and_the_map_are_chosen_over_http(world: GatewayWorld) -> None:
    asked: list[Part] = []

    def set_method(request: SetMethod) -> Done:
        asked.append(request)
        return Done(detail="localizing by mcl")

    def set_map(request: SetMap) -> MapLoaded:
        asked.append(request)
        return MapLoaded(map_id="ab12", rows=3, cols=4)

    world.answer("localizer", "set_method", set_method)
    world.answer("localizer", "set_map", set_map)
    answer = world.client.post(f"{ROBOT}/commands/set_method", json={"method": "mcl"})
    assert answer.json() == {"detail": "localizing by mcl"}
    answer = world.client.post(f"{ROBOT}/commands/set_map", json={"map": "ab12"})
    assert answer.json() == {"map_id": "ab12", "rows": 3, "cols": 4}
    assert asked == [SetMethod(method="mcl"), SetMap(map="ab12")]


@pytest.mark.parametrize("body", [{"method": "magic"}, {}, {"method": None}, {"methods": "mcl"}])
def test_a_method_that_nobody_knows_does_not_reach_the_localizer(
    world: GatewayWorld, body: dict[str, object]
) -> None:
    assert world.client.post(f"{ROBOT}/commands/set_method", json=body).status_code == 422


def test_a_refusal_is_a_conflict_with_the_services_reason(world: GatewayWorld) -> None:
    def kidnap(_request: Kidnap) -> Part:
        raise RefusedError("this robot is real")

    world.answer("robot", "kidnap", kidnap)
    answer = world.client.post(f"{ROBOT}/commands/kidnap")
    assert answer.status_code == 409
    assert answer.json()["title"] == "Conflict"
    assert answer.json()["detail"] == "this robot is real"
    assert world.events() == ["kidnap: this robot is real"]


def test_a_service_that_is_not_there_is_unavailable(world: GatewayWorld) -> None:
    answer = world.client.post(f"{ROBOT}/commands/stop")
    assert answer.status_code == 503
    assert answer.json()["detail"] == "robot: the service is not running"


@pytest.mark.parametrize(
    ("error", "status", "detail"),
    [
        (NoAnswerInTimeError("no answer within 2 s"), 504, "robot: no answer within 2 s"),
        (BusError("the bus is closed"), 503, "robot: the bus is closed"),
        (DecodeError("not CBOR"), 502, "the answer of robot cannot be read: not CBOR"),
    ],
)
def test_other_failures_have_their_status(
    world: GatewayWorld,
    monkeypatch: pytest.MonkeyPatch,
    error: Exception,
    status: int,
    detail: str,
) -> None:
    monkeypatch.setattr(world.node, "ask", raising(error))
    answer = world.client.post(f"{ROBOT}/commands/stop")
    assert answer.status_code == status
    assert answer.json()["detail"] == detail


def test_a_bad_body_never_reaches_the_bus(world: GatewayWorld) -> None:
    world.answer("robot", "forward", lambda _request: pytest.fail("it was asked"))
    answer = world.client.post(f"{ROBOT}/commands/forward", json={"distance": "far"})
    assert answer.status_code == 422
    assert answer.json()["detail"].startswith("distance: ")


def test_an_unknown_command_names_the_known_ones(world: GatewayWorld) -> None:
    answer = world.client.post(f"{ROBOT}/commands/dance")
    assert answer.status_code == 404
    assert "forward, backward" in answer.json()["detail"]


def test_commands_for_another_robot_go_nowhere(world: GatewayWorld) -> None:
    world.answer("robot", "stop", lambda _request: pytest.fail("it was asked"))
    assert world.client.post("/api/v1/robots/r2d2/commands/stop").status_code == 404


def test_a_kidnapping_is_an_event(world: GatewayWorld) -> None:
    place = Pose2(x=3.0, y=4.0, theta=0.0)
    world.answer("robot", "kidnap", lambda _request: Kidnapped(pose=place))
    assert world.client.post(f"{ROBOT}/commands/kidnap").json()["pose"]["x"] == 3.0
    assert world.events() == ["The robot was carried to (3.0, 4.0)"]


def test_driving_by_hand_does_not_fill_the_log(world: GatewayWorld) -> None:
    world.answer("robot", "velocity", lambda _request: Done())
    body = {"twist": {"vx": 0.1, "vy": 0, "omega": 0}}
    assert world.client.post(f"{ROBOT}/commands/velocity", json=body).status_code == 200
    assert world.events() == []


class SilentService:
    """Answers nothing until it is let go."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self._go = threading.Event()

    def ask(self, name: str, _request: Part) -> Part:
        self.asked.append(name)
        if name == "stop":
            return Stopped(after=0.0)
        self._go.wait(10.0)
        return Done()

    def let_go(self) -> None:
        self._go.set()


@pytest.fixture
def silent(world: GatewayWorld, monkeypatch: pytest.MonkeyPatch) -> Iterator[SilentService]:
    service = SilentService()
    monkeypatch.setattr(world.node, "ask", service.ask)
    yield service
    service.let_go()


def test_a_robot_that_hangs_can_still_be_told_to_stop(
    world: GatewayWorld, silent: SilentService
) -> None:
    def relocalize() -> int:
        return int(world.client.post(f"{ROBOT}/commands/relocalize").status_code)

    with ThreadPoolExecutor(MAX_WAITING) as callers:
        waiting = [callers.submit(relocalize) for _ in range(MAX_WAITING)]
        eventually(lambda: len(silent.asked) == MAX_WAITING, what="all commands waiting")
        assert relocalize() == 429
        assert world.client.post(f"{ROBOT}/commands/stop").status_code == 200
        silent.let_go()
        assert [caller.result() for caller in waiting] == [200] * MAX_WAITING
        assert relocalize() == 200


def test_who_waits_when_the_gateway_stops_is_told(
    world: GatewayWorld, silent: SilentService
) -> None:
    with ThreadPoolExecutor(1) as caller:
        waiting = caller.submit(world.client.post, f"{ROBOT}/commands/relocalize")
        eventually(lambda: silent.asked, what="the command waiting")
        assert world.client.portal is not None
        world.client.portal.call(world.service.close)
        answer = waiting.result()
    assert answer.status_code == 503
    assert "stopping" in answer.json()["detail"]
    assert world.client.post(f"{ROBOT}/commands/stop").status_code == 503


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_an_example_that_works(name: str) -> None:

    request, reply = EXAMPLES[name]
    query = COMMANDS[name]
    assert isinstance(from_json(query.request, json.dumps(request).encode()), query.request)
    assert to_json(query.reply.model_validate(reply)) == reply


def test_there_are_no_examples_of_other_commands() -> None:
    assert set(EXAMPLES) == set(COMMANDS)
