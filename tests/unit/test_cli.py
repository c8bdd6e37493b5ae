"""The command line: one line and code 2 for what cannot be used."""

import errno
import socket
from pathlib import Path

import pytest

from pilotage import __version__, cli
from pilotage.launcher import run as launcher_run
from pilotage.launcher.effective import Overrides


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run a command that must be refused; return its one line."""
    assert cli.run(list(arguments)) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    return said.err.strip()


def deployment(folder: Path, text: str) -> str:
    path = folder / "deployment.yaml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["--version"]) == 0
    assert capsys.readouterr().out == f"pilotage {__version__}\n"


def test_without_a_command_the_commands_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run([]) == 0
    assert "up " in capsys.readouterr().out


def test_each_command_explains_itself(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["up", "--help"]) == 0
    assert "--no-browser" in capsys.readouterr().out


def test_unknown_options_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert "--nope" in complaint(capsys, "up", "--nope")
    assert "--nope" in complaint(capsys, "--nope")


def test_unknown_commands_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert "'fly'" in complaint(capsys, "fly")


@pytest.mark.parametrize("port", ["x", "0", "65536", "-1"])
def test_a_port_that_is_none_is_refused(capsys: pytest.CaptureFixture[str], port: str) -> None:
    assert "--port" in complaint(capsys, "up", "--port", port)


def test_a_missing_deployment_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    said = complaint(capsys, "up", "/no/such/file.yaml")
    assert said == "pilotage: /no/such/file.yaml: cannot be read: No such file or directory"


def test_a_folder_is_no_deployment(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert "Is a directory" in complaint(capsys, "up", str(tmp_path))


@pytest.mark.parametrize("text", ["services: {mapper: ", "\t- x", "services: [", "a: b: c"])
def test_unreadable_yaml_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str
) -> None:
    assert "not valid YAML" in complaint(capsys, "up", deployment(tmp_path, text))


def test_bytes_that_are_no_text_are_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = tmp_path / "deployment.yaml"
    path.write_bytes(b"\xff\xfe\x00")
    assert str(path) in complaint(capsys, "up", str(path))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("- a list", "a map of settings is needed"),
        ("", "a map of settings is needed"),
        ("robots: demo", "robots: Extra inputs are not permitted"),
        ("robot: My Robot", "robot: "),
        ("services: {pilot: }", "unknown service 'pilot'"),
        ("services: {gateway: {prt: 1}}", "settings of gateway: prt: "),
        ("services: {gateway: {port: high}}", "settings of gateway: port: "),
        ("services: {gateway: 8000}", "services.gateway: "),
        ("services: {mapper: {map: nowhere.yaml}}", "no such file"),
        ("services: {mapper: {map: '${NO_SUCH_VARIABLE}/x'}}", "NO_SUCH_VARIABLE is not set"),
        ("services: {launcher: {hang_grace: -1}}", "settings of launcher: hang_grace"),
    ],
)
def test_a_deployment_that_cannot_be_run_is_refused_with_its_place(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, words: str
) -> None:
    path = deployment(tmp_path, text)
    said = complaint(capsys, "up", path)
    assert words in said
    assert path in said or "settings of" in said


def test_a_port_in_use_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = deployment(tmp_path, "services: {gateway: }")
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        assert f"port {port} of 127.0.0.1 is in use" in complaint(
            capsys, "up", path, "--port", str(port)
        )


def test_the_options_reach_the_launcher(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[tuple[Path, Overrides]] = []

    def launch(path: Path, overrides: Overrides, _show: object) -> int:
        seen.append((path, overrides))
        return 7

    monkeypatch.setattr(launcher_run, "launch", launch)
    options = ["--port", "8123", "--robot", "r2", "--endpoint", "tcp/10.0.0.1:7447", "--no-browser"]
    assert cli.run(["up", "a.yaml", *options]) == 7
    assert seen == [(Path("a.yaml"), Overrides("r2", "tcp/10.0.0.1:7447", 8123))]


def test_without_a_file_the_demo_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Path] = []

    def launch(path: Path, *_: object) -> int:
        seen.append(path)
        return 0

    monkeypatch.setattr(launcher_run, "launch", launch)
    assert cli.run(["up"]) == 0
    assert [path.name for path in seen] == ["demo.yaml"]


def test_without_a_checkout_there_is_no_demo(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(cli, "DEMOS", (tmp_path / "demo.yaml",))
    assert "name a deployment file" in complaint(capsys, "up")


def test_ctrl_c_during_a_command_is_no_traceback(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(launcher_run, "launch", interrupted)
    assert cli.run(["up", "a.yaml"]) == 130
    assert "Traceback" not in capsys.readouterr().err


def test_what_the_machine_refuses_is_told_in_words(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device", "out/estimates.csv")

    monkeypatch.setattr(launcher_run, "launch", full)
    said = complaint(capsys, "up", "a.yaml")
    assert said == "pilotage: out/estimates.csv: No space left on device"


def test_what_needs_too_much_memory_is_told_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def greedy(*_: object, **__: object) -> None:
        raise MemoryError("668 TiB")

    monkeypatch.setattr(cli, "app", greedy)
    assert cli.run(["map"]) == 2
    assert capsys.readouterr().err == "pilotage: this needs more memory than there is: 668 TiB\n"
