"""One process of the table, with a clock turned by hand and a child that obeys the test."""

from dataclasses import dataclass, field

import pytest

from pilotage.bus.clock import HandClock
from pilotage.launcher.process_table import Entry
from pilotage.launcher.supervised import Patience, Supervised
from pilotage_schemas.health import Heartbeat


@dataclass
class ToyChild:
    """A process as the test wants it."""

    pid: int = 4711
    code: int | None = None
    held: bool = False
    asked: int = 0
    obeys: bool = True
    last_words: str = ""
    killed: bool = field(default=False)

    def poll(self) -> int | None:
        return self.code

    def exit_reason(self) -> str:
        return self.last_words or f"ended with code {self.code}"

    def is_stopped(self) -> bool:
        return self.held

    def ask_to_end(self) -> None:
        self.asked += 1
        if self.obeys:
            self.code = 0

    def kill(self) -> None:
        self.killed = True
        self.code = -9


ENTRY = Entry("worker", "pilotage.worker", None, after=(), when=lambda _deployment: True)


class Stage:
    """A supervised process, its children, its clock, and what was announced."""

    def __init__(self) -> None:
        self.clock = HandClock()
        self.children: list[ToyChild] = []
        self.said: list[str] = []
        self.cannot_start = False
        self.one = Supervised(
            ENTRY, self._start, self.said.append, self.clock, Patience(60.0, hang_grace=2.0)
        )

    def _start(self, _entry: Entry) -> ToyChild:
        if self.cannot_start:
            raise OSError("no memory")
        self.children.append(ToyChild(pid=len(self.children) + 1))
        return self.children[-1]

    @property
    def child(self) -> ToyChild:
        return self.children[-1]

    def state(self) -> str:
        return self.one.state

    def pass_time(self, seconds: float = 0.1, *, beats: bool = False) -> None:
        """Tick ten times a second."""
        for _ in range(round(seconds / 0.1)):
            self.clock.advance(0.1)
            if beats:
                self.hear()
            self.one.tick(may_start=True)

    def hear(self, state: str = "ready", within: float = 1.0, age: float = 0.0) -> None:
        stamp = self.clock.now_ns() - round(age * 1e9)
        message = {"state": state, "within": within, "service": "worker"}
        self.one.heard(Heartbeat.model_validate(message | {"stamp_ns": stamp, "frame_id": ""}))

    def until_ready(self) -> None:
        self.pass_time(0.1)
        self.hear()
        self.pass_time(0.1)
        assert self.state() == "ready"


@pytest.fixture
def stage() -> Stage:
    return Stage()


def test_it_waits_for_what_must_be_ready_before_it(stage: Stage) -> None:
    stage.one.tick(may_start=False)
    assert stage.children == []
    stage.one.tick(may_start=True)
    assert len(stage.children) == 1


def test_it_is_ready_when_it_says_so(stage: Stage) -> None:
    stage.pass_time(0.5)
    stage.hear("starting", 60.0)
    stage.pass_time(0.5)
    assert stage.state() == "starting"
    stage.hear()
    stage.pass_time()
    assert stage.state() == "ready"
    assert any("ready after" in line for line in stage.said)


def test_a_beat_of_its_former_life_does_not_count(stage: Stage) -> None:
    stage.pass_time(0.5)
    stage.hear(age=2.0)
    stage.pass_time()
    assert stage.state() == "starting"


def test_a_crash_is_noticed_at_once_and_mended_after_the_wait(stage: Stage) -> None:
    stage.until_ready()
    stage.child.code = -9
    stage.child.last_words = "killed by SIGKILL"
    stage.pass_time()
    assert stage.state() == "down"
    assert stage.one.reason == "killed by SIGKILL"
    assert stage.one.report().pid is None
    stage.pass_time(0.3)
    assert len(stage.children) == 2
    assert stage.one.report().restarts == 1


def test_silence_is_late_first_and_ends_it_later(stage: Stage) -> None:
    stage.until_ready()
    stage.pass_time(1.1)
    report = stage.one.report()
    assert report.state == "late"
    assert report.late_for == pytest.approx(1.2)
    assert report.limit == 1.0
    assert not stage.child.killed
    stage.pass_time(2.0)
    assert stage.children[0].killed
    assert "no heartbeat for 3" in stage.one.reason


