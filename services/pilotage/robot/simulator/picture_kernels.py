"""The kernel that paints a picture of a simulated building, column by column.

As in the first games with a view from within (Lode Vandevenne, "Raycasting"): one ray for each
column finds the wall, and its distance says where on the column the wall begins and ends. Lengths
are in m in the frame of the grid.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.cell_traversal import cast_ray_in_grid
from pilotage.core.jit import kernel
from pilotage.robot.simulator.picture_surfaces import (
    FRAME,
    FRAME_ALBEDO,
    LEAF,
    LEAF_ALBEDO,
    WALL,
    WALL_ALBEDO,
    chance,
    grain,
    light_on,
    patch,
    wall_albedo,
)

ON_LEAF = 0.06
"""m from the middle of a leaf within which a hit is on it: cells are steps along a slant."""
ON_JAMB = 0.012
"""m beside a jamb within which a hit is on its inner side."""
DEEPEST_FRAME = 0.26
"""m from the line of a door at which the face of its wall may lie."""
CEILING, LINTEL, FRAME_HEAD = 2.6, 2.05, 0.07
"""Height of rooms and doors, and of the frame above a door, m."""
FARTHEST = 60.0
"""m; what is farther is as dark as the end of a long corridor."""


class Lens(NamedTuple):
    """Where the camera is in the grid, and how it projects (pixel centres at whole numbers)."""

    x: float
    y: float
    theta: float
    height: float
    focal: float
    centre: float
    horizon: float
    samples: int


class Scene(NamedTuple):
    """What there is to see.

    `is_wall` (rows, cols) of `cell` m; `doors` (n, 4): first and second jamb; `leaves` (k, 4):
    hinge and end of those that are shut or ajar; `people` (p, 3): x, y, radius, farthest first;
    `frame`: width of door frames, m.
    """

    is_wall: NDArray[np.bool_]
    cell: float
    doors: NDArray[np.float64]
    leaves: NDArray[np.float64]
    people: NDArray[np.float64]
    frame: float


class Hit(NamedTuple):
    """What a ray ends on, `distance` m away: its place, its normal [rad] and what it is made of."""

    distance: float
    x: float
    y: float
    normal: float
    material: int


@kernel
def paint(picture: NDArray[np.float32], lens: Lens, scene: Scene) -> None:
    """Paint a picture (h, w) of shades 0 to 255, each column from several rays."""
    rows, cols = picture.shape
    column = np.empty(rows, np.float32)
    for col in range(cols):
        picture[:, col] = 0.0
        for sample in range(lens.samples):
            u = col - 0.5 + (sample + 0.5) / lens.samples
            aside = math.atan((lens.centre - u) / lens.focal)
            _paint_column(column, aside, lens, scene)
            for row in range(rows):
                picture[row, col] += column[row] / lens.samples


@kernel
def _paint_column(column: NDArray[np.float32], aside: float, lens: Lens, scene: Scene) -> None:
    """Paint what a ray `aside` rad left of the axis meets, from the floor to the ceiling."""
    direction = lens.theta + aside
    hit = cast(direction, lens, scene)
    scale = lens.focal / math.cos(aside)
    _paint_rooms(column, hit, scale, lens)
    _paint_lintels(column, (direction, scale, hit.distance), lens, scene)
    _paint_people(column, (direction, scale, hit.distance), lens, scene)


@kernel
def cast(direction: float, lens: Lens, scene: Scene) -> Hit:
    """Return what a ray ends on."""
    cell = scene.cell
    far = cast_ray_in_grid(scene.is_wall, lens.x / cell, lens.y / cell, direction, FARTHEST / cell)
    if not far < FARTHEST / cell:
        return Hit(FARTHEST, 0.0, 0.0, 0.0, WALL)
    dx, dy = math.cos(direction), math.sin(direction)
    x, y = lens.x + far * cell * dx, lens.y + far * cell * dy
    off_col, off_row = abs(x / cell - round(x / cell)), abs(y / cell - round(y / cell))
    if off_col < off_row:
        normal = math.pi if dx > 0.0 else 0.0
    else:
        normal = -math.pi / 2.0 if dy > 0.0 else math.pi / 2.0
    return _named(Hit(far * cell, x, y, normal, WALL), direction, scene)


@kernel
def _named(hit: Hit, direction: float, scene: Scene) -> Hit:
    """Return the hit with what it is made of."""
    for i in range(len(scene.leaves)):
        along, across, length = _beside(scene.leaves[i], hit.x, hit.y)
        if abs(across) < ON_LEAF and 0.0 <= along <= length:
            leaf = scene.leaves[i]
            normal = math.atan2(leaf[3] - leaf[1], leaf[2] - leaf[0]) + math.pi / 2.0
            if math.cos(normal - direction) > 0.0:
                normal += math.pi
            return Hit(hit.distance, hit.x, hit.y, normal, LEAF)
    for i in range(len(scene.doors)):
        along, across, length = _beside(scene.doors[i], hit.x, hit.y)
        beyond = max(-along, along - length)
        if abs(across) < DEEPEST_FRAME and -ON_JAMB < beyond < scene.frame:
            return Hit(hit.distance, hit.x, hit.y, hit.normal, FRAME)
    return hit


@kernel
def _beside(segment: NDArray[np.float64], x: float, y: float) -> tuple[float, float, float]:
    """Return how far along and how far beside a segment (4,) a point lies, and its length."""
    dx, dy = segment[2] - segment[0], segment[3] - segment[1]
    length = math.hypot(dx, dy)
    px, py = x - segment[0], y - segment[1]
    return (px * dx + py * dy) / length, (py * dx - px * dy) / length, length


@kernel
def _paint_rooms(column: NDArray[np.float32], hit: Hit, scale: float, lens: Lens) -> None:
    """Paint the wall that was hit, the floor before it and the ceiling."""
    light = light_on(hit.normal) * patch(hit.x, hit.y) / (1.0 + 0.02 * hit.distance)
    runs_along_y = abs(math.cos(hit.normal)) > 0.5
    place = hit.y if runs_along_y else hit.x
    wall = round((hit.x if runs_along_y else hit.y) / 0.05)
    for row in range(len(column)):
        height = lens.height + (lens.horizon - row) * hit.distance / scale
        if height < 0.0:
            near = lens.height * scale / (row - lens.horizon)
            column[row] = 105.0 / (1.0 + 0.04 * near)
        elif height > CEILING:
            column[row] = 215.0 / (
                1.0 + 0.03 * (CEILING - lens.height) * scale / (lens.horizon - row)
            )
        elif hit.material == WALL:
            column[row] = light * wall_albedo(wall, place, height) * grain(wall, place, height)
        else:
            column[row] = light * (LEAF_ALBEDO if hit.material == LEAF else FRAME_ALBEDO)


@kernel
def _paint_lintels(
    column: NDArray[np.float32], ray: tuple[float, float, float], lens: Lens, scene: Scene
) -> None:
    """Paint the wall above the doorways that a ray passes through before it ends.

    `ray`: its direction, its pixels per radian of height, and where it ends.
    """
    direction, scale, end = ray
    dx, dy = math.cos(direction), math.sin(direction)
    for i in range(len(scene.doors)):
        distance = _meets(scene.doors[i], (lens.x, lens.y, dx, dy))
        if distance <= 0.05 or distance > end + 0.05:
            continue
        lit = light_on(direction + math.pi) * patch(lens.x + distance * dx, lens.y + distance * dy)
        lit /= 1.0 + 0.02 * distance
        for row in range(len(column)):
            height = lens.height + (lens.horizon - row) * distance / scale
            if LINTEL <= height <= CEILING:
                is_frame = height < LINTEL + FRAME_HEAD
                column[row] = lit * (FRAME_ALBEDO if is_frame else WALL_ALBEDO)


@kernel
def _meets(segment: NDArray[np.float64], ray: tuple[float, float, float, float]) -> float:
    """Return how far along a ray (x, y, dx, dy) it crosses a segment (4,); -1 if it does not."""
    x, y, dx, dy = ray
    ex, ey = segment[2] - segment[0], segment[3] - segment[1]
    across = dx * ey - dy * ex
    if abs(across) < 1e-9:
        return -1.0
    px, py = segment[0] - x, segment[1] - y
    share = (px * dy - py * dx) / across
    if share < 0.0 or share > 1.0:
        return -1.0
    return float((px * ey - py * ex) / across)


@kernel
def _paint_people(
    column: NDArray[np.float32], ray: tuple[float, float, float], lens: Lens, scene: Scene
) -> None:
    """Paint the people who stand in a ray's way, the farthest first."""
    direction, scale, end = ray
    dx, dy = math.cos(direction), math.sin(direction)
    for i in range(len(scene.people)):
        px, py = scene.people[i, 0] - lens.x, scene.people[i, 1] - lens.y
        ahead, miss = px * dx + py * dy, abs(py * dx - px * dy)
        radius = scene.people[i, 2]
        if ahead <= 0.2 or miss >= radius or ahead > end:
            continue
        size = round(1000.0 * radius)
        round_off = 0.6 + 0.4 * math.sqrt(1.0 - (miss / radius) ** 2)
        for row in range(len(column)):
            height = lens.height + (lens.horizon - row) * ahead / scale
            if height >= 0.0 and miss < radius * _girth(height):
                column[row] = round_off * (45.0 + 90.0 * chance(i, size, int(height > 0.85)))


@kernel
def _girth(height: float) -> float:
    """Return how wide a person is at a height, as a share of the widest."""
    if height < 0.85:
        return 0.62 + 0.2 * height
    if height < 1.45:
        return 0.95
    if height < 1.75:
        return 0.45 * math.sqrt(max(1.0 - ((height - 1.6) / 0.15) ** 2, 0.0))
    return 0.0


def warm_up() -> None:
    """Compile the kernel for the types met in service."""
    lens = Lens(0.5, 0.5, 0.0, 0.6, 10.0, 0.5, 0.5, 1)
    none = np.empty((0, 4))
    scene = Scene(np.ones((1, 1), bool), 1.0, none, none, np.empty((0, 3)), 0.07)
    paint(np.empty((2, 2), np.float32), lens, scene)
