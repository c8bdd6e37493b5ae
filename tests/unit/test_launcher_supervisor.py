"""All processes together: order, the router's loss, the end of a run."""

from dataclasses import dataclass

import pytest

from pilotage.bus.clock import HandClock
from pilotage.launcher.process_table import Entry
from pilotage.launcher.supervised import Patience
from pilotage.launcher.supervisor import Supervisor
from pilotage_schemas.health import Heartbeat, Process


@dataclass
class ToyChild:
    """A process as the test wants it."""

    pid: int
    code: int | None = None
    held: bool = False

    def poll(self) -> int | None:
        return self.code

    def exit_reason(self) -> str:
        return f"ended with code {self.code}"

    def is_stopped(self) -> bool:
        return self.held

    def ask_to_end(self) -> None:
        self.code = 0

    def kill(self) -> None:
        self.code = -9


def entry(name: str, *after: str) -> Entry:
    router = name == "router"
    return Entry(
        name,
        f"pilotage.{name}",
        settings=None,
        after=after,
        when=lambda _deployment: True,
        sends_beats=not router,
        is_critical=router,
    )


class Stage:
    """A router, two services, and a bus that is up or not."""

    def __init__(self) -> None:
        self.clock = HandClock()
        self.order: list[str] = []
        self.children: dict[str, ToyChild] = {}
        self.silent: set[str] = set()
        self.bus_is_up = True
        entries = (entry("router"), entry("mapper", "router"), entry("robot", "router"))
        self.supervisor = Supervisor(
            entries, self._start, lambda _name, _text: None, self.clock, Patience(60.0, 2.0)
        )

    def _start(self, entry: Entry) -> ToyChild:
        self.order.append(entry.name)
        self.children[entry.name] = ToyChild(len(self.order))
        return self.children[entry.name]

    def pass_time(self, seconds: float, step: float = 0.1) -> None:
        for _ in range(round(seconds / step)):
            self.clock.advance(step)
            for name, child in self.children.items():
                if name != "router" and self._can_be_heard(name, child):
                    self._beat(name)
            self.supervisor.tick(bus_is_up=self.bus_is_up)

    def _can_be_heard(self, name: str, child: ToyChild) -> bool:
        return self.bus_is_up and name not in self.silent and child.code is None

    def _beat(self, service: str) -> None:
        stamp = self.clock.now_ns()
        self.supervisor.heard(
            Heartbeat(stamp_ns=stamp, frame_id="", service=service, state="ready", within=1.0)
        )

    def process(self, name: str) -> Process:
        return next(one for one in self.supervisor.report() if one.name == name)

    def states(self) -> dict[str, str]:
        return {one.name: one.state for one in self.supervisor.report()}


@pytest.fixture
def stage() -> Stage:
    stage = Stage()
    stage.pass_time(1.0)
    return stage


def test_the_router_is_ready_before_any_service_starts() -> None:
    stage = Stage()
    stage.bus_is_up = False
    stage.pass_time(0.5)
    assert stage.order == ["router"]
    stage.bus_is_up = True
    stage.pass_time(0.3)
    assert stage.order == ["router", "mapper", "robot"]


def test_every_process_becomes_ready(stage: Stage) -> None:
    assert stage.states() == {"router": "ready", "mapper": "ready", "robot": "ready"}


def test_the_loss_of_the_router_is_not_the_death_of_all_services(stage: Stage) -> None:
    stage.children["router"].code = -9
    stage.bus_is_up = False
    stage.pass_time(8.0)
    assert stage.states()["mapper"] == "ready"
    assert stage.process("mapper").restarts == 0
    assert stage.process("router").restarts >= 1


def test_services_have_time_to_come_back_after_the_router(stage: Stage) -> None:
    stage.bus_is_up = False
    stage.pass_time(2.0)
    stage.bus_is_up = True
    stage.silent = {"mapper", "robot"}
    stage.pass_time(2.5)
    assert stage.states()["mapper"] == "ready"
    stage.pass_time(1.0)
    assert stage.states()["mapper"] == "late"


def test_a_held_router_makes_no_service_late(stage: Stage) -> None:
    stage.children["router"].held = True
    stage.silent = {"mapper", "robot"}
    stage.pass_time(1.5)
    assert stage.process("mapper").restarts == 0
    assert stage.order.count("router") == 2


def test_one_hung_service_is_restarted_alone(stage: Stage) -> None:
    stage.silent = {"robot"}
    stage.pass_time(3.5)
    assert stage.process("robot").restarts == 1
    assert stage.process("mapper").restarts == 0


def test_a_stall_of_the_launcher_itself_makes_nobody_late(stage: Stage) -> None:
    stage.clock.advance(20.0)
    stage.supervisor.tick(bus_is_up=True)
    assert stage.states() == {"router": "ready", "mapper": "ready", "robot": "ready"}


def test_refused_settings_end_the_run_with_code_two() -> None:
    stage = Stage()
    stage.silent = {"mapper", "robot"}
    stage.pass_time(0.3)
    stage.children["mapper"].code = 2
    stage.pass_time(0.2)
    ending = stage.supervisor.ending()
    assert ending is not None
    assert ending.code == 2
    assert ending.reason == "mapper ended with code 2"


def test_a_router_given_up_ends_the_run(stage: Stage) -> None:
    for _ in range(200):
        stage.children["router"].code = 1
        stage.bus_is_up = False
        stage.pass_time(0.1)
    ending = stage.supervisor.ending()
    assert ending is not None
    assert ending.code == 1
    assert "router is given up" in ending.reason


def test_the_run_goes_on_without_one_service(stage: Stage) -> None:
    for _ in range(200):
        stage.children["mapper"].code = 1
        stage.pass_time(0.1)
    assert stage.states()["mapper"] == "given_up"
    assert stage.supervisor.ending() is None


def test_the_run_ends_when_no_service_is_left(stage: Stage) -> None:
    for _ in range(200):
        stage.children["mapper"].code = stage.children["robot"].code = 1
        stage.pass_time(0.1)
    ending = stage.supervisor.ending()
    assert ending is not None
    assert ending.reason == "every service is given up"


def test_a_beat_of_an_unknown_service_is_nobody_s(stage: Stage) -> None:
    stage._beat("stranger")
    assert "stranger" not in stage.states()


def test_a_change_is_told_once(stage: Stage) -> None:
    stage.pass_time(0.5)
    stage._beat("mapper")
    assert not stage.supervisor.tick(bus_is_up=True)
    stage.children["robot"].code = 1
    assert stage.supervisor.tick(bus_is_up=True)
    assert not stage.supervisor.tick(bus_is_up=True)


def test_stopping_asks_everyone_and_starts_nobody(stage: Stage) -> None:
    stage.supervisor.stop(within=1.0)
    assert [child.code for child in stage.children.values()] == [0, 0, 0]
    started = len(stage.order)
    stage.pass_time(5.0)
    assert len(stage.order) == started
    assert set(stage.states().values()) == {"stopped"}
