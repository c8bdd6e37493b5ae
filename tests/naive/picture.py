"""A picture pixel by pixel: for each, what its line of sight meets, by plain geometry."""

import math

import numpy as np
from numpy.typing import NDArray

from naive.raycast import cast_ray_in_grid
from pilotage.robot.simulator.picture_kernels import Lens, Scene

Point = tuple[float, float]


def paint(shape: tuple[int, int], lens: Lens, scene: Scene) -> NDArray[np.float64]:
    """Twin of `picture_kernels.paint`: returns the picture (h, w)."""
    rows, cols = shape
    picture = np.zeros(shape)
    for col in range(cols):
        for sample in range(lens.samples):
            u = col - 0.5 + (sample + 0.5) / lens.samples
            aside = math.atan2(lens.centre - u, lens.focal)
            for row in range(rows):
                rise = (lens.horizon - row) / math.hypot(lens.focal, lens.centre - u)
                picture[row, col] += _shade(lens.theta + aside, rise, lens, scene) / lens.samples
    return picture


def _shade(direction: float, rise: float, lens: Lens, scene: Scene) -> float:
    """What a line of sight that rises by `rise` m a metre shows: the nearest of all it meets."""
    eye = (lens.x, lens.y)
    heading = (math.cos(direction), math.sin(direction))
    wall = 60.0
    found = cast_ray_in_grid(
        scene.is_wall, eye[0] / scene.cell, eye[1] / scene.cell, direction, 60.0 / scene.cell
    )
    place, normal, material = (0.0, 0.0), 0.0, "wall"
    if math.isfinite(found):
        wall = found * scene.cell
        place = (eye[0] + wall * heading[0], eye[1] + wall * heading[1])
        normal, material = _surface(place, direction, scene)
    shade = _room_shade((wall, rise), (place, normal, material), lens)
    for door in scene.doors:
        distance = _crossing(eye, heading, door)
        height = lens.height + rise * (distance or 0.0)
        if distance is not None and 0.05 < distance <= wall + 0.05 and 2.05 <= height <= 2.6:
            at = (eye[0] + distance * heading[0], eye[1] + distance * heading[1])
            light = _light(direction + math.pi) * _patch(at) / (1.0 + 0.02 * distance)
            shade = light * (75.0 if height < 2.12 else 190.0)
    for number, (x, y, radius) in enumerate(scene.people):
        ahead = (x - eye[0]) * heading[0] + (y - eye[1]) * heading[1]
        miss = abs((y - eye[1]) * heading[0] - (x - eye[0]) * heading[1])
        height = lens.height + rise * ahead
        if 0.2 < ahead <= wall and height >= 0.0 and miss < radius * _girth(height):
            tone = _chance(number, round(1000.0 * radius), int(height > 0.85))
            roundness = math.sqrt(1.0 - (miss / radius) ** 2)
            shade = (0.6 + 0.4 * roundness) * (45.0 + 90.0 * tone)
    return shade


def _room_shade(sight: tuple[float, float], hit: tuple[Point, float, str], lens: Lens) -> float:
    (distance, rise), (place, normal, material) = sight, hit
    height = lens.height + rise * distance
    if height < 0.0:
        return 105.0 / (1.0 + 0.04 * lens.height / -rise)
    if height > 2.6:
        return 215.0 / (1.0 + 0.03 * (2.6 - lens.height) / rise)
    light = _light(normal) * _patch(place) / (1.0 + 0.02 * distance)
    if material != "wall":
        return light * {"leaf": 140.0, "frame": 75.0}[material]
    faces_x = abs(math.cos(normal)) > 0.5
    number = round((place[0] if faces_x else place[1]) / 0.05)
    along = place[1] if faces_x else place[0]
    return light * _plaster(number, along, height)


