"""The deployment as it really runs: checked, with every default filled in."""

import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel, SecretStr

from pilotage.bus.deployment import ConfigError, Deployment, Settings, service_settings
from pilotage.launcher.addresses import free_endpoint, require_free_port
from pilotage.launcher.process_table import Entry
from pilotage_schemas.topics import ROBOT_NAME

LAUNCHER = "pilotage.launcher.config:LauncherSettings"
OUTPUT_SUFFIX = "_dir"
"""A path whose field ends so is written to; every other path of a service's settings is read."""


@dataclass(frozen=True)
class Overrides:
    """What the command line says in place of the file."""

    robot: str | None = None
    endpoint: str | None = None
    port: int | None = None


def effective(deployment: Deployment, overrides: Overrides, table: tuple[Entry, ...]) -> Deployment:
    """Return the deployment with the overrides and all defaults, or raise ConfigError."""
    deployment = _overridden(deployment, overrides)
    known = {e.name: e.settings for e in table if e.settings} | {"launcher": LAUNCHER}
    sections = {
        name: _section(deployment, name, known)
        for name in dict.fromkeys((*deployment.services, "launcher"))
    }
    if set(sections) == {"launcher"}:
        raise ConfigError(f"the deployment names no services (known: {', '.join(known)})")
    return deployment.model_copy(update={"services": sections})


def gateway_address(deployment: Deployment) -> tuple[str, int] | None:
    """Return host and port of the gateway of an effective deployment."""
    section = deployment.services.get("gateway")
    if not section or "port" not in section:
        return None
    return str(section.get("host", "127.0.0.1")), int(section["port"])


def require_free_gateway(deployment: Deployment) -> None:
    """Raise ConfigError when the gateway's port is in use."""
    address = gateway_address(deployment)
    if address is not None:
        require_free_port(*address)


def _overridden(deployment: Deployment, overrides: Overrides) -> Deployment:
    robot = overrides.robot or deployment.robot
    if not ROBOT_NAME.fullmatch(robot):
        raise ConfigError(f"--robot {robot}: a name is of a-z, 0-9 and _, at most 32 of them")
    endpoint = overrides.endpoint or deployment.endpoint or free_endpoint()
    services = dict(deployment.services)
    if overrides.port is not None:
        if "gateway" not in services:
            raise ConfigError("--port: the deployment has no gateway")
        services["gateway"] = (services["gateway"] or {}) | {"port": overrides.port}
    return deployment.model_copy(
        update={"robot": robot, "endpoint": endpoint, "services": services}
    )


def _section(deployment: Deployment, name: str, known: dict[str, str]) -> dict[str, object]:
    if name not in known:
        raise ConfigError(f"unknown service '{name}' (known: {', '.join(known)})")
    kind: type[Settings] = pkgutil.resolve_name(known[name])
    settings = service_settings(deployment, name, kind)
    for field, path in _inputs(settings):
        if not path.exists():
            raise ConfigError(f"settings of {name}: {field}: no such file: {path}")
    return {field: plain(value) for field, value in settings.model_dump().items()}


def plain(value: object) -> object:
    """Return a setting as YAML can hold it; secrets stay readable, for the services must."""
    if isinstance(value, SecretStr):
        return value.get_secret_value()
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    return value


def _inputs(settings: BaseModel, prefix: str = "") -> Iterator[tuple[str, Path]]:
    for field in type(settings).model_fields:
        value = getattr(settings, field)
        if isinstance(value, Path) and not field.endswith(OUTPUT_SUFFIX):
            yield prefix + field, value
        elif isinstance(value, BaseModel):
            yield from _inputs(value, f"{prefix}{field}.")
