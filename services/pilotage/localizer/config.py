"""Settings of the localizer."""

from typing import Annotated, Literal

from pydantic import Field

from pilotage.bus.deployment import ConfigPath, Settings
from pilotage.localizer.markov_localizer import MarkovParams
from pilotage.localizer.method import MethodName
from pilotage.localizer.pose_grid import PoseGridParams

Sensor = Literal["laser", "sonar", "compass", "landmark"]


class LocalizerSettings(Settings):
    """How the localizer localizes, what it listens to and how finely it believes.

    `method`: markov, the exact belief; mcl, particles; or ekf, which follows the walls from a known
    start. `amcl_file`: parameters of AMCL for mcl.
    `sensors`: which measurements weigh the belief. `landmarks`: the file that says where those
    are which the sensor landmark sees. `resolution` [m] and `headings`: the states.
    `algorithm`, `recovery_weight`, `tempering`: see MarkovParams (Wu & Bell 2003, eq. 3 and 8).
    `belief_period`: least time [s] between two `belief` messages.
    """

    method: MethodName = "markov"
    amcl_file: ConfigPath | None = None
    sensors: tuple[Sensor, ...] = ("laser", "compass")
    landmarks: ConfigPath | None = None
    resolution: Annotated[float, Field(ge=0.02, le=1.0)] = PoseGridParams.resolution
    headings: Annotated[int, Field(ge=8, le=720)] = PoseGridParams.headings
    algorithm: Literal["m1", "m2"] = MarkovParams.algorithm
    recovery_weight: Annotated[float, Field(ge=0.0, le=1.0)] = MarkovParams.recovery_weight
    tempering: Annotated[float, Field(gt=0.0, le=1.0)] = MarkovParams.tempering
    belief_period: Annotated[float, Field(ge=0.05, le=10.0)] = 0.4

    def params(self) -> MarkovParams:
        """Return the parameters of the mathematics."""
        return MarkovParams(
            algorithm=self.algorithm,
            recovery_weight=self.recovery_weight,
            tempering=self.tempering,
            grid=PoseGridParams(resolution=self.resolution, headings=self.headings),
        )
