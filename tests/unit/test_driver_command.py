"""`pilotage driver check` tells in one line each what a driver breaks."""

from pathlib import Path

import pytest

from pilotage import driver_command
from pilotage.bus.clock import HandClock
from pilotage.cli import run


@pytest.fixture(autouse=True)
def _time_turned_by_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = HandClock()
    monkeypatch.setattr(driver_command, "SystemClock", lambda: clock)
    monkeypatch.setattr("pilotage.driver_command.time.sleep", clock.advance)


def test_the_demo_robot_keeps_every_promise(
    repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = str(repository / "deploy" / "config" / "demo.yaml")
    assert run(["driver", "check", spec]) == 0
    assert capsys.readouterr().out == f"{spec}: nothing to mend\n"


def test_a_driver_with_faults_is_found_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "silent_driver.py").write_text(SILENT, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    assert run(["driver", "check", "silent_driver:Silent"]) == 1
    *findings, total = capsys.readouterr().out.splitlines()
    assert any("odometry" in line for line in findings)
    assert total == f"silent_driver:Silent: {len(findings)} to mend"


def test_a_driver_that_fails_in_the_middle_is_a_finding_and_no_traceback(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    faulty = SILENT.replace("return ()", "return self.port.read()").replace("Silent", "Faulty")
    (tmp_path / "faulty_driver.py").write_text(faulty, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    assert run(["driver", "check", "faulty_driver:Faulty"]) == 1
    assert capsys.readouterr().out.splitlines() == [
        "sense: raised AttributeError: 'Faulty' object has no attribute 'port'",
        "faulty_driver:Faulty: 1 to mend",
    ]


@pytest.mark.parametrize(
    "spec", ["no_such_module:Robot", "pilotage:Robot", "no_such_file.yaml", "pilotage:__version__"]
)
def test_a_driver_that_cannot_be_had_is_told_in_one_line(
    spec: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["driver", "check", spec]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("spec", ["", "  "])
def test_a_driver_that_is_not_named_is_asked_for(
    spec: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["driver", "check", spec]) == 2
    assert "takes package.module:Class or a deployment file" in capsys.readouterr().err


def test_driver_alone_says_what_it_can_do(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["driver"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["Usage:", "pilotage", "driver", "[OPTIONS]", "COMMAND", "[ARGS]..."]
    assert any(line.strip().startswith("check ") for line in lines)


SILENT = '''
"""A robot that describes itself and then says nothing."""

import numpy as np

from pilotage_schemas.sensors import RobotDescription


class Silent:
    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def describe(self):
        return RobotDescription(
            stamp_ns=0,
            frame_id="base_link",
            name="Silent",
            driver="silent",
            footprint=np.array([[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1]], np.float32),
            mounts=(),
            max_linear=0.5,
            max_angular=1.0,
            commands=("stop",),
        )

    def sense(self, now_ns):
        return ()

    def drive(self, twist):
        pass

    def stop(self):
        pass
'''
