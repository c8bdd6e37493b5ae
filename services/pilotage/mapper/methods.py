"""The ways of mapping by name."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import cast, get_args

import numpy as np

from pilotage.mapper.method import MappingMethod
from pilotage.mapper.sonar_models import SonarModel


@dataclass(frozen=True)
class MappingSetup:
    """What the methods are made with.

    `model`: of the sonar's grid, one of `MODELS`; None is the method's own default.
    """

    model: str | None = None
    rng: np.random.Generator = field(default_factory=np.random.default_rng)
    """Of the methods that roll dice; handed in, a run can be repeated."""


class NoMethodError(ValueError):
    """A method or a model that cannot be had; the text says why and which ones can."""


def _laser(setup: MappingSetup) -> MappingMethod:
    # Imported here: each method brings kernels that the other has no use for.
    from pilotage.mapper.laser_mapping import LaserMapping  # noqa: PLC0415 - start-up time

    return LaserMapping(setup.rng)


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
