"""Laws of what a camera sees, wherever the world lies and wherever the camera points."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import OCCUPIED, GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.landmark_model import landmark_likelihoods
from pilotage.localizer.landmark_sightings import Sightings
from pilotage.localizer.measurement import landmarks_measurement
from pilotage.robot.simulator.camera import Camera, CameraParams, Picture, RecognitionParams
from pilotage.robot.simulator.range_sensors import Surroundings
from pilotage.robot.simulator.walls import Walls

seeds = st.integers(0, 2**32 - 1)
pans = st.floats(-1.5, 1.5)
motions = st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(-3.1, 3.1))

ROWS, COLS, CELL = 40, 60, 0.1
EXACT = CameraParams(
    range_share=1e-9,
    bearing_sigma=1e-9,
    recognition=RecognitionParams(half_distance=100.0, width=0.1),
)


class World:
    """Random walls, posts, people and a robot, all carried along by one rigid motion."""

    def __init__(self, seed: int, motion: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        rng = np.random.default_rng(seed)
        self.cells = np.where(rng.random((ROWS, COLS)) < 0.02, OCCUPIED, 0).astype(np.int8)
        places = rng.uniform((0.0, 0.0), (COLS * CELL, ROWS * CELL), (15, 2))
        people = rng.uniform((0.0, 0.0), (COLS * CELL, ROWS * CELL), (2, 2))
        at = np.array([*rng.uniform((1.0, 1.0), (5.0, 3.0)), rng.uniform(-np.pi, np.pi)])
        self.discs = np.column_stack([se2.transform_points(motion, people), np.full(2, 0.2)])
        self.pose = se2.compose(motion, at)
        kinds = tuple(rng.choice(["post", "line"], 15).tolist())
        self.landmarks = LandmarkMap(se2.transform_points(motion, places), kinds, (None,) * 15)
        self.geometry = GridGeometry(ROWS, COLS, CELL, motion)

    @property
    def around(self) -> Surroundings:
        return Surroundings(Walls.of(OccupancyMap(self.geometry, self.cells)), self.discs)

    def picture(self, params: CameraParams, pan: float, noise: int = 5) -> Picture:
        camera = Camera(params, self.landmarks)
        camera.look(pan)
        camera.turn(10.0)
        return camera.picture(self.around, self.pose, np.random.default_rng(noise))


def off_axis(bearings: NDArray[np.float64], pan: float) -> NDArray[np.float64]:
    return np.abs(wrap(bearings - pan))


@given(seeds, motions, pans)
def test_carrying_the_whole_world_changes_nothing_that_is_seen(
    seed: int, motion: tuple[float, float, float], pan: float
) -> None:
    here = World(seed).picture(CameraParams(false_sightings=0.5), pan)
    there = World(seed, motion).picture(CameraParams(false_sightings=0.5), pan)
    assert np.array_equal(here.landmarks, there.landmarks)
    assert np.allclose(here.ranges, there.ranges, atol=1e-6)
    assert np.allclose(off_axis(here.bearings - there.bearings, 0.0), 0.0, atol=1e-6)


@given(seeds, pans)
def test_an_exact_camera_sees_only_what_lies_in_its_field_of_view(seed: int, pan: float) -> None:
    picture = World(seed).picture(EXACT, pan)
    assert (off_axis(picture.bearings, pan) <= EXACT.field_of_view / 2.0 + 1e-6).all()
    assert (picture.ranges >= EXACT.range_min).all()


@given(seeds, pans)
def test_a_wider_view_shows_what_a_narrow_one_shows_and_perhaps_more(seed: int, pan: float) -> None:
    narrow = World(seed).picture(CameraParams(), pan)
    wide = World(seed).picture(CameraParams(field_of_view=4.0), pan)
    assert set(narrow.landmarks) <= set(wide.landmarks)


@given(seeds, pans)
def test_walls_and_people_only_ever_hide(seed: int, pan: float) -> None:
    world = World(seed)
    cluttered = world.picture(CameraParams(), pan)
    world.cells[:] = 0
    world.discs = np.empty((0, 3))
    assert set(cluttered.landmarks) <= set(world.picture(CameraParams(), pan).landmarks)


@given(seeds, pans)
def test_a_camera_that_recognises_farther_misses_nothing_it_saw_before(
    seed: int, pan: float
) -> None:
    near = CameraParams(recognition=RecognitionParams(2.0, 0.3))
    far = CameraParams(recognition=RecognitionParams(3.0, 0.3))
    world = World(seed)
    assert set(world.picture(near, pan).landmarks) <= set(world.picture(far, pan).landmarks)


@given(seeds, pans, st.floats(0.0, 0.5))
def test_the_localizer_takes_pictures_of_any_pan_without_error(
    seed: int, pan: float, mount_x: float
) -> None:
    world = World(seed)
    picture = world.picture(replace(EXACT, mount_x=mount_x), pan)
    count = len(picture.landmarks)
    seen = Sightings(
        picture.ranges,
        picture.bearings,
        np.full(count, 0.01),
        np.full(count, 0.01),
        [world.landmarks.classes[i] for i in picture.landmarks],
        [None] * count,
    )
    from_base = landmarks_measurement(seen, (mount_x, 0.0, 0.0)).landmarks
    assert from_base is not None
    (log_likelihood,) = landmark_likelihoods(world.pose[None], from_base, world.landmarks)
    assert log_likelihood >= -1e-6
