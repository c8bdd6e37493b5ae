"""The pictures of the simulated camera: geometry, materials, light, noise, and the plain twin."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from drawing import draw
from naive import picture as naive
from pilotage.core.grid import OccupancyMap
from pilotage.robot.simulator.doors import doors_of
from pilotage.robot.simulator.picture import Painter
from pilotage.robot.simulator.picture_kernels import Lens, Scene, paint
from pilotage.robot.simulator.picture_params import PictureParams
from pilotage.robot.simulator.picture_surfaces import chance
from pilotage.robot.simulator.range_sensors import Surroundings
from pilotage.robot.simulator.walls import Walls

RIGHT_ANGLE = float(np.pi / 2.0)
CLEAN = PictureParams(width=80, height=60, noise=0.0, samples=1)
NOBODY = np.empty((0, 3))

HALL = draw("\n".join(["#" * 40, *["#" + "." * 38 + "#"] * 38, "#" * 40]), resolution=0.25)
"""9.5 m x 9.5 m inside, its lower left inner corner at (0.25, 0.25)."""


def corridor(doors: list[dict[str, object]]) -> Surroundings:
    """A wall from y = 4 to 4.2 across a room of 8 m x 8 m, with openings for the doors."""
    rows = [["."] * 160 for _ in range(160)]
    for y in (*range(80, 84), 159):
        rows[y] = ["#"] * 160
    for door in doors:
        (x0, _), (x1, _) = sorted(door["ends"])  # type: ignore[call-overload]
        for y in range(80, 84):
            rows[y][round(x0 / 0.05) : round(x1 / 0.05)] = ["."] * round((x1 - x0) / 0.05)
    world = draw("\n".join("".join(row) for row in reversed(rows)), resolution=0.05)
    return Surroundings(Walls.of(world, (), doors_of(doors)), NOBODY)


def taken(
    around: Surroundings, pose: tuple[float, float, float], params: PictureParams = CLEAN
) -> NDArray[np.uint8]:
    return Painter(params, RIGHT_ANGLE).picture(around, pose, np.random.default_rng(1))


def in_hall(world: OccupancyMap = HALL, people: NDArray[np.float64] = NOBODY) -> Surroundings:
    return Surroundings(Walls.of(world), people)


def test_floor_lies_below_the_wall_and_the_ceiling_above() -> None:
    picture = taken(in_hall(), (5.0, 5.0, 0.0))
    column = picture[:, 40].astype(int)
    assert column[0] > 150
    assert column[-1] < 110
    assert len(set(column)) > 10


def test_the_foot_of_a_wall_is_where_a_pinhole_camera_puts_it() -> None:
    pose = (4.75, 5.0, 0.0)  # 5 m before the wall, the lens 0.6 m high
    picture = taken(in_hall(), pose, replace(CLEAN, height=121))
    focal = 40.0
    foot = 60 + focal * 0.6 / 5.0
    slopes = np.abs(np.diff(picture[60:80, 40].astype(float)))
    assert 60 + int(np.argmax(slopes)) == pytest.approx(foot, abs=2.0)


def test_a_wall_twice_as_near_is_twice_as_high() -> None:
    params = replace(CLEAN, height=400)
    heights = []
    for distance in (4.0, 2.0):
        column = taken(in_hall(), (9.75 - distance, 5.0, 0.0), params)[:, 40].astype(float)
        skirting = np.flatnonzero(np.abs(np.diff(column)) > 20.0)
        heights.append(skirting.max() - 199.5)
    assert heights[1] == pytest.approx(2.0 * heights[0], rel=0.1)


def test_the_two_walls_of_a_corner_are_lit_differently() -> None:
    picture = taken(in_hall(), (7.0, 7.0, np.pi / 4.0)).astype(float)
    assert abs(np.median(picture[25:30, 20:38]) - np.median(picture[25:30, 42:60])) > 4.0


def test_a_frame_is_darker_than_wall_and_leaf_and_stands_at_both_jambs() -> None:
    around = corridor([{"ends": [[3.6, 4.075], [4.5, 4.075]], "state": "closed"}])
    params = replace(CLEAN, width=320)
    row = taken(around, (4.05, 2.0, RIGHT_ANGLE), params)[35].astype(float)
    columns = np.arange(320)
    x = 4.05 + (columns - 159.5) / 160.0 * 2.0
    leaf = (x > 3.75) & (x < 4.35)
    left, right = (x > 3.545) & (x < 3.59), (x > 4.51) & (x < 4.555)
    wall = (x > 2.8) & (x < 3.4)
    assert row[left].max() < 0.75 * row[leaf].min()
    assert row[right].max() < 0.75 * row[leaf].min()
    assert np.median(row[leaf]) < 0.9 * np.median(row[wall])


def test_through_an_open_door_the_room_behind_is_seen_under_a_lintel() -> None:
    params = replace(CLEAN, width=320, height=400)
    opened = corridor([{"ends": [[3.6, 4.1], [4.5, 4.1]]}])
    column = taken(opened, (4.05, 2.0, RIGHT_ANGLE), params)[:, 160].astype(float)
    head = round(199.5 - 160.0 * (2.085 - 0.6) / 2.1)
    assert column[head] < 0.6 * min(column[head - 8], column[head + 8])
    shut = corridor([{"ends": [[3.6, 4.1], [4.5, 4.1]], "state": "closed"}])
    other = taken(shut, (4.05, 2.0, RIGHT_ANGLE), params)[:, 160].astype(float)
    assert np.abs(column - other).max() > 20.0


def test_a_person_hides_the_wall_as_far_up_as_people_reach() -> None:
    params = replace(CLEAN, height=400)
    empty = taken(in_hall(), (5.0, 5.0, 0.0), params).astype(float)
    shown = taken(in_hall(people=np.array([[7.0, 5.0, 0.22]])), (5.0, 5.0, 0.0), params)
    changed = np.argwhere(np.abs(shown.astype(float) - empty) > 3.0)
    top, left = changed.min(axis=0)
    bottom, right = changed.max(axis=0)
    assert left > 30
    assert right < 49
    assert top == pytest.approx(199.5 - 40.0 * (1.75 - 0.6) / 2.0, abs=3.0)
    assert bottom == pytest.approx(199.5 + 40.0 * 0.6 / 2.0, abs=3.0)


def test_a_person_behind_a_wall_is_not_seen() -> None:
    around = corridor([])
    behind = Surroundings(around.walls, np.array([[4.0, 6.0, 0.22]]))
    pose = (4.0, 2.0, RIGHT_ANGLE)
    assert np.array_equal(taken(around, pose), taken(behind, pose))


def test_the_texture_stays_where_it_is_when_the_camera_moves() -> None:
    params = replace(CLEAN, width=160, height=80)
    near, far = (taken(in_hall(), (9.75 - d, 5.0, 0.0), params).astype(float) for d in (2.0, 4.0))
    small = near.reshape(40, 2, 80, 2).mean(axis=(1, 3))
    middle = far[20:60, 40:120]
    wall = np.abs(np.arange(40) - 19.5) < 4
    agree = np.corrcoef(small[wall].ravel(), middle[wall].ravel())[0, 1]
    assert agree > 0.5


def test_noise_has_the_stated_size_and_differs_from_picture_to_picture() -> None:
    painter = Painter(replace(CLEAN, noise=4.0), RIGHT_ANGLE)
    rng = np.random.default_rng(3)
    one, other = (painter.picture(in_hall(), (5.0, 5.0, 0.0), rng).astype(float) for _ in "ab")
    assert np.std(one - other) == pytest.approx(4.0 * np.sqrt(2.0), rel=0.05)


def test_a_longer_exposure_is_brighter_until_it_burns_out() -> None:
    normal, bright, burnt = (
        taken(in_hall(), (5.0, 5.0, 0.0), replace(CLEAN, exposure=exposure)).astype(float)
        for exposure in (0.5, 1.0, 20.0)
    )
    assert np.median(bright) == pytest.approx(2.0 * np.median(normal), rel=0.03)
    assert (burnt == 255.0).all()


def test_the_frame_of_the_map_does_not_matter() -> None:
    doors: list[dict[str, object]] = [{"ends": [[3.6, 4.075], [4.5, 4.075]], "state": "closed"}]
    around = corridor(doors)
    turned = replace(around.walls.geometry, origin=(10.0, -3.0, RIGHT_ANGLE))
    moved_ends = [[10.0 - 4.075, -3.0 + 3.6], [10.0 - 4.075, -3.0 + 4.5]]
    moved_doors = doors_of([{"ends": moved_ends, "state": "closed"}])
    walls = Walls(turned, around.walls.stops_beams, around.walls.stops_bodies, moved_doors)
    here = taken(around, (4.0, 2.0, 1.2))
    there = taken(Surroundings(walls, NOBODY), (8.0, 1.0, 1.2 + RIGHT_ANGLE))
    assert np.abs(here.astype(int) - there.astype(int)).max() <= 2


@pytest.mark.parametrize("field", ["width", "height", "samples", "exposure", "lens_height"])
def test_a_camera_without_size_or_light_is_refused(field: str) -> None:
    with pytest.raises(ValueError, match=field):
        PictureParams(**{field: 0})


def test_a_picture_that_would_hold_up_the_robot_is_refused() -> None:
    with pytest.raises(ValueError, match="4096"):
        PictureParams(width=5000)


def random_scene(rng: np.random.Generator) -> tuple[Lens, Scene]:
    is_wall = rng.random((30, 30)) < 0.06
    is_wall[[0, -1]] = is_wall[:, [0, -1]] = True
    is_wall[12:18, 12:18] = False
    segments = rng.uniform(0.5, 7.0, (3, 2))
    turns = rng.uniform(-np.pi, np.pi, 3)
    ends = segments + np.stack([np.cos(turns), np.sin(turns)], axis=1)
    both = np.hstack([segments, ends])
    x, y = rng.uniform(3.1, 4.4, 2)
    people = np.column_stack([rng.uniform(1.0, 6.5, (2, 2)), np.full(2, 0.22)])
    order = np.argsort(-np.hypot(people[:, 0] - x, people[:, 1] - y))
    lens = Lens(x, y, float(rng.uniform(-np.pi, np.pi)), 0.6, 20.0, 11.5, 8.5, 2)
    return lens, Scene(is_wall, 0.25, both[:2], both[2:], people[order], 0.07)


@pytest.mark.parametrize("seed", range(6))
def test_the_kernel_paints_what_plain_geometry_says(seed: int) -> None:
    lens, scene = random_scene(np.random.default_rng(seed))
    painted = np.empty((18, 24), np.float32)
    paint(painted, lens, scene)
    expected = naive.paint((18, 24), lens, scene)
    # A sight line right along an edge may fall on either side of it by rounding.
    assert (np.abs(painted - expected) > 0.05).mean() < 0.01


def test_chance_is_spread_evenly_over_neighbouring_places() -> None:
    drawn = np.array([chance(a, b, 1) for a in range(-40, 40) for b in range(-40, 40)])
    assert drawn.min() >= 0.0
    assert drawn.max() < 1.0
    assert drawn.mean() == pytest.approx(0.5, abs=0.02)
    counts, _ = np.histogram(drawn, 10, (0.0, 1.0))
    assert counts.min() > 0.8 * 640
