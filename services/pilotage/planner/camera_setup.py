"""From the settings and the file that they name to landmarks, and the camera that sees them."""

from pilotage.bus.deployment import ConfigError
from pilotage.core.landmark_map import LandmarkFileError, LandmarkMap, read_landmarks
from pilotage.planner.config import PlannerSettings
from pilotage.planner.landmark_sight import CameraParams


def camera_of(settings: PlannerSettings) -> tuple[LandmarkMap, CameraParams] | None:
    """Return what the robot is localized by besides walls; None: by walls alone.

    Raises:
        ConfigError: the file of landmarks cannot be used, or a class of the camera is not in it.
    """
    if settings.landmarks is None:
        return None
    try:
        landmarks = read_landmarks(settings.landmarks)
    except LandmarkFileError as error:
        raise ConfigError(f"settings of planner: landmarks: {error}") from error
    strangers = sorted(set(settings.camera.recognition_by_class) - set(landmarks.classes))
    if strangers:
        reason = f"no landmark is of the class '{strangers[0]}'"
        raise ConfigError(f"settings of planner: camera: recognition_by_class: {reason}")
    return landmarks, settings.camera.params()
