"""Active localization by landmarks, on the same decisions as by walls."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

from drawing import draw
from pilotage.bus.deployment import ConfigError
from pilotage.core.grid import OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.core.laser_view import View
from pilotage.planner import landmark_views
from pilotage.planner.active_drive import ActiveDrive
from pilotage.planner.active_localization import ActiveLocalization, ActiveParams
from pilotage.planner.camera_setup import camera_of
from pilotage.planner.config import PlannerSettings
from pilotage.planner.landmark_sight import CameraParams, LandmarkSight, warm_up
from pilotage.planner.landmark_views import Camera
from pilotage.planner.potential_field import Recognition
from pilotage.planner.sight import FULL_TURN
from pilotage.planner.situation import Hypotheses, Situation

ROOM = "\n".join(["#" * 42, *["#" + "." * 40 + "#"] * 20, "#" * 42])
"""4 m x 2 m inside, in cells of 0.1 m; alike from both ends but for the landmarks."""

LANDMARKS = LandmarkMap(
    np.array([[0.3, 1.1], [3.9, 1.1], [2.1, 2.0]]), ("post", "post", "sign"), (None, None, None)
)
"""Two posts alike, at the ends, and the only sign, in the middle of the upper wall."""

NEAR_SIGHTED = CameraParams(recognition=Recognition(1.2, 0.1))
NOTHING_SEEN = View(np.zeros((0, 2)), np.linspace(-2.0, 2.0, 61))
ENDS = Hypotheses(np.array([[0.8, 1.1, 0.0], [3.4, 1.1, np.pi]]), np.array([0.5, 0.5]))
"""At either end, looking to the middle: half a turn about it takes the one to the other."""


@pytest.fixture(scope="module")
def room() -> OccupancyMap:
    return draw(ROOM, resolution=0.1)


def active(room: OccupancyMap, camera: CameraParams = NEAR_SIGHTED) -> ActiveLocalization:
    return ActiveLocalization(room, ActiveParams(), LandmarkSight(LANDMARKS, room, camera))


def test_what_is_expected_fits_best_where_it_is_expected(room: OccupancyMap) -> None:
    rng = np.random.default_rng(1)
    poses = np.column_stack([rng.uniform(0.4, 3.8, 50), rng.uniform(0.4, 1.8, 50), np.zeros(50)])
    sight = LandmarkSight(LANDMARKS, room, replace(NEAR_SIGHTED, precision=0.05))
    fits = sight.log_likelihoods(poses, np.arange(50), FULL_TURN)
    own = np.diagonal(fits)[:, None]
    assert (fits <= own + 0.35).all()
    assert np.mean(fits <= own + 1e-6) > 0.9


def test_potential_is_highest_by_the_only_landmark_of_its_kind(room: OccupancyMap) -> None:
    potential = LandmarkSight(LANDMARKS, room, NEAR_SIGHTED).potential
    cells = potential.geometry.cells_of([[2.1, 1.5], [0.8, 1.1], [3.4, 1.1]])
    by_sign, by_post, by_other_post = potential.bits[cells[:, 0], cells[:, 1]]
    assert by_sign > 1.5 * by_post
    assert by_post == pytest.approx(by_other_post, abs=0.05)
    assert len(potential.maxima()) >= 2


def test_a_robot_at_either_end_goes_to_see_the_sign(room: OccupancyMap) -> None:
    decision = active(room).decide(ENDS, NOTHING_SEEN, np.random.default_rng(0), np.zeros((0, 2)))
    best = decision.looks[0]
    here = next(look for look in decision.looks if look.kind == "here")
    assert best.gain > 0.5 > here.gain
    # The sign stands 1.3 m ahead, on the left from one end and on the right from the other.
    assert best.point[0] > 0.3
    assert decision.heading is None, "the joint turns, not the robot"


def test_the_camera_is_pointed_to_what_tells_the_places_apart(room: OccupancyMap) -> None:
    """From the middle of the room the sign is to the left or to the right."""
    middle = Hypotheses(np.array([[2.1, 1.1, 0.0], [2.1, 1.1, np.pi]]), np.array([0.5, 0.5]))
    gaze = active(room).gaze(middle, NOTHING_SEEN)
    assert gaze is not None
    assert abs(gaze) == pytest.approx(np.pi / 2.0, abs=np.deg2rad(31.0))


def test_a_camera_points_no_farther_than_its_joint(room: OccupancyMap) -> None:
    stiff = replace(NEAR_SIGHTED, pan_limit=0.3)
    sight = LandmarkSight(LANDMARKS, room, stiff)
    assert np.abs(sight.pointings).max() == pytest.approx(0.3)
    gaze = active(room, stiff).gaze(ENDS, NOTHING_SEEN)
    assert gaze is not None
    assert abs(gaze) <= 0.3


def test_a_drive_points_the_camera_and_a_laser_is_left_as_it_is(room: OccupancyMap) -> None:
    situation = Situation(0.0, np.zeros(3), NOTHING_SEEN, ENDS, "ambiguous")
    by_landmarks = ActiveDrive(active(room), np.random.default_rng(0))
    by_walls = ActiveDrive(ActiveLocalization(room, ActiveParams()), np.random.default_rng(0))
    for drive in (by_landmarks, by_walls):
        drive.step(situation)
    assert by_landmarks.gaze is not None
    assert by_walls.gaze is None


def test_settings_name_the_landmarks_and_the_camera(tmp_path: Path) -> None:
    file = tmp_path / "landmarks.yaml"
    file.write_text("landmarks:\n  - {class: post, x: 1.0, y: 2.0}\n", encoding="utf-8")
    far = {"half_distance": 2.5, "width": 0.3}
    found = camera_of(
        PlannerSettings.model_validate(
            {"landmarks": file, "camera": {"recognition_by_class": {"post": far}}}
        )
    )
    assert found is not None
    landmarks, camera = found
    assert landmarks.classes == ("post",)
    assert camera.by_class == {"post": Recognition(2.5, 0.3)}
    assert camera.camera == Camera(half_view=float(np.deg2rad(30.0)))


def test_without_landmarks_there_is_no_camera() -> None:
    assert camera_of(PlannerSettings()) is None


def test_landmarks_that_cannot_be_used_are_refused_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "landmarks.yaml"
    with pytest.raises(ConfigError, match=r"settings of planner: landmarks: .*No such file"):
        camera_of(PlannerSettings(landmarks=file))
    file.write_text("landmarks:\n  - {class: post, x: 1.0, y: 2.0}\n", encoding="utf-8")
    strange = PlannerSettings.model_validate(
        {"landmarks": file, "camera": {"recognition_by_class": {"goal": {}}}}
    )
    with pytest.raises(ConfigError, match="no landmark is of the class 'goal'"):
        camera_of(strange)


@pytest.mark.parametrize("kernel", [landmark_views._look, landmark_views._expected])
def test_kernels_are_compiled_before_a_robot_waits_for_them(kernel: Dispatcher) -> None:
    warm_up()
    assert kernel.signatures
