"""How new a scan is: surfaces count less the oftener they were seen, until they are forgotten."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pilotage.core import se2
from pilotage.localizer.measurement import Beams
from pilotage.localizer.novelty import PIECE, REMEMBERED, SeenSurfaces

HERE, AWAY = np.array([0.1, 0.07, 0.0]), np.array([40.1, 0.07, 0.0])
"""Off the edges between pieces, on which rounding would decide."""

SEEN_ONCE = 0.25
"""Novelty of what one scan saw before."""

BEARINGS = np.arange(8) * math.tau / 8


def beams(ranges: float | list[float] = 2.1, mount: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Beams:
    return Beams(BEARINGS, np.zeros(8) + ranges, np.array(mount), 12.0)


def seen(times: int) -> SeenSurfaces:
    surfaces = SeenSurfaces()
    for _ in range(times):
        surfaces.keep(HERE, beams())
    return surfaces


def test_what_was_never_seen_is_all_new() -> None:
    assert SeenSurfaces().novelty(HERE, beams()).tolist() == [1.0] * 8
    assert seen(3).novelty(AWAY, beams()).tolist() == [1.0] * 8


def test_the_same_scan_from_the_same_place_counts_one_a_quarter_a_ninth() -> None:
    surfaces = SeenSurfaces()
    for count in range(1, 6):
        assert surfaces.novelty(HERE, beams()) == pytest.approx(1.0 / count**2)
        surfaces.keep(HERE, beams())


def test_only_the_beams_that_see_something_else_are_new() -> None:
    farther = [2.1, 2.1, 6.0, 2.1, 2.1, 2.1, 9.0, 2.1]
    novelty = seen(1).novelty(HERE, beams(farther))
    assert novelty.tolist() == [0.25, 0.25, 1.0, 0.25, 0.25, 0.25, 1.0, 0.25]


def test_beams_that_meet_the_same_piece_see_it_once() -> None:
    close = Beams(np.array([0.0, 0.01]), np.array([3.1, 3.1]), np.zeros(3), 12.0)
    surfaces = SeenSurfaces()
    surfaces.keep(np.array([0.0, 0.1, 0.0]), close)
    assert surfaces.novelty(np.array([0.0, 0.1, 0.0]), close) == pytest.approx(SEEN_ONCE)


def test_a_piece_is_known_again_from_elsewhere() -> None:
    """A wall 3 m ahead is 2 m ahead after a metre, and to the left after a turn."""
    one = Beams(np.zeros(1), np.array([3.1]), np.zeros(3), 12.0)
    nearer = Beams(np.zeros(1), np.array([2.1]), np.zeros(3), 12.0)
    turned = Beams(np.array([math.pi / 2.0]), np.array([3.1]), np.zeros(3), 12.0)
    surfaces = SeenSurfaces()
    surfaces.keep(np.array([0.0, 0.1, 0.0]), one)
    assert surfaces.novelty(np.array([1.0, 0.1, 0.0]), nearer) == pytest.approx(SEEN_ONCE)
    right = np.array([0.0, 0.1, -math.pi / 2.0])
    assert surfaces.novelty(right, turned) == pytest.approx(SEEN_ONCE)


def test_the_mount_of_the_laser_counts() -> None:
    """The same surface, measured by a laser that sits 0.5 m ahead of the robot's middle."""
    surfaces = seen(1)
    behind = HERE - np.array([0.5, 0.0, 0.0])
    assert surfaces.novelty(behind, beams(mount=(0.5, 0.0, 0.0))) == pytest.approx(SEEN_ONCE)
    turned = beams(mount=(0.0, 0.0, math.tau / 8))
    assert surfaces.novelty(HERE, turned) == pytest.approx(SEEN_ONCE)


def test_beams_without_a_return_are_known_by_where_they_point() -> None:
    surfaces = SeenSurfaces()
    surfaces.keep(HERE, beams(math.inf))
    assert surfaces.novelty(HERE, beams(math.inf)) == pytest.approx(SEEN_ONCE)
    assert surfaces.novelty(HERE + np.array([3.0, 0.0, 0.0]), beams(math.inf))[0] == 1.0
    assert surfaces.novelty(HERE, beams(3.0)) == pytest.approx(1.0), "no wall was met there"


def test_beams_without_a_return_are_as_new_as_the_others_of_their_scan() -> None:
    """Nothing is known of what they saw, and the open moves on with the robot."""
    some = [2.1, 2.1, 6.0, math.inf, 2.1, math.inf, 9.0, 2.1]
    novelty = seen(1).novelty(HERE, beams(some))
    assert novelty[[3, 5]] == pytest.approx((4 * 0.25 + 2 * 1.0) / 6)


def test_surfaces_are_new_again_once_they_are_forgotten() -> None:
    surfaces = seen(1)
    for _ in range(REMEMBERED - 1):
        surfaces.keep(AWAY, beams())
    assert surfaces.novelty(HERE, beams()) == pytest.approx(SEEN_ONCE)
    surfaces.keep(AWAY, beams())
    assert surfaces.novelty(HERE, beams()) == pytest.approx(1.0)


def test_however_long_a_robot_stands_it_remembers_no_more_than_the_last_scans() -> None:
    surfaces = seen(3 * REMEMBERED)
    assert surfaces.novelty(HERE, beams()) == pytest.approx(1.0 / (1 + REMEMBERED) ** 2)
    for _ in range(REMEMBERED):
        surfaces.keep(AWAY, beams())
    assert surfaces.novelty(HERE, beams()) == pytest.approx(1.0)


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.floats(-math.pi, math.pi))
def test_novelty_lies_between_none_and_all_and_falls_with_every_look(
    seed: int, turn: float
) -> None:
    rng = np.random.default_rng(seed)
    scan = Beams(BEARINGS, rng.uniform(0.1, 9.0, 8), np.array([0.1, 0.0, 0.2]), 12.0)
    surfaces = SeenSurfaces()
    before = np.ones(8)
    for _ in range(4):
        pose = se2.compose([0.0, 0.0, turn], [*rng.normal(0.0, 0.3 * PIECE, 2), 0.0])
        surfaces.keep(pose, scan)
        now = surfaces.novelty(HERE, scan)
        assert (now <= before).all()
        assert (now > 0.0).all()
        before = now
