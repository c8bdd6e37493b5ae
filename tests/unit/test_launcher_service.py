"""The launcher on a fake bus: what it publishes and answers."""

from collections.abc import Iterator

import pytest

from pilotage.bus.clock import HandClock
from pilotage.bus.fabric import RefusedError
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.launcher.process_table import Entry
from pilotage.launcher.service import LauncherService
from pilotage.launcher.supervised import Patience
from pilotage.launcher.supervisor import Supervisor
from pilotage_schemas.commands import Restart
from pilotage_schemas.health import Deployment, Process


class ToyChild:
    """A process that lives until it is asked to end."""

    pid = 4711

    def __init__(self) -> None:
        self.code: int | None = None

    def poll(self) -> int | None:
        return self.code

    def exit_reason(self) -> str:
        return f"ended with code {self.code}"

    def is_stopped(self) -> bool:
        return False

    def ask_to_end(self) -> None:
        self.code = 0

    def kill(self) -> None:
        self.code = -9


GATEWAY = Entry("gateway", "toy", None, after=(), when=lambda _deployment: True)


class Stage:
    """A launcher with one process, and that process's own node."""

    def __init__(self) -> None:
        self.clock, self.fabric = HandClock(), FakeFabric()
        self.seen: list[Process] = []
        self.served = 0
        self.children: list[ToyChild] = []
        supervisor = Supervisor(
            (GATEWAY,), self._start, lambda _name, _text: None, self.clock, Patience(60.0, 2.0)
        )
        self.launcher = Node("launcher", "demo", self.fabric, self.clock)
        self.service = LauncherService(self.launcher, supervisor, self._count)
        self.gateway = Node("gateway", "demo", self.fabric, self.clock)
        self.gateway.subscribe("deployment", self._see)
        self.fabric.pump = self._step_launcher

    def _start(self, _entry: Entry) -> ToyChild:
        self.children.append(ToyChild())
        return self.children[-1]

    def _step_launcher(self) -> None:
        self.launcher.step()

    def _see(self, message: Deployment) -> None:
        self.seen.extend(message.processes)

    def _count(self) -> None:
        self.served += 1

    def pass_time(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.1)):
            self.clock.advance(0.1)
            self.gateway.step()
            self.launcher.step()
            self.gateway.step()

    def states(self) -> list[str]:
        return [process.state for process in self.seen]


@pytest.fixture
def stage() -> Iterator[Stage]:
    stage = Stage()
    yield stage
    stage.fabric.close()


def test_every_change_is_published(stage: Stage) -> None:
    stage.pass_time(0.5)
    stage.gateway.ready()
    stage.pass_time(0.3)
    stage.children[-1].code = 1
    stage.pass_time(0.1)
    assert list(dict.fromkeys(stage.states())) == ["starting", "ready", "down"]


def test_the_state_is_published_once_a_second_all_the_same(stage: Stage) -> None:
    stage.gateway.ready()
    stage.pass_time(1.0)
    stage.seen.clear()
    stage.pass_time(5.0)
    assert len(stage.seen) == 5


def test_the_page_is_shown_once(stage: Stage) -> None:
    stage.pass_time(0.2)
    stage.gateway.ready()
    stage.pass_time(0.3)
    stage.gateway.ask("restart", Restart(service="gateway"))
    stage.pass_time(1.0)
    assert len(stage.children) == 2
    assert stage.served == 1


def test_a_restart_is_answered_and_done(stage: Stage) -> None:
    stage.pass_time(0.2)
    stage.gateway.ask("restart", Restart(service="gateway"))
    stage.pass_time(0.3)
    assert [child.code for child in stage.children] == [0, None]


def test_a_restart_of_the_unknown_is_refused_with_the_known(stage: Stage) -> None:
    with pytest.raises(RefusedError, match=r"no process 'robot' in this run \(it has gateway\)"):
        stage.gateway.ask("restart", Restart(service="robot"))


def test_a_lost_bus_makes_nobody_late(stage: Stage) -> None:
    stage.gateway.ready()
    stage.pass_time(0.3)
    stage.fabric.connected = False
    for _ in range(50):
        stage.clock.advance(0.1)
        stage.launcher.step()
    stage.gateway.step()
    assert set(stage.states()[1:]) == {"ready"}


def test_a_refusal_ends_the_run(stage: Stage) -> None:
    stage.pass_time(0.2)
    stage.children[-1].code = 2
    stage.pass_time(0.2)
    assert stage.service.ending is not None
    assert stage.service.ending.code == 2
