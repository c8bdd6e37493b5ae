"""AMCL's parameter file, read for the particle filter: nothing in it is passed over in silence.

Taken are flat YAML (ROS 1), a section `amcl`, and nav2's `amcl: ros__parameters:`, below
namespaces too. What is left out has AMCL's default where AMCL's formula needs it, else ours.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
import yaml
from numpy.typing import NDArray

from pilotage.core.motion import OdometryNoise
from pilotage.localizer.amcl_names import ALIASES, NOT_NEEDED, NUMBERS, SWITCHES, WORDS
from pilotage.localizer.particle_field import BeamModel
from pilotage.localizer.particle_localizer import ParticleParams
from pilotage.localizer.particle_recovery import RecoveryParams
from pilotage.localizer.particle_resampling import KldParams

ALPHA = 0.2
Z_HIT = Z_RAND = 0.5
COVARIANCE_XY, COVARIANCE_YAW = 0.25, (math.pi / 12.0) ** 2
"""Defaults of AMCL."""

LONGEST_BEAM = 30.0
"""Beams longer than this [m] are not used: errors of the heading blur their ends."""

Values = Mapping[str, float | str | bool]
"""Checked values by nav2's names."""


class AmclFileError(ValueError):
    """A parameter file of AMCL cannot be used; the message names file, parameter and fault."""


@dataclass(frozen=True)
class Fate:
    """What became of one parameter: its name and value as in the file, and why."""

    name: str
    value: object
    kind: Literal["used", "not needed", "unknown"]
    reason: str

    def __str__(self) -> str:
        """One line for people."""
        return f"{self.name}: {self.value} - {self.kind}{': ' if self.reason else ''}{self.reason}"


@dataclass(frozen=True)
class AmclTranslation:
    """The file in our words: parameters, start (pose (3,), covariance (3, 3)) and seed, if given.

    `fates`: one for each parameter in the file.
    """

    params: ParticleParams
    start: tuple[NDArray[np.float64], NDArray[np.float64]] | None
    seed: int | None
    fates: tuple[Fate, ...]


def read_amcl_file(file: Path) -> AmclTranslation:
    """Return what a parameter file of AMCL means here.

    Raises:
        AmclFileError: unreadable, without AMCL's parameters, or a value that cannot be.
    """
    try:
        parameters = _amcl_section(yaml.safe_load(file.read_bytes()))
        return _translated(parameters)
    except OSError as error:
        raise AmclFileError(f"{file}: {error.strerror or error}") from None
    except (yaml.YAMLError, RecursionError) as error:
        reason = " ".join(str(error).split())
        raise AmclFileError(f"{file}: not readable as YAML ({reason})") from None
    except ValueError as error:
        raise AmclFileError(f"{file}: {error}") from None


def _amcl_section(content: object) -> dict[str, object]:
    """Return AMCL's parameters by flat names, wherever in the file they stand."""
    match content:
        case {"ros__parameters": dict(parameters)}:
            return _flat(parameters)
        case dict():
            for name, section in content.items():
                if str(name).rsplit("/", maxsplit=1)[-1] in ("amcl", "**"):
                    return _amcl_section(section)
            if any(_canonical(str(name)) in _KNOWN for name in content):
                return _flat(content)
            for section in content.values():
                if isinstance(section, dict) and "amcl" in section:
                    return _amcl_section(section)
    raise ValueError("no parameters of AMCL in it")


def _flat(parameters: Mapping[object, object], prefix: str = "") -> dict[str, object]:
    flat: dict[str, object] = {}
    for key, value in parameters.items():
        if isinstance(value, dict):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _translated(parameters: Mapping[str, object]) -> AmclTranslation:
    values: dict[str, float | str | bool] = {}
    for name, value in parameters.items():
        canonical = _canonical(name)
        if canonical in values:
            raise ValueError(f"{name} says again what another name of it ({canonical}) says")
        if canonical in NUMBERS or canonical in WORDS or canonical in SWITCHES:
            values[canonical] = _checked(name, canonical, value)
    fates = tuple(_fate(name, value, values) for name, value in parameters.items())
    return AmclTranslation(_params(values), _start(values), _seed(values), fates)


def _canonical(name: str) -> str:
    return ALIASES.get(name, name)


_KNOWN = {*NUMBERS, *WORDS, *SWITCHES, *NOT_NEEDED}


def _checked(name: str, canonical: str, value: object) -> float | str | bool:
    if canonical in SWITCHES:
        if not isinstance(value, bool):
            raise ValueError(f"{name} must be true or false, not {value!r}")
        return value
    if canonical in WORDS:
        if not isinstance(value, str) or value not in WORDS[canonical]:
            words = ", ".join(WORDS[canonical])
            raise ValueError(f"{name} must be one of {words}, not {value!r}")
        return value
    (wanted, holds), _ = NUMBERS[canonical]
    number = _number(value)
    if not math.isfinite(number) or not holds(number):
        raise ValueError(f"{name} must be {wanted}, not {value!r}")
    return number


def _number(value: object) -> float:
    """Return the number, NaN if it is none; YAML 1.1 takes 1e-3 (no dot) for text, ROS does not."""
    try:
        return math.nan if isinstance(value, bool) else float(str(value))
    except ValueError:
        return math.nan


