"""The life of a service process, as far as it needs no second process."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import ConfigError
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.bus.runner import (
    LAUNCHER_PID,
    _stop_on_signals,
    complain,
    deployment_of_arguments,
    prepare_process,
    run_node,
)


@pytest.fixture
def own_signals() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def test_a_complaint_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert complain("mapper", "no\n  such\tfile", 2) == 2
    assert capsys.readouterr().err == "pilotage mapper: no such file\n"


def test_without_an_argument_the_deployment_is_the_default(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("sys.argv", ["mapper"])
    assert deployment_of_arguments("mapper").robot == "demo"


def test_the_deployment_is_read_from_the_file(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "a.yaml").write_text("robot: r2", encoding="utf-8")
    monkeypatch.setattr("sys.argv", ["mapper", "--deployment", str(tmp_path / "a.yaml")])
    assert deployment_of_arguments("mapper").robot == "r2"


def test_a_missing_deployment_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("sys.argv", ["mapper", "--deployment", str(tmp_path / "a.yaml")])
    with pytest.raises(ConfigError, match="cannot be read"):
        deployment_of_arguments("mapper")


def test_an_unknown_argument_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["mapper", "--fast"])
    with pytest.raises(SystemExit) as left:
        deployment_of_arguments("mapper")
    assert left.value.code == 2
    assert "unrecognized arguments: --fast" in capsys.readouterr().err


def test_without_a_launcher_a_service_runs_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(LAUNCHER_PID, raising=False)
    prepare_process("mapper")


def test_a_service_whose_launcher_is_gone_does_not_begin(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[tuple[int, int]] = []

    class Libc:
        """Stands for the C library, so that the test does not tie itself to its parent."""

        @staticmethod
        def prctl(option: int, value: int) -> None:
            asked.append((option, value))

    monkeypatch.setattr("ctypes.CDLL", lambda _: Libc)
    monkeypatch.setenv(LAUNCHER_PID, str(os.getppid() + 1))
    with pytest.raises(SystemExit) as left:
        prepare_process("mapper")
    assert left.value.code == 1
    assert "the launcher is gone" in capsys.readouterr().err
    assert asked == [(1, signal.SIGTERM)]


@pytest.mark.usefixtures("own_signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_first_signal_asks_and_the_second_forces(
    monkeypatch: pytest.MonkeyPatch, number: signal.Signals
) -> None:
    forced: list[int] = []
    monkeypatch.setattr("os._exit", forced.append)
    node = Node("mapper", "demo", FakeFabric(), HandClock())
    _stop_on_signals(node)
    signal.raise_signal(number)
    assert node.is_stopping
    assert not forced
    signal.raise_signal(signal.SIGTERM)
    assert forced == [128 + signal.SIGTERM]


def test_a_service_is_ready_before_its_loop_begins() -> None:
    fabric = FakeFabric()
    present: list[str] = []
    fabric.watch_presence("*", lambda key, _: present.append(key))
    node = Node("mapper", "demo", fabric, HandClock())
    node.stop()
    run_node(node, object())
    assert present == ["pilotage/@v1/demo/@alive/mapper"]
