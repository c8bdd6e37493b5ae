"""From the settings and the files that they name to what the methods are made with."""

from collections.abc import Callable
from dataclasses import replace

from pilotage.bus.deployment import ConfigError
from pilotage.core.landmark_map import LandmarkFileError, LandmarkMap, read_landmarks
from pilotage.localizer.amcl_file import AmclFileError, AmclTranslation, read_amcl_file
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.methods import MethodSetup
from pilotage.localizer.particle_localizer import ParticleParams


def method_setup(settings: LocalizerSettings, say: Callable[[str], None]) -> MethodSetup:
    """Return what the methods are made with; `say` gets a line on each of AMCL's parameters.

    Raises:
        ConfigError: a file cannot be read, or a sensor lacks it.
    """
    markov = settings.params()
    amcl = _amcl(settings)
    for fate in () if amcl is None else amcl.fates:
        say(str(fate))
    particles = ParticleParams() if amcl is None else amcl.params
    # The same cells as the grid's: so both methods share the table that takes longest to make.
    evidence = replace(particles.evidence, tempering=settings.tempering, tables=markov.grid)
    return MethodSetup(
        markov=markov,
        particles=replace(particles, evidence=evidence),
        landmarks=_landmarks(settings),
        start=None if amcl is None else amcl.start,
        seed=0 if amcl is None or amcl.seed is None else amcl.seed,
    )


def _amcl(settings: LocalizerSettings) -> AmclTranslation | None:
    if settings.amcl_file is None:
        return None
    try:
        return read_amcl_file(settings.amcl_file)
    except AmclFileError as error:
        raise ConfigError(f"settings of localizer: amcl_file: {error}") from error


def _landmarks(settings: LocalizerSettings) -> LandmarkMap | None:
    if settings.landmarks is None:
        if "landmark" in settings.sensors:
            reason = "the sensor landmark needs a file that says where the landmarks are"
            raise ConfigError(f"settings of localizer: landmarks: {reason}")
        return None
    try:
        return read_landmarks(settings.landmarks)
    except LandmarkFileError as error:
        raise ConfigError(f"settings of localizer: landmarks: {error}") from error