def _fate(name: str, value: object, values: Values) -> Fate:
    canonical = _canonical(name)
    if canonical in NOT_NEEDED:
        return Fate(name, value, "not needed", NOT_NEEDED[canonical])
    if canonical in SWITCHES:
        return Fate(name, value, "used", SWITCHES[canonical])
    if canonical in WORDS:
        instead = WORDS[canonical][str(value)]
        return Fate(name, value, "not needed" if instead else "used", instead or "as it says")
    if canonical in NUMBERS:
        without = _why_without(canonical, values)
        if without:
            return Fate(name, value, "not needed", without)
        return Fate(name, value, "used", NUMBERS[canonical][1])
    return Fate(name, value, "unknown", "no AMCL that we know of has it")


def _why_without(name: str, values: Values) -> str:
    """Return why a known number is not used, given the other values; empty if it is."""
    if name.startswith("initial_pose.") and _start(values) is None:
        return "set_initial_pose is false, so the start is unknown"
    if name == "random_seed" and _seed(values) is None:
        return "negative means any; each run here is repeatable"
    if name == "laser_max_range" and float(values[name]) <= 0.0:
        return "it says to take the laser's own, which its scans carry"
    return ""


def _params(values: Values) -> ParticleParams:
    """Return our parameters; ValueError if two values do not go together."""
    ours = ParticleParams()
    get = _Numbers(values)
    beam = _beam(get, ours.evidence.beam)
    return replace(
        ours,
        beams=int(get("max_beams", ours.beams)),
        update_way=get("update_min_d", ours.update_way),
        update_turn=get("update_min_a", ours.update_turn),
        motion=_motion(get) if get.any(*_ALPHAS) else ours.motion,
        kld=_kld(get, ours.kld),
        recovery=_recovery(get, ours.recovery),
        evidence=replace(ours.evidence, beam=beam),
    )


_ALPHAS = ("alpha1", "alpha2", "alpha3", "alpha4")


class _Numbers:
    """Numbers by name, with a default for those that are not given."""

    def __init__(self, values: Values) -> None:
        self._values = values

    def __call__(self, name: str, default: float) -> float:
        return float(self._values.get(name, default))

    def any(self, *names: str) -> bool:
        """Say whether any of the names is given."""
        return any(name in self._values for name in names)


def _motion(get: _Numbers) -> OdometryNoise:
    return OdometryNoise(
        rotation_noise_from_rotation=get("alpha1", ALPHA),
        rotation_noise_from_translation=get("alpha2", ALPHA),
        translation_noise_from_translation=get("alpha3", ALPHA),
        translation_noise_from_rotation=get("alpha4", ALPHA),
    )


def _kld(get: _Numbers, ours: KldParams) -> KldParams:
    least, most = get("min_particles", ours.least), get("max_particles", ours.most)
    if least > most and get.any("min_particles") and get.any("max_particles"):
        raise ValueError(f"min_particles ({least:g}) is above max_particles ({most:g})")
    return replace(
        ours,
        least=int(min(least, most)) if get.any("max_particles") else int(least),
        most=int(max(least, most)) if get.any("min_particles") else int(most),
        epsilon=get("pf_err", ours.epsilon),
        quantile=get("pf_z", ours.quantile),
        bin_size=get("spatial_resolution_x", ours.bin_size),
        bin_turn=get("spatial_resolution_theta", ours.bin_turn),
    )


def _recovery(get: _Numbers, ours: RecoveryParams) -> RecoveryParams:
    if not get.any("recovery_alpha_slow", "recovery_alpha_fast"):
        return ours
    slow, fast = get("recovery_alpha_slow", 0.0), get("recovery_alpha_fast", 0.0)
    if slow > fast:
        raise ValueError(f"recovery_alpha_slow ({slow:g}) is above recovery_alpha_fast ({fast:g})")
    return replace(ours, slow=slow, fast=fast)


def _beam(get: _Numbers, ours: BeamModel) -> BeamModel:
    """Return the beam model; the outlier is AMCL's z_rand / range over its z_hit, at the best."""
    longest = get("laser_max_range", -1.0)
    reach = min(longest, LONGEST_BEAM) if longest > 0.0 else ours.reach
    outlier = ours.outlier
    if get.any("z_hit", "z_rand"):
        spread = get("z_rand", Z_RAND) / (longest if longest > 0.0 else reach)
        outlier = spread / (get("z_hit", Z_HIT) + spread)
    return BeamModel(sigma=get("sigma_hit", ours.sigma), outlier=outlier, reach=reach)


def _start(values: Values) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return the start, if the file has one and does not say to leave it alone."""
    names = ("initial_pose.x", "initial_pose.y", "initial_pose.yaw")
    wanted = values.get("set_initial_pose", any(name in values for name in names))
    if not wanted:
        return None
    get = _Numbers(values)
    spread = [
        get("initial_pose.covariance_x", COVARIANCE_XY),
        get("initial_pose.covariance_y", COVARIANCE_XY),
        get("initial_pose.covariance_yaw", COVARIANCE_YAW),
    ]
    return np.array([get(name, 0.0) for name in names]), np.diag(spread)


def _seed(values: Values) -> int | None:
    seed = int(float(values.get("random_seed", -1)))
    return seed if seed >= 0 else None
