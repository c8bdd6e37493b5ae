"""A deployment becomes effective: checked, overridden, complete; or refused in one line."""

import pkgutil
import socket
from pathlib import Path

import pytest
import yaml

from pilotage.bus.deployment import (
    ConfigError,
    ConfigPath,
    Deployment,
    Settings,
    read_deployment,
    service_settings,
)
from pilotage.launcher.effective import (
    LAUNCHER,
    Overrides,
    effective,
    gateway_address,
    require_free_gateway,
)
from pilotage.launcher.process_table import PROCESSES, Entry, named, wanted
from pilotage.launcher.run_folder import write_deployment


class MapperSettings(Settings):
    """What the toy mapper reads and writes."""

    map: ConfigPath | None = None
    save_dir: ConfigPath | None = None
    resolution: float = 0.05
    thresholds: tuple[float, ...] = (0.25, float("inf"))


class GatewaySettings(Settings):
    """Where the toy gateway listens."""

    host: str = "127.0.0.1"
    port: int = 8000


def entry(name: str) -> Entry:
    settings = f"{__name__}:{name.capitalize()}Settings"
    return Entry(name, f"pilotage.{name}", settings, ("router",), named(name))


@pytest.fixture(autouse=True)
def toy_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    kinds = {"mapper": MapperSettings, "gateway": GatewaySettings}
    real = pkgutil.resolve_name

    def resolve(name: str) -> object:
        module, _, kind = name.partition(":")
        return kinds[kind.removesuffix("Settings").lower()] if module == __name__ else real(name)

    monkeypatch.setattr(pkgutil, "resolve_name", resolve)


TABLE = (entry("mapper"), entry("gateway"))


def deployment(folder: Path, text: str) -> Deployment:
    path = folder / "deployment.yaml"
    path.write_text(text, encoding="utf-8")
    return read_deployment(path)


def refusal(folder: Path, text: str, **overrides: str | int) -> str:
    with pytest.raises(ConfigError) as error:
        effective(deployment(folder, text), Overrides(**overrides), TABLE)  # type: ignore[arg-type]  # the test mixes them
    assert "\n" not in str(error.value)
    return str(error.value)


def test_defaults_are_filled_in(tmp_path: Path) -> None:
    made = effective(deployment(tmp_path, "services: {gateway: }"), Overrides(), TABLE)
    assert made.services["gateway"] == {"host": "127.0.0.1", "port": 8000}
    assert made.services["launcher"] is not None
    assert made.endpoint is not None
    assert made.endpoint.startswith("tcp/127.0.0.1:")


def test_the_command_line_wins_over_the_file(tmp_path: Path) -> None:
    said = deployment(tmp_path, "robot: a\nservices: {gateway: {port: 1234}}")
    overrides = Overrides(robot="b", endpoint="tcp/127.0.0.1:7000", port=4321)
    made = effective(said, overrides, TABLE)
    assert (made.robot, made.endpoint) == ("b", "tcp/127.0.0.1:7000")
    assert gateway_address(made) == ("127.0.0.1", 4321)


def test_the_file_wins_over_a_free_port(tmp_path: Path) -> None:
    said = deployment(tmp_path, "endpoint: tcp/127.0.0.1:7100\nservices: {mapper: }")
    assert effective(said, Overrides(), TABLE).endpoint == "tcp/127.0.0.1:7100"


def test_what_is_written_says_the_same_to_the_services(tmp_path: Path) -> None:
    (tmp_path / "floor.yaml").touch()
    said = deployment(tmp_path, "services: {mapper: {map: floor.yaml, resolution: 0.1}}")
    made = effective(said, Overrides(), TABLE)
    folder = tmp_path / "run"
    folder.mkdir()
    read = read_deployment(write_deployment(made.model_copy(update={"run_dir": folder}), folder))
    assert read.run_dir == folder
    for_mapper = service_settings(read, "mapper", MapperSettings)
    assert for_mapper == service_settings(said, "mapper", MapperSettings)
    assert for_mapper.map == tmp_path / "floor.yaml"


def test_only_its_owner_may_read_what_is_written(tmp_path: Path) -> None:
    path = write_deployment(Deployment(), tmp_path)
    assert path.stat().st_mode & 0o077 == 0
    assert yaml.safe_load(path.read_text())["robot"] == "demo"


