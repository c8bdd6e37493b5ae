"""What the simulated robot makes of its camera's pictures: the bearings of upright edges.

It finds them as a real robot does, in the picture. Apart from the simulator's other sensors so
that OpenCV is loaded only where there are pictures.
"""

import numpy as np

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.robot.simulator.camera import Camera
from pilotage.robot.simulator.picture import Painter
from pilotage.robot.simulator.picture_kernels import warm_up
from pilotage.robot.simulator.picture_params import PictureParams
from pilotage.robot.simulator.simulation import Simulation
from pilotage.robot.vertical_edges import vertical_edges
from pilotage_schemas.sensors import VerticalEdges


class Eye:
    """A camera's painter and its finder of edges; its noise disturbs no other sensor's."""

    def __init__(self, simulation: Simulation, camera: Camera) -> None:
        self._simulation, self._camera = simulation, camera
        params = simulation.params.picture or PictureParams()
        self._painter = Painter(params, camera.params.field_of_view)
        self._rng = simulation.rng.spawn(1)[0]
        warm_up()  # a picture must not be late because its painter is being compiled

    def edges(self, stamp_ns: int) -> VerticalEdges:
        """Return the edges in view now, off the robot's x axis as the pan joint has it."""
        pan = self._camera.pan
        joint = (self._camera.params.mount_x, 0.0, pan)
        pose = se2.compose(self._simulation.pose, joint)
        picture = self._painter.picture(self._simulation.surroundings, pose, self._rng)
        found = vertical_edges(picture, self._painter.lens)
        bearings = np.asarray(wrap(found.bearings + pan), np.float32)
        return VerticalEdges(
            stamp_ns=stamp_ns, frame_id="camera", bearings=bearings, sigma=found.sigma
        )
