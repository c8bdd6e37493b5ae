"""Landmarks that do not stand where they should: carried off, or only a mistake."""

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.landmark_sightings import Sightings
from pilotage.localizer.landmark_surprise import IN_A_ROW, LandmarkSurprise
from pilotage.localizer.markov_localizer import MarkovLocalizer, MarkovParams
from pilotage.localizer.measurement import landmarks_measurement
from pilotage.localizer.pose_grid import PoseGridParams

POSTS = LandmarkMap(
    np.array([[1.0, 1.0], [11.0, 2.0], [6.0, 7.0], [2.5, 6.5], [9.0, 6.0]]),
    ("post",) * 5,
    tuple("abcde"),
)
HERE, THERE = np.array([3.0, 3.0, 0.4]), np.array([8.5, 4.0, -2.0])
KNOWN = np.diag([0.01, 0.01, 0.001])


def seen_from(pose: np.ndarray, names: str = "abcde") -> Sightings:
    """Exact sightings of posts; those that the map does not have stand 1 m ahead."""
    places = [POSTS.positions["abcde".index(n)] if n in "abcde" else pose[:2] + 1.0 for n in names]
    x, y = se2.transform_points(se2.inverse(pose), np.array(places).reshape(-1, 2)).T
    count = len(names)
    sigmas = np.full(count, 0.15), np.full(count, 0.05)
    return Sightings(np.hypot(x, y), np.arctan2(y, x), *sigmas, ("post",) * count, tuple(names))


@pytest.fixture
def watch() -> LandmarkSurprise:
    return LandmarkSurprise(POSTS)


def test_landmarks_where_they_should_be_are_no_surprise(watch: LandmarkSurprise) -> None:
    assert not watch.is_surprised(HERE, KNOWN, seen_from(HERE))


def test_several_landmarks_elsewhere_are_one_at_once(watch: LandmarkSurprise) -> None:
    assert watch.is_surprised(HERE, KNOWN, seen_from(THERE))


def test_one_landmark_at_a_time_is_one_after_several_in_a_row(watch: LandmarkSurprise) -> None:
    for name in "abcde"[: IN_A_ROW - 1]:
        assert not watch.is_surprised(HERE, KNOWN, seen_from(THERE, name))
        watch.note(HERE, KNOWN, seen_from(THERE, name))
    assert watch.is_surprised(HERE, KNOWN, seen_from(THERE, "e"))


def test_a_landmark_that_fits_begins_the_count_anew(watch: LandmarkSurprise) -> None:
    watch.note(HERE, KNOWN, seen_from(THERE, "ab"))
    watch.note(HERE, KNOWN, seen_from(HERE, "c"))
    assert not watch.is_surprised(HERE, KNOWN, seen_from(THERE, "d"))


def test_what_is_not_mapped_or_not_seen_is_no_surprise(watch: LandmarkSurprise) -> None:
    assert not watch.is_surprised(HERE, KNOWN, seen_from(HERE, "vwxyz"))
    for _ in range(3):
        watch.note(HERE, KNOWN, seen_from(THERE))
    assert not watch.is_surprised(HERE, KNOWN, None)
    assert not LandmarkSurprise(None).is_surprised(HERE, KNOWN, seen_from(THERE))


def test_who_hardly_knows_where_it_is_is_not_surprised(watch: LandmarkSurprise) -> None:
    aside = se2.compose(HERE, [0.8, 0.4, 0.3])
    assert watch.is_surprised(HERE, KNOWN, seen_from(aside))
    assert not watch.is_surprised(HERE, np.diag([0.5, 0.5, 0.1]), seen_from(aside))


def test_a_kidnapping_seen_by_landmarks_alone_is_told_with_the_first_picture() -> None:
    """In a hall without a wall, of which nearly all is skipped while the robot is tracked."""
    world = OccupancyMap(GridGeometry(80, 120, 0.1), np.zeros((80, 120), np.int8))
    params = MarkovParams(grid=PoseGridParams(0.1, 72))
    localizer = MarkovLocalizer(world, params, landmarks=POSTS)
    pose, odom, step = HERE, np.zeros(3), np.array([0.1, 0.0, 0.25])
    states = []
    for count in range(20):
        pose = THERE if count == 8 else se2.compose(pose, step)
        odom = se2.compose(odom, step)
        measurement = landmarks_measurement(seen_from(pose), np.zeros(3))
        estimate = localizer.update((count + 1) * 10**9, odom, measurement)
        states.append(estimate.state)
        if estimate.state == "localized":
            assert np.hypot(*(estimate.pose - pose)[:2]) < 0.2
    assert states[7] == "localized"
    assert states[8] == "lost"
    assert states[-1] == "localized"