def test_secrets_reach_the_services(tmp_path: Path) -> None:
    token = "a-token-of-sixteen-or-more"  # noqa: S105 - a test's
    said = deployment(tmp_path, f"services: {{gateway: {{operator_tokens: [{token}]}}}}")
    made = effective(said, Overrides(), PROCESSES)
    assert (made.services["gateway"] or {})["operator_tokens"] == [token]


def test_unknown_services_are_refused_with_the_known_ones(tmp_path: Path) -> None:
    text = refusal(tmp_path, "services: {maper: }")
    assert text == "unknown service 'maper' (known: mapper, gateway, launcher)"


def test_unknown_keys_are_refused_with_their_place(tmp_path: Path) -> None:
    text = refusal(tmp_path, "services: {mapper: {mapp: x}}")
    assert "settings of mapper: mapp" in text


def test_wrong_types_are_refused_with_their_place(tmp_path: Path) -> None:
    text = refusal(tmp_path, "services: {mapper: {resolution: fine}}")
    assert "settings of mapper: resolution" in text


def test_missing_files_are_named(tmp_path: Path) -> None:
    text = refusal(tmp_path, "services: {mapper: {map: nowhere.yaml}}")
    assert text == f"settings of mapper: map: no such file: {tmp_path / 'nowhere.yaml'}"


def test_a_folder_to_write_to_need_not_exist(tmp_path: Path) -> None:
    said = deployment(tmp_path, "services: {mapper: {save_dir: later}}")
    assert effective(said, Overrides(), TABLE).services["mapper"] is not None


def test_a_deployment_without_services_is_refused(tmp_path: Path) -> None:
    assert "names no services" in refusal(tmp_path, "robot: demo")


def test_a_robot_name_that_is_no_name_is_refused(tmp_path: Path) -> None:
    assert "--robot My Robot" in refusal(tmp_path, "services: {mapper: }", robot="My Robot")


def test_a_port_for_no_gateway_is_refused(tmp_path: Path) -> None:
    assert "has no gateway" in refusal(tmp_path, "services: {mapper: }", port=8000)


def test_a_port_in_use_is_refused() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen(1)
        port = other.getsockname()[1]
        services: dict[str, dict[str, object] | None] = {
            "gateway": {"host": "127.0.0.1", "port": port}
        }
        with pytest.raises(ConfigError, match=f"port {port} of 127.0.0.1 is in use"):
            require_free_gateway(Deployment(services=services))


def test_an_address_of_another_machine_is_refused() -> None:
    services: dict[str, dict[str, object] | None] = {"gateway": {"host": "192.0.2.1", "port": 8000}}
    with pytest.raises(ConfigError, match=r"cannot listen at 192\.0\.2\.1:8000"):
        require_free_gateway(Deployment(services=services))


def test_a_deployment_without_gateway_needs_no_port() -> None:
    require_free_gateway(Deployment())


def test_every_entry_of_the_process_table_can_be_run() -> None:
    for one in PROCESSES:
        main = "pilotage.bus.router" if one.name == "router" else f"{one.module}.__main__"
        assert pkgutil.resolve_name(main) is not None
        assert one.settings is None or issubclass(pkgutil.resolve_name(one.settings), Settings)
    assert issubclass(pkgutil.resolve_name(LAUNCHER), Settings)


def test_what_an_entry_waits_for_stands_before_it() -> None:
    seen: set[str] = set()
    for one in PROCESSES:
        assert set(one.after) <= seen
        seen.add(one.name)


def test_a_run_has_the_services_its_deployment_names() -> None:
    some = Deployment(endpoint="tcp/127.0.0.1:1", services={"robot": None, "mapper": {}})
    assert [one.name for one in wanted(PROCESSES, some)] == ["router", "mapper", "robot"]


def test_a_router_that_answers_already_is_not_started() -> None:
    with socket.socket() as zenohd:
        zenohd.bind(("127.0.0.1", 0))
        zenohd.listen(1)
        endpoint = f"tcp/127.0.0.1:{zenohd.getsockname()[1]}"
        some = Deployment(endpoint=endpoint, services={"robot": None})
        assert [one.name for one in wanted(PROCESSES, some)] == ["robot"]
