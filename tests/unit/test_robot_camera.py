"""The simulated camera: what it has in view, what it recognises, and how exactly."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from drawing import draw
from pilotage.core.landmark_map import NO_LANDMARKS, LandmarkMap, landmarks_of
from pilotage.robot.simulator.camera import Camera, CameraParams, Picture, RecognitionParams
from pilotage.robot.simulator.range_sensors import Surroundings
from pilotage.robot.simulator.walls import Walls
from robot_world import ROOM, simulation_in

NOBODY = np.empty((0, 3))
SHARP = CameraParams(
    field_of_view=float(np.deg2rad(62.0)),
    mount_x=0.0,
    range_share=1e-9,
    bearing_sigma=1e-9,
    recognition=RecognitionParams(half_distance=50.0, width=0.1),
)
"""A camera that errs nowhere and sees everything in its field of view."""

OPEN = draw("\n".join(["." * 40] * 40), resolution=0.5)
"""20 m x 20 m without a wall."""

CENTRE = np.array([10.0, 10.0, 0.0])


def ring(radius: float = 2.0) -> LandmarkMap:
    """Landmarks every 10 degrees round the centre of OPEN, named by their direction."""
    degrees = range(-180, 180, 10)
    angles = np.deg2rad(degrees)
    places = CENTRE[:2] + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return LandmarkMap(places, ("post",) * 36, tuple(str(d) for d in degrees))


def seen(
    camera: Camera,
    pose: NDArray[np.float64] = CENTRE,
    around: Surroundings | None = None,
    seed: int = 1,
) -> Picture:
    around = around or Surroundings(Walls.of(OPEN), NOBODY)
    return camera.picture(around, pose, np.random.default_rng(seed))


def names(camera: Camera, picture: Picture) -> set[str | None]:
    return {camera.landmarks.identities[i] for i in picture.landmarks}


def pointed(params: CameraParams, landmarks: LandmarkMap, pan: float) -> Camera:
    camera = Camera(params, landmarks)
    camera.look(pan)
    camera.turn(100.0)
    return camera


def test_ahead_lies_what_is_within_half_the_field_of_view_of_the_axis() -> None:
    camera = Camera(SHARP, ring())
    assert names(camera, seen(camera)) == {"-30", "-20", "-10", "0", "10", "20", "30"}


def test_a_camera_that_is_panned_sees_to_the_side_and_says_bearings_off_the_robots_axis() -> None:
    camera = pointed(SHARP, ring(), np.deg2rad(85.0))
    picture = seen(camera)
    assert names(camera, picture) == {"60", "70", "80", "90", "100", "110"}
    said = np.rad2deg(picture.bearings)
    assert said == pytest.approx([float(str(n)) for n in (60, 70, 80, 90, 100, 110)])


def test_a_robot_that_has_turned_takes_its_view_along() -> None:
    camera = Camera(SHARP, ring())
    picture = seen(camera, np.array([10.0, 10.0, np.pi]))
    assert names(camera, picture) == {"-180", "-170", "-160", "-150", "150", "160", "170"}
    assert np.abs(picture.bearings).max() < np.deg2rad(31.0)


def test_ranges_count_from_the_pan_joint() -> None:
    camera = Camera(replace(SHARP, mount_x=0.5, field_of_view=0.1), ring())
    (distance,) = seen(camera).ranges
    assert distance == pytest.approx(1.5)


def test_a_full_turn_of_view_hides_nothing() -> None:
    camera = Camera(replace(SHARP, field_of_view=2.0 * np.pi), ring())
    assert len(seen(camera).landmarks) == 36


def test_what_is_at_the_robots_feet_is_below_the_picture() -> None:
    feet = landmarks_of([{"class": "line", "x": 10.05, "y": 10.0}])
    assert len(seen(Camera(SHARP, feet)).landmarks) == 0
    assert len(seen(Camera(replace(SHARP, range_min=0.01), feet)).landmarks) == 1


def test_the_joint_turns_at_its_own_speed_towards_the_newest_wish() -> None:
    camera = Camera(replace(SHARP, pan_speed=2.0), NO_LANDMARKS)
    camera.look(1.0)
    camera.turn(0.1)
    assert camera.pan == pytest.approx(0.2)
    camera.look(-0.1)
    for _ in range(10):
        camera.turn(0.1)
    assert camera.pan == pytest.approx(-0.1)


@pytest.mark.parametrize(("wish", "goes_to"), [(3.0, 1.2), (-3.0, -1.2), (0.4, 0.4)])
def test_the_joint_stops_at_its_limits(wish: float, goes_to: float) -> None:
    assert pointed(replace(SHARP, pan_limit=1.2), NO_LANDMARKS, wish).pan == pytest.approx(goes_to)


def test_a_wall_hides_what_stands_behind_it_and_nothing_else() -> None:
    world = draw(
        """
        ...........
        ...........
        .....#.....
        ...........
        ...........
        """
    )
    landmarks = landmarks_of(
        [
            {"class": "post", "x": 9.5, "y": 2.5, "id": "behind"},
            {"class": "post", "x": 4.5, "y": 2.5, "id": "before"},
            {"class": "post", "x": 9.5, "y": 3.9, "id": "beside"},
        ]
    )
    camera = Camera(SHARP, landmarks)
    around = Surroundings(Walls.of(world), NOBODY)
    picture = seen(camera, np.array([0.5, 2.5, 0.0]), around)
    assert names(camera, picture) == {"before", "beside"}


def test_a_landmark_on_a_wall_or_in_a_post_is_seen_from_its_own_side_only() -> None:
    sign = landmarks_of([{"class": "sign", "x": 3.05, "y": 1.5}])
    world = draw(
        """
        ...#...
        ...#...
        ...#...
        """
    )
    around = Surroundings(Walls.of(world), NOBODY)
    camera = Camera(SHARP, sign)
    assert len(seen(camera, np.array([1.0, 1.5, 0.0]), around).landmarks) == 1
    assert len(seen(camera, np.array([6.0, 1.5, np.pi]), around).landmarks) == 0


def test_a_person_stands_in_the_way() -> None:
    camera = Camera(replace(SHARP, field_of_view=0.1), ring())
    between = Surroundings(Walls.of(OPEN), np.array([[11.0, 10.0, 0.2]]))
    aside = Surroundings(Walls.of(OPEN), np.array([[11.0, 10.5, 0.2]]))
    assert len(seen(camera, around=between).landmarks) == 0
    assert len(seen(camera, around=aside).landmarks) == 1


def recognised(params: CameraParams, distance: float, kind: str = "post") -> float:
    """How often a landmark straight ahead is recognised: 2,000 of them stand in one place."""
    places = np.tile([0.25 + distance, 10.0], (2000, 1))
    camera = Camera(params, LandmarkMap(places, (kind,) * 2000, (None,) * 2000))
    return len(seen(camera, np.array([0.25, 10.0, 0.0])).landmarks) / 2000.0


@pytest.mark.parametrize(
    ("distance", "odds"), [(1.0, 0.993), (3.4, 0.731), (4.0, 0.5), (4.6, 0.269), (7.0, 0.007)]
)
def test_recognition_falls_with_distance_by_the_papers_curve(distance: float, odds: float) -> None:
    params = replace(SHARP, recognition=RecognitionParams(half_distance=4.0, width=0.6))
    assert recognised(params, distance) == pytest.approx(odds, abs=0.035)


def test_a_class_may_be_recognised_from_farther_than_others() -> None:
    far = RecognitionParams(half_distance=8.0, width=0.5)
    near = RecognitionParams(half_distance=2.0, width=0.5)
    params = replace(SHARP, recognition=near, recognition_by_class={"goal": far})
    assert recognised(params, 5.0, "goal") > 0.99
    assert recognised(params, 5.0, "line") < 0.01


def test_nothing_is_recognised_from_the_other_end_of_the_world() -> None:
    assert RecognitionParams(1.0, 0.001).probability(np.array([1e9]))[0] == pytest.approx(0.0)


@pytest.mark.parametrize("distance", [1.0, 3.0])
def test_noise_is_a_tenth_of_the_range_and_ten_degrees(distance: float) -> None:
    params = replace(CameraParams(), mount_x=0.0, recognition=SHARP.recognition)
    places = np.tile([10.0 + distance, 10.0], (4000, 1))
    camera = Camera(params, LandmarkMap(places, ("post",) * 4000, (None,) * 4000))
    picture = seen(camera)
    assert len(picture.landmarks) == 4000
    assert picture.ranges.mean() == pytest.approx(distance, rel=0.01)
    assert picture.ranges.std() == pytest.approx(0.1 * distance, rel=0.05)
    assert np.rad2deg(picture.bearings.std()) == pytest.approx(10.0, rel=0.05)
    assert np.rad2deg(picture.bearings.mean()) == pytest.approx(0.0, abs=0.6)


def test_bearings_wrap_behind_the_robot() -> None:
    behind = LandmarkMap(np.tile([8.0, 10.0], (500, 1)), ("post",) * 500, (None,) * 500)
    params = replace(CameraParams(), field_of_view=2.0 * np.pi)
    bearings = seen(Camera(params, behind)).bearings
    assert ((bearings >= -np.pi) & (bearings < np.pi)).all()
    assert (bearings > 3.0).any()
    assert (bearings < -3.0).any()


def test_false_sightings_come_as_often_as_stated_and_lie_in_the_picture() -> None:
    params = replace(SHARP, false_sightings=0.3, recognition=RecognitionParams(3.0, 0.5))
    hidden = landmarks_of([{"class": "post", "x": 1.0, "y": 10.0, "id": "behind"}])
    camera = pointed(params, hidden, 1.0)
    rng = np.random.default_rng(7)
    around = Surroundings(Walls.of(OPEN), NOBODY)
    pictures = [camera.picture(around, CENTRE, rng) for _ in range(2000)]
    shown = [picture for picture in pictures if len(picture.landmarks)]
    assert len(shown) / 2000 == pytest.approx(0.3, abs=0.04)
    bearings = np.concatenate([picture.bearings for picture in shown])
    assert np.abs(bearings - 1.0).max() <= np.deg2rad(31.0)
    assert max(picture.ranges.max() for picture in shown) <= 3.0


def test_a_camera_among_no_landmarks_sees_nothing_and_mistakes_nothing() -> None:
    picture = seen(Camera(replace(SHARP, false_sightings=1.0), NO_LANDMARKS))
    assert len(picture.landmarks) == len(picture.ranges) == len(picture.bearings) == 0


def test_what_is_in_view_does_not_change_the_noise_of_later_pictures() -> None:
    later = []
    for pan in (0.0, 1.5):
        camera, rng = pointed(CameraParams(), ring(), pan), np.random.default_rng(3)
        camera.picture(Surroundings(Walls.of(OPEN), NOBODY), CENTRE, rng)
        later.append(rng.random())
    assert later[0] == later[1]


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"field_of_view": 0.0}, "field_of_view must be more than 0"),
        ({"field_of_view": 60.0}, "field_of_view must be a full turn at most; it is in rad"),
        ({"pan_limit": 90.0}, "pan_limit must be half a turn at most; it is in rad"),
        ({"pan_speed": -1.0}, "pan_speed must not be negative"),
        ({"range_share": 0.0}, "range_share must be more than 0"),
        ({"bearing_sigma": 0.0}, "bearing_sigma must be more than 0"),
        ({"false_sightings": 1.5}, "false_sightings must be 1 at most, it is 1.5"),
    ],
)
def test_a_camera_that_cannot_be_is_refused(wrong: dict[str, Any], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        CameraParams(**wrong)


@pytest.mark.parametrize("wrong", [{"half_distance": 0.0}, {"width": 0.0}, {"width": -1.0}])
def test_a_recognition_without_reach_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="must"):
        RecognitionParams(**wrong)


def test_a_robot_has_a_camera_if_there_is_something_to_see_or_it_was_asked_for() -> None:
    landmarks = landmarks_of([{"class": "post", "x": 1.0, "y": 1.0}])
    assert simulation_in().camera is None
    assert simulation_in(landmarks=landmarks).camera is not None
    asked = simulation_in(params=replace(simulation_in().params, camera=CameraParams()))
    assert asked.camera is not None


def test_the_camera_turns_while_the_world_goes_on() -> None:
    simulation = simulation_in(ROOM, landmarks=landmarks_of([{"class": "a", "x": 1, "y": 1}]))
    camera = simulation.camera
    assert camera is not None
    camera.look(1.0)
    for _ in range(20):
        simulation.tick()
    assert camera.pan == pytest.approx(0.2 * camera.params.pan_speed)