def test_a_late_process_recovers_without_a_restart(stage: Stage) -> None:
    stage.until_ready()
    stage.pass_time(1.5)
    assert stage.state() == "late"
    stage.pass_time(0.1, beats=True)
    assert stage.state() == "ready"
    assert stage.one.restarts == 0
    assert "ready again" in stage.said[-1]


def test_a_process_that_a_signal_holds_is_hung_within_a_second(stage: Stage) -> None:
    stage.until_ready()
    stage.child.held = True
    stage.pass_time(1.0)
    assert stage.children[0].killed
    assert any("held by a signal for 0." in line for line in stage.said)


def test_a_process_that_is_throttled_by_signals_is_left_alone(stage: Stage) -> None:
    stage.until_ready()
    for turn in range(40):
        stage.child.held = turn % 2 == 0
        stage.pass_time(0.1, beats=True)
    assert not stage.child.killed


def test_a_held_process_is_noticed_while_it_still_starts(stage: Stage) -> None:
    stage.pass_time(0.2)
    stage.child.held = True
    stage.pass_time(1.0)
    assert stage.children[0].killed


def test_an_excused_silence_is_not_late(stage: Stage) -> None:
    stage.until_ready()
    stage.one.excuse(stage.clock.monotonic() + 5.0)
    stage.pass_time(4.9)
    assert stage.state() == "ready"


def test_five_failures_in_a_minute_and_it_is_given_up_loudly(stage: Stage) -> None:
    for _ in range(100):
        stage.pass_time(0.1)
        stage.child.code = 1
    assert stage.state() == "given_up"
    assert len(stage.children) == 5
    assert "GIVEN UP" in stage.said[-1]
    report = stage.one.report()
    assert (report.try_number, report.max_tries) == (5, 5)


def test_a_given_up_process_starts_again_when_asked(stage: Stage) -> None:
    for _ in range(100):
        stage.pass_time(0.1)
        stage.child.code = 1
    stage.one.restart()
    stage.until_ready()
    assert stage.one.report().try_number == 0


def test_a_restart_that_was_asked_for_is_no_failure(stage: Stage) -> None:
    stage.until_ready()
    stage.one.restart()
    stage.pass_time(0.2)
    assert stage.children[0].asked == 1
    assert not stage.children[0].killed
    assert len(stage.children) == 2
    report = stage.one.report()
    assert (report.restarts, report.try_number) == (1, 0)


def test_a_process_that_does_not_end_when_asked_is_ended(stage: Stage) -> None:
    stage.until_ready()
    stage.child.obeys = False
    stage.one.restart()
    stage.pass_time(1.5)
    assert len(stage.children) == 1
    stage.pass_time(1.0)
    assert stage.children[0].killed
    assert len(stage.children) == 2


def test_refused_settings_are_told_apart_from_a_crash(stage: Stage) -> None:
    stage.pass_time(0.1)
    stage.child.code = 2
    stage.child.last_words = "ended with code 2: no such map"
    stage.pass_time(0.1)
    assert stage.one.refusal == "ended with code 2: no such map"


def test_refused_settings_of_a_later_start_are_a_failure_like_others(stage: Stage) -> None:
    stage.until_ready()
    stage.child.code = 2
    stage.pass_time(0.1)
    assert stage.one.refusal is None
    assert stage.state() == "down"


def test_a_process_that_cannot_be_started_is_a_failure(stage: Stage) -> None:
    stage.cannot_start = True
    stage.pass_time(0.1)
    assert stage.state() == "down"
    assert "cannot be started: no memory" in stage.one.reason


def test_a_process_put_down_stays_down(stage: Stage) -> None:
    stage.until_ready()
    stage.one.put_down()
    assert stage.one.report().state == "stopped"


def test_the_time_of_the_last_change_is_reported(stage: Stage) -> None:
    stage.until_ready()
    changed = stage.one.report().since_ns
    stage.pass_time(5.0, beats=True)
    assert stage.one.report().since_ns == changed
    stage.child.code = 1
    stage.pass_time(0.1)
    assert stage.one.report().since_ns > changed
