"""Children and their guard, with real processes of the shell."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import pytest

from pilotage.launcher.child import Child
from pilotage.launcher.guarding import Guarding
from pilotage.launcher.stop_signals import StopSignals
from runs import lives
from waiting import eventually


class Shell:
    """Children that run a line of shell; none outlives the test."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._children: list[Child] = []

    def run(self, line: str) -> Child:
        command = ["/bin/sh", "-c", line]
        self._children.append(Child("toy", command, dict(os.environ), self.lines.append))
        return self._children[-1]

    def ended(self, line: str) -> Child:
        child = self.run(line)
        eventually(lambda: child.poll() is not None, what="the end of the child")
        return child

    def close(self) -> None:
        for child in self._children:
            child.kill()


@pytest.fixture
def shell() -> Iterator[Shell]:
    with contextlib.closing(Shell()) as shell:
        yield shell


def test_each_line_of_a_child_is_passed_on(shell: Shell) -> None:
    shell.ended("echo one; echo two >&2").exit_reason()
    assert sorted(shell.lines) == ["one", "two"]


def test_a_failure_is_told_with_its_last_words(shell: Shell) -> None:
    child = shell.ended("echo begin; echo the end is near >&2; exit 3")
    assert child.exit_reason() == "ended with code 3: the end is near"


def test_a_complaint_is_told_once(shell: Shell) -> None:
    child = shell.ended("echo 'pilotage toy: no such map' >&2; exit 2")
    assert child.exit_reason() == "ended with code 2: no such map"
    assert shell.lines == []


def test_a_killed_child_says_which_signal_it_was(shell: Shell) -> None:
    assert shell.ended("kill -9 $$").exit_reason() == "killed by SIGKILL"


def test_bytes_that_are_no_text_disturb_nothing(shell: Shell) -> None:
    shell.ended(r"printf '\377\376\n'").exit_reason()
    assert shell.lines == ["\ufffd\ufffd"]


def test_a_held_child_is_seen_as_such(shell: Shell) -> None:
    child = shell.run("exec sleep 60")
    assert not child.is_stopped()
    os.kill(child.pid, signal.SIGSTOP)
    eventually(child.is_stopped, what="the child held")


def test_a_held_child_ends_when_it_is_asked_to(shell: Shell) -> None:
    child = shell.run("exec sleep 60")
    os.kill(child.pid, signal.SIGSTOP)
    eventually(child.is_stopped, what="the child held")
    child.ask_to_end()
    eventually(lambda: child.poll() is not None, what="the end of the child")


def test_a_kill_takes_what_the_child_has_started(shell: Shell) -> None:
    child = shell.run("sleep 60 & echo $!; wait")
    grandchild = int(eventually(lambda: shell.lines, what="the grandchild's pid")[0])
    child.kill()
    eventually(lambda: not lives(grandchild), what="the grandchild's end")


def test_a_child_that_has_ended_can_be_asked_and_killed(shell: Shell) -> None:
    child = shell.ended("true")
    child.ask_to_end()
    child.kill()
    assert not child.is_stopped()


def test_a_child_reads_nothing_from_the_terminal(shell: Shell) -> None:
    assert shell.ended("read line || echo nothing").exit_reason() == "ended with code 0"
    assert shell.lines == ["nothing"]


def test_the_guard_ends_what_does_not_listen(shell: Shell) -> None:
    deaf = shell.run("trap '' TERM HUP; sleep 60 & wait; sleep 60")
    with Guarding() as guard:
        guard.watch(deaf.pid)
    assert deaf.poll() == -signal.SIGKILL


def test_the_guard_has_nothing_to_wait_for_when_all_have_ended(shell: Shell) -> None:
    began = time.monotonic()
    with Guarding() as guard:
        guard.watch(shell.ended("true").pid)
    assert time.monotonic() - began < 1.9


def test_a_lost_guard_disturbs_nobody(shell: Shell) -> None:
    with Guarding() as guard:
        guard._process.kill()
        guard._process.wait()
        guard.watch(shell.run("exec sleep 60").pid)


def test_the_first_signal_asks() -> None:
    with StopSignals(force=lambda: pytest.fail("forced")) as stop:
        asked = threading.Event()
        stop.on_ask = asked.set
        os.kill(os.getpid(), signal.SIGTERM)
        eventually(asked.is_set, what="the request to stop")
        assert stop.asked


def test_the_second_signal_forces() -> None:
    program = """
import os, signal
from pilotage.launcher.stop_signals import StopSignals
with StopSignals(lambda: print("forced", flush=True)):
    os.kill(os.getpid(), signal.SIGINT)
    os.kill(os.getpid(), signal.SIGINT)
    print("never")
"""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert (done.stdout, done.returncode) == ("forced\n", 128 + signal.SIGINT)


def test_former_handlers_come_back() -> None:
    former = signal.getsignal(signal.SIGTERM)
    with StopSignals(force=lambda: None):
        assert signal.getsignal(signal.SIGTERM) != former
    assert signal.getsignal(signal.SIGTERM) == former
