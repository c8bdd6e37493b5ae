"""Deployment files: what they mean, and how clearly a bad one is refused."""

from pathlib import Path

import pytest
from pydantic import ValidationError

from pilotage.bus.deployment import (
    DEFAULT_ENDPOINT,
    ConfigError,
    ConfigPath,
    Deployment,
    Settings,
    read_deployment,
    service_settings,
)


class RobotSettings(Settings):
    """A service's settings as they usually look."""

    world: ConfigPath | None = None
    speed: float = 0.3


def written(folder: Path, text: str) -> Path:
    path = folder / "demo.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def refusal_of(path: Path) -> str:
    with pytest.raises(ConfigError) as refused:
        service_settings(read_deployment(path), "robot", RobotSettings)
    text = str(refused.value)
    assert "\n" not in text
    return text


def test_an_empty_map_is_a_deployment_of_defaults(tmp_path: Path) -> None:
    deployment = read_deployment(written(tmp_path, "{}"))
    assert (deployment.robot, deployment.router) == ("demo", DEFAULT_ENDPOINT)
    assert service_settings(deployment, "robot", RobotSettings) == RobotSettings()


def test_a_deployment_says_what_differs(tmp_path: Path) -> None:
    text = "robot: r2\nendpoint: tcp/127.0.0.1:7000\nservices: {robot: {speed: 0.5}, mapper: }\n"
    deployment = read_deployment(written(tmp_path, text))
    assert (deployment.robot, deployment.router) == ("r2", "tcp/127.0.0.1:7000")
    assert service_settings(deployment, "robot", RobotSettings).speed == 0.5
    assert service_settings(deployment, "mapper", RobotSettings).speed == 0.3


def test_paths_are_relative_to_the_file(tmp_path: Path) -> None:
    deployment = read_deployment(written(tmp_path, "services: {robot: {world: ../office.yaml}}"))
    assert service_settings(deployment, "robot", RobotSettings).world == tmp_path / "../office.yaml"


def test_an_absolute_path_stays_as_it_is(tmp_path: Path) -> None:
    deployment = read_deployment(written(tmp_path, "services: {robot: {world: /srv/a.yaml}}"))
    assert service_settings(deployment, "robot", RobotSettings).world == Path("/srv/a.yaml")


def test_paths_may_name_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LOGS", "/logs")
    monkeypatch.delenv("MAPS", raising=False)
    text = "services: {robot: {world: '${LOGS}/${MAPS:-maps}/a.yaml'}}"
    deployment = read_deployment(written(tmp_path, text))
    assert service_settings(deployment, "robot", RobotSettings).world == Path("/logs/maps/a.yaml")


def test_a_missing_variable_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LOGS", raising=False)
    text = "services: {robot: {world: '${LOGS}/a.yaml'}}"
    assert "environment variable LOGS is not set" in refusal_of(written(tmp_path, text))


def test_an_effective_deployment_keeps_the_folder_it_came_from(tmp_path: Path) -> None:
    text = "base: /srv/deploy\nservices: {robot: {world: a.yaml}}"
    deployment = read_deployment(written(tmp_path, text))
    assert service_settings(deployment, "robot", RobotSettings).world == Path("/srv/deploy/a.yaml")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "a map of settings is needed"),
        ("- robot", "a map of settings is needed"),
        ("robot: [", "not valid YAML"),
        ("robot: a\n\tb: c", "not valid YAML"),
        ("a: 2026-99-99", "not valid YAML"),
        ("[" * 700, "not valid YAML"),
        ("robot: !!python/object/apply:os.getcwd []", "not valid YAML"),
        ("robots: demo", "robots: Extra inputs are not permitted"),
        ("robot: Big Robot", "robot: String should match"),
        ("robot: 1", "robot: Input should be a valid string"),
        ("1: demo", "Keys should be strings"),
        ("base: 7\nservices: 3", "services: Input should be a valid dictionary"),
        ("services: {robot: fast}", "services.robot: Input should be a valid dictionary"),
        ("services: {robot: {sped: 1}}", "settings of robot: sped: Extra inputs"),
        ("services: {robot: {speed: fast}}", "settings of robot: speed: Input should be"),
        ("services: {robot: {world: ~nobody_of_this_name/a}}", "settings of robot: world: "),
    ],
)
def test_a_bad_deployment_is_refused_in_one_line(tmp_path: Path, text: str, reason: str) -> None:
    assert reason in refusal_of(written(tmp_path, text))


def test_a_missing_file_is_refused_by_name(tmp_path: Path) -> None:
    assert "nowhere.yaml: cannot be read: No such file" in refusal_of(tmp_path / "nowhere.yaml")


def test_a_folder_is_refused(tmp_path: Path) -> None:
    assert "cannot be read" in refusal_of(tmp_path)


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "image.png"
    path.write_bytes(b"\x89PNG\xff\xfe")
    assert "cannot be read" in refusal_of(path)


def test_settings_cannot_be_changed() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        Deployment().__setattr__("robot", "other")
