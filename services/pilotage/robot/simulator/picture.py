"""The grey-scale picture that a simulated camera takes; pure but for the random numbers' state."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.grid import GridGeometry
from pilotage.robot.simulator.picture_kernels import Lens, Scene, paint
from pilotage.robot.simulator.picture_params import PictureParams
from pilotage.robot.simulator.range_sensors import Surroundings

FARTHEST_DOOR = 15.0
"""m; farther door frames are less than a pixel wide."""
OUT_OF_THE_LENS = 0.25
"""m; nobody stands nearer to the lens."""


class Painter:
    """Takes pictures with one camera, whose full opening angle across is `field_of_view` rad."""

    def __init__(self, params: PictureParams, field_of_view: float) -> None:
        self.params = params
        self.lens = params.lens(field_of_view)

    def picture(
        self, around: Surroundings, pose: ArrayLike, rng: np.random.Generator
    ) -> NDArray[np.uint8]:
        """Return the picture (h, w) of a camera that looks along `pose` (3,) of the map frame."""
        params, geometry = self.params, around.walls.geometry
        in_grid = se2.compose(se2.inverse(geometry.origin), pose)
        shades = np.empty((params.height, params.width), np.float32)
        paint(shades, self._lens(in_grid), self._scene(around, in_grid, geometry))
        blurred = _blurred(shades * np.float32(params.exposure))
        noise = rng.standard_normal(blurred.shape, np.float32)
        noise *= np.float32(params.noise)
        blurred += noise
        return np.clip(np.rint(blurred), 0.0, 255.0).astype(np.uint8)

    def _lens(self, pose: NDArray[np.float64]) -> Lens:
        x, y, theta = (float(value) for value in pose)
        params = self.params
        middle = (params.width - 1) / 2.0, (params.height - 1) / 2.0
        focal = self.lens.focal
        return Lens(x, y, theta, params.lens_height, focal, *middle, params.samples)

    def _scene(
        self, around: Surroundings, pose: NDArray[np.float64], geometry: GridGeometry
    ) -> Scene:
        discs = around.discs.copy()
        discs[:, :2] = geometry.grid_from_map(discs[:, :2])
        distances = np.hypot(discs[:, 0] - pose[0], discs[:, 1] - pose[1])
        far_to_near = np.argsort(-distances)
        people = discs[far_to_near][distances[far_to_near] > OUT_OF_THE_LENS]
        return Scene(
            around.walls.stops_beams,
            geometry.resolution,
            _near(around.walls.doors.jambs, pose, geometry),
            _near(around.walls.doors.leaves, pose, geometry),
            people,
            self.params.frame_width,
        )


def _near(
    segments: NDArray[np.float64], pose: NDArray[np.float64], geometry: GridGeometry
) -> NDArray[np.float64]:
    """Return the segments (n, 2, 2) near a camera as (k, 4) in the grid's frame."""
    ends = geometry.grid_from_map(segments.reshape(-1, 2)).reshape(-1, 4)
    middles = (ends[:, :2] + ends[:, 2:]) / 2.0
    is_near = np.hypot(*(middles - pose[:2]).T) < FARTHEST_DOOR
    near: NDArray[np.float64] = np.ascontiguousarray(ends[is_near])
    return near


def _blurred(shades: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return a picture as a slightly soft lens shows it: weights 1 2 1 both ways."""
    padded = np.pad(shades, 1, mode="edge")
    down = padded[:-2] + padded[1:-1] + padded[1:-1] + padded[2:]
    both: NDArray[np.float32] = down[:, :-2] + down[:, 1:-1] + down[:, 1:-1] + down[:, 2:]
    both *= np.float32(1.0 / 16.0)
    return both
