"""Settings of a camera that recognises landmarks."""

from typing import Annotated

import numpy as np
from pydantic import Field

from pilotage.bus.deployment import Settings
from pilotage.planner.landmark_sight import CameraParams
from pilotage.planner.landmark_views import Camera
from pilotage.planner.potential_field import Recognition


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
