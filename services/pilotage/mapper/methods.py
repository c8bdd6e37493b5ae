"""The ways of mapping by name."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast, get_args

from pilotage.mapper.method import MappingMethod
from pilotage.mapper.sonar_models import SonarModel


@dataclass(frozen=True)
class MappingSetup:
    """What the methods are made with.

    `model`: of the sonar's grid, one of `MODELS`; None is the method's own default.
    """

    model: str | None = None


class NoMethodError(ValueError):
    """A method or a model that cannot be had; the text says why and which ones can."""


def _laser(_setup: MappingSetup) -> MappingMethod:
    # Imported here: each method brings kernels that the other has no use for.
    from pilotage.mapper.laser_slam import LaserSlam  # noqa: PLC0415 - start-up time

    return LaserSlam()


def _sonar(setup: MappingSetup) -> MappingMethod:
    from pilotage.mapper.sonar_mapping import SonarMapping  # noqa: PLC0415 - start-up time

    if setup.model is None:
        return SonarMapping()
    return SonarMapping(model=cast("SonarModel", setup.model))  # one of MODELS, as required


METHODS: dict[str, Callable[[MappingSetup], MappingMethod]] = {"laser": _laser, "sonar": _sonar}
MODELS: tuple[str, ...] = get_args(SonarModel)


def require_method(name: str, setup: MappingSetup) -> None:
    """Raise NoMethodError unless there is such a method, and a model if one is asked for."""
    if name not in METHODS:
        raise NoMethodError(f"there is no method '{name}'; there are {' and '.join(METHODS)}")
    if setup.model is not None and name != "sonar":
        raise NoMethodError(f"a model is chosen for the sonar; the {name} has only one")
    if setup.model is not None and setup.model not in MODELS:
        raise NoMethodError(f"there is no model '{setup.model}'; there are {', '.join(MODELS)}")


def make_method(name: str, setup: MappingSetup) -> MappingMethod:
    """Return the method, before its first measurement.

    Raises:
        NoMethodError: there is no such method or model.
    """
    require_method(name, setup)
    return METHODS[name](setup)
