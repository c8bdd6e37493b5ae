"""Which driver the settings name, and what is said when it cannot be had."""

import sys
from pathlib import Path

import pytest

from pilotage.bus.deployment import ConfigError, Deployment, service_settings
from pilotage.robot.config import RobotSettings
from pilotage.robot.driver_choice import load_driver, make_driver
from pilotage.robot.replay import Replay
from pilotage.robot.service import RobotService, live
from pilotage.robot.simulator.simulator import Simulator
from robot_world import ToyRobot, toy_bench

LOG = """\
ODOM 0.0 0.0 0.0 0.1 0.0 0.0 1.0 host 1.0
FLASER 3 1.0 2.0 3.0 0.0 0.0 0.0 0.0 0.0 0.0 1.1 host 1.1
ODOM 0.1 0.0 0.0 0.1 0.0 0.0 2.0 host 2.0
"""


def settings_of(folder: Path, **section: object) -> RobotSettings:
    deployment = Deployment(services={"robot": section}, base=folder)
    return service_settings(deployment, "robot", RobotSettings)


def test_a_simulator_needs_a_world() -> None:
    with pytest.raises(ConfigError, match="the simulator needs a world"):
        make_driver(RobotSettings())


def test_a_world_beside_the_deployment_file_is_found(repository: Path) -> None:
    settings = settings_of(repository / "deploy" / "config", world="../worlds/hall.yaml")
    assert isinstance(make_driver(settings), Simulator)


def test_a_log_is_replayed(tmp_path: Path) -> None:
    (tmp_path / "run.clf").write_text(LOG, encoding="utf-8")
    driver = make_driver(settings_of(tmp_path, driver="replay", log="run.clf", speed=2.0))
    assert isinstance(driver, Replay)
    assert driver.speed_factor == 2.0


def test_a_replay_needs_a_log_that_exists(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="replay needs a log"):
        make_driver(RobotSettings(driver="replay"))
    with pytest.raises(ConfigError, match=r"gone\.clf: the log does not exist"):
        make_driver(settings_of(tmp_path, driver="replay", log="gone.clf"))


def test_a_robot_of_ones_own_gets_its_settings() -> None:
    driver = load_driver("robot_world:ToyRobot", {"max_linear": 0.7})
    assert isinstance(driver, ToyRobot)
    assert driver.max_linear == 0.7


@pytest.mark.parametrize(
    ("spec", "settings", "reason"),
    [
        ("no_such_package.robot:Robot", {}, "No module named 'no_such_package'"),
        ("robot_world:Robott", {}, "robot_world has no Robott"),
        ("robot_world:ToyRobot", {"port": 3}, "unexpected keyword argument 'port'"),
    ],
)
def test_a_driver_that_cannot_be_made_is_named_with_the_reason(
    spec: str, settings: dict[str, object], reason: str
) -> None:
    with pytest.raises(ConfigError, match=reason) as refused:
        load_driver(spec, settings)
    assert spec in str(refused.value)


FOREIGN = {
    "unfinished": ("def f(:", "foreign cannot be imported: SyntaxError: "),
    "failing": ("raise RuntimeError('no licence')", "imported: RuntimeError: no licence"),
    "leaving": ("raise SystemExit('bye')", "imported: SystemExit: bye"),
    "missing a part": ("import no_such_part", "No module named 'no_such_part'"),
    "no class": ("Robot = {}", "cannot be made: TypeError: 'dict' object is not callable"),
    "broken": (
        "class Robot:\n    def __init__(self): self.port.open()",
        "cannot be made: AttributeError: 'Robot' object has no attribute 'port'",
    ),
    "giving up": (
        "import pilotage.robot.driver as d\ndef Robot(): raise d.DriverError('no port')",
        "driver foreign:Robot: no port",
    ),
    "empty": (
        "class Robot: pass",
        "is no driver: it has no __enter__, __exit__, describe, sense, drive, stop",
    ),
}


@pytest.mark.parametrize("fault", FOREIGN)
def test_whatever_a_foreign_driver_raises_is_named_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: str
) -> None:
    source, reason = FOREIGN[fault]
    (tmp_path / "foreign.py").write_text(source, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "foreign", raising=False)
    with pytest.raises(ConfigError) as refused:
        load_driver("foreign:Robot", {})
    assert reason in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_driver_that_does_not_open_ends_the_service_with_one_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    bench, robot = toy_bench()
    robot.broken = "no device at /dev/ttyUSB0"
    with pytest.raises(SystemExit) as ended:
        live(bench.node, bench.service)
    assert ended.value.code == 1
    assert capsys.readouterr().err == "pilotage robot: no device at /dev/ttyUSB0\n"


def test_a_driver_is_closed_when_the_service_ends() -> None:
    bench, robot = toy_bench()
    bench.node.stop()
    live(bench.node, bench.service)
    assert not robot.is_open


def test_a_replayed_log_reports_its_progress_on_the_bus(tmp_path: Path) -> None:
    (tmp_path / "run.clf").write_text(LOG, encoding="utf-8")
    bench, _ = toy_bench()
    settings = settings_of(tmp_path, driver="replay", log="run.clf")
    service = RobotService(settings, bench.node, Deployment())
    heard = bench.listen("status")
    service.begin()
    bench.advance(2.0)
    status = heard[-1]
    assert (status.source, status.mode, status.progress) == ("replay", "finished", 1.0)
    assert status.reason == "run.clf: the log has ended"