def _surface(place: Point, direction: float, scene: Scene) -> tuple[float, str]:
    x, y = place[0] / scene.cell, place[1] / scene.cell
    if abs(x - round(x)) < abs(y - round(y)):
        normal = math.pi if math.cos(direction) > 0.0 else 0.0
    else:
        normal = -math.pi / 2.0 if math.sin(direction) > 0.0 else math.pi / 2.0
    for leaf in scene.leaves:
        along, across, length = _relative(leaf, place)
        if abs(across) < 0.06 and 0.0 <= along <= length:
            upright = math.atan2(leaf[3] - leaf[1], leaf[2] - leaf[0]) + math.pi / 2.0
            away = math.cos(upright - direction) > 0.0
            return (upright + math.pi if away else upright), "leaf"
    for door in scene.doors:
        along, across, length = _relative(door, place)
        beside_first = -scene.frame < along < 0.012
        beside_second = -0.012 < along - length < scene.frame
        if abs(across) < 0.26 and (beside_first or beside_second):
            return normal, "frame"
    return normal, "wall"


def _relative(segment: NDArray[np.float64], point: Point) -> tuple[float, float, float]:
    offset = complex(point[0] - segment[0], point[1] - segment[1])
    way = complex(segment[2] - segment[0], segment[3] - segment[1])
    turned = offset / (way / abs(way))
    return turned.real, turned.imag, abs(way)


def _crossing(eye: Point, heading: Point, segment: NDArray[np.float64]) -> float | None:
    """How far along a ray a segment is crossed: two unknowns, two equations."""
    matrix = np.array(
        [[heading[0], segment[0] - segment[2]], [heading[1], segment[1] - segment[3]]]
    )
    if abs(np.linalg.det(matrix)) < 1e-9:
        return None
    distance, share = np.linalg.solve(matrix, (segment[0] - eye[0], segment[1] - eye[1]))
    return float(distance) if 0.0 <= share <= 1.0 else None


def _plaster(wall: int, place: float, height: float) -> float:
    grain = 0.975 + 0.05 * _chance(wall, math.floor(place / 0.04), math.floor(height / 0.04))
    if height < 0.10:
        return 95.0 * grain
    tile = math.floor(place / 2.6)
    inside = place - 2.6 * tile
    if _chance(wall, tile, 1) < 0.12 and abs(inside - 1.3) < 0.03:
        return 120.0 * grain
    width, bottom = 0.35 + 0.6 * _chance(wall, tile, 3), 0.8 + 0.5 * _chance(wall, tile, 5)
    left, tall = (2.6 - width) * _chance(wall, tile, 4), 0.4 + 0.6 * _chance(wall, tile, 6)
    is_poster = left <= inside < left + width and bottom <= height < bottom + tall
    if _chance(wall, tile, 2) < 0.45 and is_poster:
        return (50.0 + 190.0 * _chance(wall, tile, 7)) * grain
    return 190.0 * grain


def _light(normal: float) -> float:
    return 0.8 + 0.22 * (1.0 + math.cos(normal - 0.6))


def _patch(place: Point) -> float:
    col, row = math.floor(place[0] / 1.7), math.floor(place[1] / 1.7)
    u, v = place[0] / 1.7 - col, place[1] / 1.7 - row
    weights = {(0, 0): (1 - u) * (1 - v), (1, 0): u * (1 - v), (0, 1): (1 - u) * v, (1, 1): u * v}
    lit = sum(weight * _chance(col + i, row + j, 11) for (i, j), weight in weights.items())
    return 0.88 + 0.12 * lit


def _girth(height: float) -> float:
    if height < 0.85:
        return 0.62 + 0.2 * height
    if height < 1.45:
        return 0.95
    return 0.45 * math.sqrt(max(1.0 - ((height - 1.6) / 0.15) ** 2, 0.0)) if height < 1.75 else 0.0


def _chance(a: int, b: int, c: int) -> float:
    mixed = ((a * 73856093) ^ (b * 19349663) ^ (c * 83492791)) % 2**32
    mixed ^= mixed >> 13
    mixed = (mixed * 1274126177) % 2**32
    mixed ^= mixed >> 16
    return mixed / 2.0**32
