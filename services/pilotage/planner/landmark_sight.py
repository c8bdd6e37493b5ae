"""A camera on a pan joint, and the landmarks of a map, as a sight of active localization; pure."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.grid_resampling import resample
from pilotage.core.landmark_map import LandmarkMap
from pilotage.core.laser_view import View
from pilotage.planner.information import LogLikelihoods
from pilotage.planner.landmark_targets import Field, TargetParams, survey
from pilotage.planner.landmark_views import (
    Camera,
    Sharpness,
    expected_log_likelihoods,
    views_from,
)
from pilotage.planner.map_potential import bits_at
from pilotage.planner.potential_field import Recognition, sources_of
from pilotage.planner.sight import Window

RESOLUTION = 0.2
"""m between places whose potential is compared, unless the map is coarser."""


@dataclass(frozen=True)
class CameraParams:
    """A camera that recognises landmarks.

    `pan_limit`: how far it turns to either side [rad]; `recognition` of every class that
    `by_class` does not name; `precision`: poses this near need not be told apart [m];
    `pointings`: how many are compared.
    """

    camera: Camera = field(default_factory=Camera)
    pan_limit: float = float(np.deg2rad(90.0))
    recognition: Recognition = field(default_factory=lambda: Recognition(4.0, 0.6))
    by_class: dict[str, Recognition] = field(default_factory=dict)
    precision: float = 0.3
    pointings: int = 13

    @property
    def sharpness(self) -> Sharpness:
        """How sharply it tells poses apart."""
        camera = self.camera
        return Sharpness(
            camera.range_error,
            camera.bearing_error,
            camera.outlier,
            blur=self.precision,
            rim=camera.bearing_error,
        )


class LandmarkPotential:
    """The environment potential of landmarks, and where it and the window potential are highest."""

    def __init__(self, found: Field) -> None:
        self.geometry: GridGeometry = found.geometry
        self.bits = found.environment.astype(np.float32)
        self._maxima = np.vstack([found.window_maxima[:, :2], found.environment_maxima])

    def bits_at(self, points_map: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return it at points (n, 2) of the map frame, zero off the map."""
        return bits_at(self.geometry, self.bits, points_map)

    def maxima(self) -> NDArray[np.float64]:
        """Return M u S (k, 2), map frame."""
        return self._maxima


class LandmarkSight:
    """What a camera is expected to tell."""

    def __init__(self, landmarks: LandmarkMap, world: OccupancyMap, params: CameraParams) -> None:
        known = dict.fromkeys(landmarks.classes, params.recognition) | params.by_class
        self.params = params
        self._sources = sources_of(landmarks, known, world)
        targets = TargetParams(params.camera.half_view)
        coarse = resample(world, max(RESOLUTION, world.geometry.resolution))
        self._potential = LandmarkPotential(survey(self._sources, coarse, targets))

    @property
    def potential(self) -> LandmarkPotential:
        """The paper's F_S."""
        return self._potential

    @property
    def pointings(self) -> NDArray[np.float64]:
        """Where the joint can point (k,) [rad]."""
        limit = self.params.pan_limit
        return np.linspace(-limit, limit, self.params.pointings)

    def window(self, _view: View) -> Window:
        """Return what the camera sees straight ahead."""
        return 0.0, self.params.camera.half_view

    def log_likelihoods(
        self, poses: NDArray[np.float64], truths: NDArray[np.int64], window: Window
    ) -> LogLikelihoods:
        """Compare the landmarks expected within the window."""
        views = views_from(self._sources, poses)
        sharpness = self.params.sharpness
        return expected_log_likelihoods(self._sources, views, truths, window, sharpness)


def warm_up() -> None:
    """Compile the kernels of landmarks, or load them."""
    world = OccupancyMap(GridGeometry(2, 2, RESOLUTION), np.zeros((2, 2), np.int8))
    landmarks = LandmarkMap(np.zeros((1, 2)), ("post",), (None,))
    sight = LandmarkSight(landmarks, world, CameraParams())
    sight.log_likelihoods(np.zeros((1, 3)), np.zeros(1, np.int64), (0.0, 0.5))
