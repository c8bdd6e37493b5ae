"""The pinhole camera: pixels to bearings, undoing lens, tilt and roll; compared with OpenCV."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from pilotage.robot.pinhole import PinholeCamera

SHAPE = (480, 640)


def bearing(camera: PinholeCamera, u: float, v: float = 239.5) -> float:
    return float(camera.bearings(np.array([[u, v]]), SHAPE)[0])


def test_the_middle_of_the_picture_is_straight_ahead() -> None:
    assert bearing(PinholeCamera(500.0), 319.5) == 0.0


def test_left_of_the_middle_is_a_positive_bearing() -> None:
    assert bearing(PinholeCamera(500.0), 319.5 - 500.0) == pytest.approx(np.pi / 4.0)
    assert bearing(PinholeCamera(500.0), 319.5 + 500.0) == pytest.approx(-np.pi / 4.0)


def test_a_field_of_view_spans_the_width() -> None:
    camera = PinholeCamera.across(640, np.deg2rad(60.0))
    assert np.rad2deg(bearing(camera, -0.5)) == pytest.approx(30.0)
    assert np.rad2deg(bearing(camera, 639.5)) == pytest.approx(-30.0)


def test_a_stated_centre_replaces_the_middle() -> None:
    assert bearing(PinholeCamera(500.0, (300.0, 200.0)), 300.0) == 0.0


def test_a_picture_of_half_the_size_shows_the_same_bearings() -> None:
    camera = PinholeCamera(500.0, (300.0, 200.0), (-0.2, 0.05), tilt=0.1, roll=0.05)
    u, v = 440.0, 120.0
    half = camera.scaled(0.5)
    there = half.bearings(np.array([[(u + 0.5) / 2 - 0.5, (v + 0.5) / 2 - 0.5]]), (240, 320))
    assert there[0] == pytest.approx(bearing(camera, u, v))


@pytest.mark.parametrize("focal", [0.0, -3.0, float("nan"), float("inf")])
def test_a_lens_without_a_focal_length_is_refused(focal: float) -> None:
    with pytest.raises(ValueError, match="focal must be positive"):
        PinholeCamera(focal)


def upright(x: float, z: float) -> NDArray[np.float64]:
    """Points of an upright edge: x to the right, y down, z ahead, m."""
    heights = np.linspace(-1.0, 1.0, 21)
    return np.stack([np.full(21, x), heights, np.full(21, z)], axis=1)


@pytest.mark.parametrize("tilt", [-0.2, 0.0, 0.15])
@pytest.mark.parametrize("roll", [-0.1, 0.0, 0.2])
@pytest.mark.parametrize("radial", [(0.0, 0.0), (-0.25, 0.06), (0.1, 0.0)])
def test_all_points_of_an_upright_edge_have_its_bearing(
    tilt: float, roll: float, radial: tuple[float, float]
) -> None:
    # OpenCV projects with rotation matrices: first the tilt about x, then the roll about z.
    about_x, _ = cv2.Rodrigues(np.array([-tilt, 0.0, 0.0]))
    about_z, _ = cv2.Rodrigues(np.array([0.0, 0.0, -roll]))
    turned, _ = cv2.Rodrigues(about_z @ about_x)
    matrix = np.array([[500.0, 0.0, 310.0], [0.0, 500.0, 250.0], [0.0, 0.0, 1.0]])
    lens = np.array([*radial, 0.0, 0.0])
    camera = PinholeCamera(500.0, (310.0, 250.0), radial, tilt, roll)
    for x in (-1.0, 0.3, 1.2):
        pixels, _ = cv2.projectPoints(upright(x, 3.0), turned, np.zeros(3), matrix, lens)
        found = camera.bearings(pixels[:, 0].astype(float), SHAPE)
        assert found == pytest.approx(np.full(21, np.arctan2(-x, 3.0)), abs=2e-4)
