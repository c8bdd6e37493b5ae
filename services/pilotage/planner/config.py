"""Settings of the planner."""

from typing import Annotated

import numpy as np
from pydantic import Field

from pilotage.bus.deployment import ConfigPath, Settings
from pilotage.planner.active_localization import ActiveParams
from pilotage.planner.common_ground import GroundParams
from pilotage.planner.expected_scans import SightParams
from pilotage.planner.landmark_sight import CameraParams
from pilotage.planner.landmark_views import Camera
from pilotage.planner.mission import MissionParams
from pilotage.planner.path_params import FollowerParams
from pilotage.planner.potential_field import Recognition
from pilotage.planner.robot_facts import RobotBuild


class RecognitionSettings(Settings):
    """How far landmarks are recognised: 1 / (1 + exp((d - d0) / T)) at d m.

    `half_distance`: d0 [m], where one of two is; `width`: T [m]. Of a camera that recognises half
    of them at d_L m and a tenth at d_H: d_L and (d_H - d_L) / ln 9 (Liu et al. 2008).
    """

    half_distance: Annotated[float, Field(gt=0.0, le=1000.0)] = 4.0
    width: Annotated[float, Field(gt=0.0, le=100.0)] = 0.6

    def recognition(self) -> Recognition:
        """Return what the mathematics takes."""
        return Recognition(self.half_distance, self.width)


class CameraSettings(Settings):
    """A camera on a pan joint, as the robot's maker or a few tries say.

    `field_of_view`: full opening angle [rad]; `pan_limit`: how far it turns to either side [rad];
    `range_share`: standard deviation of a range as a share of it; `bearing_sigma` [rad].
    """

    field_of_view: Annotated[float, Field(gt=0.0, le=6.3)] = float(np.deg2rad(60.0))
    pan_limit: Annotated[float, Field(ge=0.0, le=3.2)] = float(np.deg2rad(90.0))
    range_share: Annotated[float, Field(gt=0.0, le=1.0)] = 0.1
    bearing_sigma: Annotated[float, Field(gt=0.0, le=1.6)] = float(np.deg2rad(10.0))
    recognition: RecognitionSettings = RecognitionSettings()
    recognition_by_class: dict[str, RecognitionSettings] = Field(default_factory=dict)

    def params(self) -> CameraParams:
        """Return what the mathematics takes."""
        by_class = {kind: one.recognition() for kind, one in self.recognition_by_class.items()}
        return CameraParams(
            camera=Camera(0.5 * self.field_of_view, self.range_share, self.bearing_sigma),
            pan_limit=self.pan_limit,
            recognition=self.recognition.recognition(),
            by_class=by_class,
        )


class PlannerSettings(Settings):
    """How the planner drives, and when it finds out by itself where the robot is.

    `max_linear` [m/s] and `max_angular` [rad/s] are never exceeded, nor are the robot's own.
    `alpha` [1/m]: share of the uncertainty that a metre of way must take away (Liu et al. 2008,
    eq. 6); `candidates`: how many looks are weighed. `always_localizes`: every doubt of the pose is
    resolved unasked, until somebody says otherwise. `doubt`, `settled`, `patience`,
    `longest_search` [s]: see MissionParams. `landmarks`: the file that says where those are which
    the robot is localized by, seen by `camera`; without one it is localized by the walls. `seed` of
    what is drawn at random.
    """

    max_linear: Annotated[float, Field(ge=0.05, le=2.0)] = FollowerParams.max_linear
    max_angular: Annotated[float, Field(ge=0.1, le=4.0)] = FollowerParams.max_angular
    alpha: Annotated[float, Field(ge=0.0, le=100.0)] = ActiveParams.alpha
    candidates: Annotated[int, Field(ge=2, le=200)] = ActiveParams.candidates
    always_localizes: bool = False
    doubt: Annotated[float, Field(ge=0.1, le=60.0)] = MissionParams.doubt
    settled: Annotated[float, Field(ge=0.1, le=60.0)] = MissionParams.settled
    patience: Annotated[float, Field(ge=1.0, le=600.0)] = MissionParams.patience
    longest_search: Annotated[float, Field(ge=10.0, le=3600.0)] = MissionParams.longest_search
    landmarks: ConfigPath | None = None
    camera: CameraSettings = CameraSettings()
    seed: int = 0

    def mission(self) -> MissionParams:
        """Return when to begin and to end what."""
        return MissionParams(
            doubt=self.doubt,
            settled=self.settled,
            patience=self.patience,
            longest_search=self.longest_search,
        )

    def active(self, build: RobotBuild) -> ActiveParams:
        """Return how a robot decides where to look from."""
        return ActiveParams(
            alpha=self.alpha,
            candidates=self.candidates,
            sight=SightParams() if build.sight is None else SightParams(range_max=build.sight),
            ground=GroundParams(radius=build.radius),
        )

    def follower(self, build: RobotBuild) -> FollowerParams:
        """Return how a robot follows its path."""
        return FollowerParams(
            radius=build.radius,
            max_linear=min(self.max_linear, build.max_linear),
            max_angular=min(self.max_angular, build.max_angular),
        )
