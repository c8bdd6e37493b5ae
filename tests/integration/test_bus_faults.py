"""Killed services, killed routers, hung readers: what the others notice and do."""

import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from pilotage.bus.clock import SystemClock
from pilotage.bus.fabric import BusError, NoAnswerError
from pilotage.bus.node import Node
from pilotage.bus.session import open_fabric
from pilotage_schemas.commands import Drive, LoadMap, MapLoaded
from pilotage_schemas.mapping import OccupancyGrid
from pilotage_schemas.sensors import Odometry
from processes import RouterProcess
from sample_messages import odometry
from small_services import started
from waiting import eventually


class Fleet:
    """A router of its own, and small services as real processes."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.router = stack.enter_context(RouterProcess(folder))
        self._stack = stack

    def service(self, name: str) -> subprocess.Popen[str]:
        process = started(name, self.router.deployment)
        self._stack.callback(process.communicate)
        self._stack.callback(process.kill)
        return process

    def node(self, name: str) -> Node:
        fabric = self._stack.enter_context(open_fabric(self.router.endpoint))
        return Node(name, "demo", fabric, SystemClock())


@pytest.fixture
def fleet(tmp_path: Path) -> Iterator[Fleet]:
    with ExitStack() as stack:
        yield Fleet(tmp_path, stack)


def eventually_stepped(node: Node, condition: Callable[[], object], within: float = 10.0) -> None:
    def stepped() -> object:
        node.step()
        return condition()

    eventually(stepped, within)


def watched(node: Node) -> dict[str, bool]:
    """What the node knows of who is present, kept up to date by its steps."""
    present: dict[str, bool] = {}
    node.watch_presence(lambda service, is_present: present.update({service: is_present}))
    return present


def listened(node: Node) -> list[Odometry]:
    got: list[Odometry] = []
    node.subscribe("odometry", got.append)
    return got


@pytest.mark.system
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_service_that_ends_is_noticed_within_a_second(
    fleet: Fleet, number: signal.Signals
) -> None:
    gateway = fleet.node("gateway")
    present = watched(gateway)
    robot = fleet.service("robot")
    eventually_stepped(gateway, lambda: present.get("robot"))
    robot.send_signal(number)
    eventually_stepped(gateway, lambda: not present["robot"], within=1.0)


@pytest.mark.system
def test_a_service_that_hangs_is_noticed_and_comes_back(fleet: Fleet) -> None:
    gateway = fleet.node("gateway")
    present = watched(gateway)
    robot = fleet.service("robot")
    eventually_stepped(gateway, lambda: present.get("robot"))
    robot.send_signal(signal.SIGSTOP)
    eventually_stepped(gateway, lambda: not present["robot"], within=2.0)
    robot.send_signal(signal.SIGCONT)
    eventually_stepped(gateway, lambda: present["robot"])


@pytest.mark.system
def test_a_restarted_service_is_heard_again(fleet: Fleet) -> None:
    gateway = fleet.node("gateway")
    got = listened(gateway)
    first = fleet.service("robot")
    eventually_stepped(gateway, lambda: len(got) > 3)
    first.kill()
    first.wait()
    before = len(got)
    fleet.service("robot")
    eventually_stepped(gateway, lambda: len(got) > before + 3)


@pytest.mark.system
def test_a_hung_reader_does_not_stall_its_neighbour(fleet: Fleet) -> None:
    gateway, robot = fleet.node("gateway"), fleet.node("robot")
    present, got = watched(gateway), listened(gateway)
    hung = fleet.service("mapper")
    eventually_stepped(gateway, lambda: present.get("mapper"))
    hung.send_signal(signal.SIGSTOP)
    publisher = robot.publisher("odometry")

    def thousand_came() -> bool:
        for _ in range(10):
            publisher.publish(odometry(robot.clock.now_ns()))
            gateway.step()
        return len(got) > 1000

    eventually(thousand_came, within=10.0)
    hung.send_signal(signal.SIGCONT)


@pytest.mark.system
def test_everything_reconnects_when_the_router_comes_back(fleet: Fleet) -> None:
    gateway = fleet.node("gateway")
    present, got = watched(gateway), listened(gateway)
    maps: list[OccupancyGrid] = []
    gateway.subscribe("map", maps.append)
    robot, mapper = fleet.service("robot"), fleet.service("mapper")
    eventually_stepped(gateway, lambda: got and maps and all(map(present.get, ("robot", "mapper"))))

    fleet.router.kill()
    eventually_stepped(gateway, lambda: not gateway.fabric.is_connected(), within=3.0)
    assert (robot.poll(), mapper.poll()) == (None, None)
    with pytest.raises(NoAnswerError):
        gateway.ask("forward", Drive(distance=1.0))

    fleet.router.start()
    eventually_stepped(gateway, gateway.fabric.is_connected, within=5.0)
    before = len(got)
    eventually_stepped(gateway, lambda: len(got) > before + 3, within=5.0)
    eventually_stepped(gateway, lambda: present["robot"] and present["mapper"], within=5.0)
    assert gateway.ask("load_map", LoadMap(path="5")) == MapLoaded(map_id="0123", rows=5, cols=2)
    eventually_stepped(gateway, lambda: len(maps[-1].cells) == 5, within=5.0)
    assert (robot.poll(), mapper.poll()) == (None, None)


@pytest.mark.system
def test_a_service_waits_for_a_router_that_comes_later(fleet: Fleet) -> None:
    fleet.router.kill()
    robot = fleet.service("robot")
    fleet.router.start()
    gateway = fleet.node("gateway")
    got = listened(gateway)
    eventually_stepped(gateway, lambda: len(got) > 3, within=15.0)
    assert robot.poll() is None


@pytest.mark.system
def test_a_service_leaves_gracefully_when_asked(fleet: Fleet) -> None:
    gateway = fleet.node("gateway")
    present = watched(gateway)
    robot = fleet.service("robot")
    eventually_stepped(gateway, lambda: present.get("robot"))
    robot.terminate()
    assert robot.wait(timeout=5.0) == 0


@pytest.mark.system
def test_the_router_leaves_gracefully_when_asked(fleet: Fleet) -> None:
    assert fleet.router.kill(signal.SIGTERM) == 0


@pytest.mark.system
def test_a_service_with_bad_settings_says_so_and_exits_with_2(tmp_path: Path) -> None:
    bad = tmp_path / "bad.yaml"
    bad.write_text("services: {robot: {rate_khz: 1}}", encoding="utf-8")
    process = started("robot", bad)
    _, complaint = process.communicate(timeout=20.0)
    assert process.returncode == 2
    assert complaint.strip().splitlines() == [
        "pilotage robot: settings of robot: rate_khz: Extra inputs are not permitted"
    ]


def test_a_router_that_is_not_there_is_an_error_in_words(
    free_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pilotage.bus.session.CONNECT_TIMEOUT_MS", 300)
    endpoint = f"tcp/127.0.0.1:{free_port}"
    with pytest.raises(BusError, match=f"no router answers at {endpoint}"), open_fabric(endpoint):
        pass


@pytest.mark.system
def test_a_second_router_on_the_same_port_says_so_and_exits_with_1(fleet: Fleet) -> None:
    process = subprocess.run(
        fleet.router.command, capture_output=True, text=True, timeout=20.0, check=False
    )
    assert process.returncode == 1
    assert f"pilotage router: cannot listen at {fleet.router.endpoint}" in process.stderr
