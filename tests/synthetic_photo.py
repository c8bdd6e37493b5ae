"""A photograph of a corridor as a cheap camera takes it, drawn without the simulator's renderer.

Polygons in space are projected by a lens with distortion that is tilted and leans to one side;
light falls off, shadows lie across the walls, the sensor is noisy, and the file is a JPEG.
"""

import io
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

Points = NDArray[np.float64]
Picture = NDArray[np.uint8]

Corners = list[tuple[float, float, float]]

SUPERSAMPLED = 2
NEAR = 0.4
"""m ahead of the lens at which walls and floor begin."""
LEFT, RIGHT, FLOOR, CEILING, END = -1.2, 1.2, -1.1, 1.5, 9.0
FRAME_HEIGHT = 0.95
"""m from the lens up to the head of a door."""


@dataclass(frozen=True)
class PhotoCamera:
    """What a calibration would say of it; pixels and rad."""

    width: int = 960
    height: int = 720
    focal: float = 700.0
    centre: tuple[float, float] = (470.0, 372.0)
    radial: tuple[float, float] = (-0.16, 0.03)
    tilt: float = float(np.deg2rad(4.0))
    roll: float = float(np.deg2rad(1.5))


def door_frames() -> list[float]:
    """Distances ahead, m, of the upright edges of two door frames on the left wall."""
    return [z for near in (2.6, 5.0) for z in (near, near + 0.07, near + 0.97, near + 1.04)]


def true_bearings() -> Points:
    """Bearings of these edges, rad to the left."""
    return np.array([np.arctan2(-LEFT, z) for z in door_frames()])


def other_bearings() -> Points:
    """Bearings of everything else that is upright: corners, a poster, a lamp post."""
    places = [(LEFT, END), (RIGHT, END), (RIGHT, 3.2), (RIGHT, 4.1), (0.30, 7.0), (0.36, 7.0)]
    return np.array([np.arctan2(-x, z) for x, z in places])


def photograph(camera: PhotoCamera, rng: np.random.Generator, exposure: float = 1.0) -> Picture:
    """Return the picture (h, w), shades 0 to 255."""
    size = camera.width * SUPERSAMPLED * 2, camera.height * SUPERSAMPLED * 2
    canvas = Image.new("L", size, 128)
    for polygon, shade in _polygons():
        flat = _projected(_clipped(polygon), camera) * SUPERSAMPLED + np.array(size) / 4.0
        ImageDraw.Draw(canvas).polygon([(float(x), float(y)) for x, y in flat], fill=shade)
    seen = _distorted(np.asarray(canvas, np.float32), camera)
    lit = seen * _light(seen.shape) * exposure
    soft = np.asarray(cv2.GaussianBlur(lit, (0, 0), 0.9), np.float64)
    noisy = soft + np.sqrt(np.maximum(soft, 1.0)) * 0.35 * rng.standard_normal(soft.shape)
    return _as_jpeg(np.clip(noisy, 0.0, 255.0).astype(np.uint8))


def _polygons() -> list[tuple[Points, int]]:
    """Walls, doors and things in space (x right, y up, z ahead) with their shades, far to near."""
    shapes = [
        (_facing(LEFT, RIGHT, END, CEILING), 150),
        (_level(FLOOR), 90),
        (_level(CEILING), 215),
        (_upright(LEFT, (NEAR, END), FLOOR, CEILING), 185),
        (_upright(RIGHT, (NEAR, END), FLOOR, CEILING), 170),
        (_upright(RIGHT, (3.2, 4.1), FLOOR + 0.05, 1.2), 120),
        ([(RIGHT, -0.2, 1.5), (RIGHT, -0.1, 1.5), (RIGHT, 0.6, 8.0), (RIGHT, 0.5, 8.0)], 70),
    ]
    for start in (5.0, 2.6):
        frame, leaf = (start, start + 1.04), (start + 0.07, start + 0.97)
        shapes.append((_upright(LEFT, frame, FLOOR, FRAME_HEIGHT), 75))
        shapes.append((_upright(LEFT, leaf, FLOOR, FRAME_HEIGHT - 0.07), 135))
    shapes.append((_facing(0.30, 0.36, 7.0, 1.3), 60))
    return [(np.array(corners), shade) for corners, shade in shapes]


def _facing(x0: float, x1: float, z: float, high: float) -> Corners:
    return [(x0, FLOOR, z), (x1, FLOOR, z), (x1, high, z), (x0, high, z)]


def _level(y: float) -> Corners:
    return [(LEFT, y, NEAR), (RIGHT, y, NEAR), (RIGHT, y, END), (LEFT, y, END)]


def _upright(x: float, ahead: tuple[float, float], low: float, high: float) -> Corners:
    near, far = ahead
    return [(x, low, near), (x, low, far), (x, high, far), (x, high, near)]


def _clipped(polygon: Points) -> Points:
    """Keep what lies before the lens: corners nearer than that are drawn where the edge ends."""
    return np.array([(x, y, max(z, NEAR)) for x, y, z in polygon])


def _projected(points: Points, camera: PhotoCamera) -> Points:
    """Pixels (n, 2) of points in space on an ideal lens."""
    x, y, z = points.T
    cos, sin = np.cos(camera.tilt), np.sin(camera.tilt)
    ahead, up = cos * z + sin * y, cos * y - sin * z
    right, down = x / ahead, -up / ahead
    cos, sin = np.cos(camera.roll), np.sin(camera.roll)
    leaning = np.stack([cos * right + sin * down, cos * down - sin * right], axis=1)
    return camera.focal * leaning + camera.centre


def _distorted(canvas: NDArray[np.float32], camera: PhotoCamera) -> NDArray[np.float32]:
    """What a real lens shows of the ideal picture; OpenCV says where each pixel comes from."""
    v, u = np.indices((camera.height, camera.width), np.float32)
    focal, (cu, cv) = camera.focal, camera.centre
    matrix = np.array([[focal, 0.0, cu], [0.0, focal, cv], [0.0, 0.0, 1.0]])
    pixels = np.stack([u.ravel(), v.ravel()], axis=1)[:, None]
    lens = np.array([*camera.radial, 0.0, 0.0])
    true = cv2.undistortPoints(pixels, matrix, lens, P=matrix)[:, 0]
    small = cv2.GaussianBlur(canvas, (0, 0), 0.5 * SUPERSAMPLED)
    corner = np.array([canvas.shape[1], canvas.shape[0]]) / 4.0
    where = (true * SUPERSAMPLED + corner).astype(np.float32)
    shape = camera.height, camera.width
    return cv2.remap(
        small, where[:, 0].reshape(shape), where[:, 1].reshape(shape), cv2.INTER_LINEAR
    ).astype(np.float32)


def _light(shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Vignetting, lamps that light one side more, and a soft shadow that falls aslant."""
    v, u = np.indices(shape)
    across, down = u / shape[1] - 0.5, v / shape[0] - 0.5
    vignette = 1.0 - 0.5 * (across**2 + down**2)
    shadow = 1.0 - 0.25 / (1.0 + np.exp(-(across + 0.8 * down - 0.1) * 25.0))
    return np.asarray(vignette * (1.0 + 0.25 * across) * shadow, np.float32)


def _as_jpeg(shades: NDArray[np.uint8]) -> NDArray[np.uint8]:
    file = io.BytesIO()
    Image.fromarray(shades).save(file, "JPEG", quality=75)
    return np.asarray(Image.open(file))
