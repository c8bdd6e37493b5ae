"""What surfaces of a simulated building look like: shades fixed to the world; kernels.

Everything is decided by place alone, so a wall looks the same whenever and from wherever it is
seen: plaster with grain, skirting boards, posters and pipes (false edges, as in real buildings),
frames and leaves of doors, lit from one side.
"""

import math

from pilotage.core.jit import kernel

WALL, FRAME, LEAF = 0, 1, 2

WALL_ALBEDO, FRAME_ALBEDO, LEAF_ALBEDO, SKIRTING_ALBEDO = 190.0, 75.0, 140.0, 95.0
SKIRTING_HEIGHT = 0.10
TILE = 2.6
"""m of wall of which at most one poster and one pipe are hung."""
POSTER_SHARE, PIPE_SHARE = 0.45, 0.12
PIPE_WIDTH = 0.06
GRAIN, PATCH = 0.04, 1.7
"""Sizes of plaster's grain and of the light's unevenness, m."""
LIGHT_FROM = 0.6
"""Direction that the light comes from, rad, in the frame of the grid."""


@kernel
def chance(a: int, b: int, c: int) -> float:
    """Return a number in [0, 1) that three whole numbers decide, as a random one would be."""
    mixed = (a * 73856093) ^ (b * 19349663) ^ (c * 83492791)
    mixed = mixed & 0xFFFFFFFF
    mixed = mixed ^ (mixed >> 13)
    mixed = (mixed * 1274126177) & 0xFFFFFFFF
    mixed = mixed ^ (mixed >> 16)
    return mixed / 4294967296.0


@kernel
def light_on(normal: float) -> float:
    """Return how bright a face with this normal [rad] is, 0.8 to 1.24 (Lambert and ambient)."""
    return 0.8 + 0.22 * (1.0 + math.cos(normal - LIGHT_FROM))


@kernel
def wall_albedo(wall: int, place: float, height: float) -> float:
    """Return the albedo (0 to 255) of a wall at `place` m along and `height` m above the floor.

    `wall` is the number of the grid line that it lies on.
    """
    if height < SKIRTING_HEIGHT:
        return SKIRTING_ALBEDO
    tile = math.floor(place / TILE)
    inside = place - tile * TILE
    if chance(wall, tile, 1) < PIPE_SHARE and abs(inside - TILE / 2.0) < PIPE_WIDTH / 2.0:
        return 120.0
    if chance(wall, tile, 2) < POSTER_SHARE:
        width = 0.35 + 0.6 * chance(wall, tile, 3)
        left = (TILE - width) * chance(wall, tile, 4)
        bottom = 0.8 + 0.5 * chance(wall, tile, 5)
        tall = 0.4 + 0.6 * chance(wall, tile, 6)
        if left <= inside < left + width and bottom <= height < bottom + tall:
            return 50.0 + 190.0 * chance(wall, tile, 7)
    return WALL_ALBEDO


@kernel
def grain(wall: int, place: float, height: float) -> float:
    """Return the factor by which plaster is darker or lighter at a place, about 1."""
    row, col = math.floor(height / GRAIN), math.floor(place / GRAIN)
    return 0.975 + 0.05 * chance(wall, col, row)


@kernel
def patch(x: float, y: float) -> float:
    """Return how much of the lamps' light reaches a place on the floor, 0.88 to 1, smoothly."""
    col, row = math.floor(x / PATCH), math.floor(y / PATCH)
    u, v = x / PATCH - col, y / PATCH - row
    lower = (1.0 - u) * chance(col, row, 11) + u * chance(col + 1, row, 11)
    upper = (1.0 - u) * chance(col, row + 1, 11) + u * chance(col + 1, row + 1, 11)
    return 0.88 + 0.12 * ((1.0 - v) * lower + v * upper)
