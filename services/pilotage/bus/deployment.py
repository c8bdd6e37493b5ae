"""What a deployment file says: one robot, its router, and the settings of each service.

    robot: demo
    services:
      robot: {driver: simulator, world: ../worlds/office.yaml}
      gateway: {port: 8000}

Paths are relative to the file; `${NAME}` and `${NAME:-default}` stand for the environment.
"""

import os
import re
from pathlib import Path
from typing import Annotated, Any, TypeVar

import yaml
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
)

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
_VARIABLE = re.compile(r"\$\{(\w+)(?::-([^}]*))?\}")


class ConfigError(ValueError):
    """A deployment or a setting that cannot be used; the text says why, in one line."""


def _resolve(value: object, info: ValidationInfo) -> object:
    if not isinstance(value, str):
        return value
    base = info.context["base"] if info.context else Path.cwd()
    try:
        return base / Path(_expanded(value)).expanduser()
    except RuntimeError as error:
        raise ValueError(str(error)) from error


def _expanded(text: str) -> str:
    def value_of(match: re.Match[str]) -> str:
        name, default = match.group(1), match.group(2)
        found = os.environ.get(name) or default
        if found is None:
            raise ValueError(f"environment variable {name} is not set")
        return found

    return _VARIABLE.sub(value_of, text)


ConfigPath = Annotated[Path, BeforeValidator(_resolve)]
"""A path relative to the deployment file."""


class Settings(BaseModel):
    """Base of every service's settings: frozen, defaults tested, unknown keys refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=False)


class Deployment(Settings):
    """One robot and its services.

    `endpoint` is the router's; without one the launcher picks a free port of this machine.
    `run_dir` holds what this run must survive a crash with (snapshots), `state_dir` what outlives
    it (the map library); the launcher sets both.
    """

    robot: Annotated[str, Field(pattern=r"^[a-z0-9_]{1,32}$")] = "demo"
    endpoint: str | None = None
    user: str | None = None
    password: str | None = None
    run_dir: ConfigPath | None = None
    state_dir: ConfigPath | None = None
    services: dict[str, dict[str, Any] | None] = {}
    base: Path = Path()

    @property
    def router(self) -> str:
        """The endpoint to connect to."""
        return self.endpoint or DEFAULT_ENDPOINT


Model = TypeVar("Model", bound=Settings)


def read_deployment(path: Path) -> Deployment:
    """Return the deployment in a YAML file or raise ConfigError."""
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise ConfigError(f"{path}: cannot be read: it is a pipe or a device, not a file")
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ConfigError(f"{path}: cannot be read: {reason}") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ConfigError(f"{path}: not valid YAML: {_one_line(error)}") from error
    if not isinstance(data, dict):
        raise ConfigError(f"{path}: a map of settings is needed")
    base = Path(str(data.get("base") or path.resolve().parent))
    return _validated(Deployment, data | {"base": base}, base, str(path))


def service_settings(deployment: Deployment, service: str, kind: type[Model]) -> Model:
    """Return the settings of one service, defaults where the deployment says nothing."""
    section = deployment.services.get(service) or {}
    return _validated(kind, section, deployment.base, f"settings of {service}")


def _validated(kind: type[Model], data: dict[str, Any], base: Path, where: str) -> Model:
    try:
        return kind.model_validate(data, context={"base": base})
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(str(part) for part in first["loc"])
        raise ConfigError(f"{where}: {place}: {first['msg']}") from error


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
