"""When a measurement is due, and how new it is: by way, by turn, by time."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import GridGeometry
from pilotage.localizer.last_measurement import STANDING, LastMeasurement, Novelty
from pilotage.localizer.markov_localizer import MarkovParams
from pilotage.localizer.particle_localizer import ParticleParams

SECOND = 10**9
HERE = np.array([3.0, -1.0, 0.7])
STILL = np.zeros(3)


@dataclass(frozen=True)
class EverySoOften:
    """A measurement is due after half a metre, a radian or two seconds."""

    update_way: float = 0.5
    update_turn: float = 1.0
    update_after: float = 2.0


class HeaviestFirst:
    """A belief whose states are numbered by their weight."""

    geometry = GridGeometry(1, 1, 0.1, (0.0, 0.0, 0.0))

    def heaviest(self, most: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return np.arange(3.0 * most).reshape(most, 3), np.full(most, 1.0 / most)

    def marginal(self) -> NDArray[np.float32]:
        return np.ones((1, 1), np.float32)

    def entropy(self) -> float:
        return 0.0


class NeverAsked(HeaviestFirst):
    """A belief that is dear to look through."""

    def heaviest(self, most: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        raise AssertionError(f"nobody needs {most} states")


@pytest.fixture
def last() -> LastMeasurement:
    """A measurement was taken HERE, at one second."""
    last = LastMeasurement(EverySoOften())
    last.note(SECOND, HERE)
    return last


def moved(*increment: float) -> NDArray[np.float64]:
    """Odometry after a motion from HERE."""
    return se2.compose(HERE, np.array(increment))


def test_the_first_measurement_is_due_at_once_and_all_new() -> None:
    last = LastMeasurement(EverySoOften())
    assert last.is_due(0, HERE)
    assert (last.increment_to(HERE) == STILL).all()
    assert last.novelty(STILL) == Novelty(1.0, 1.0)


@pytest.mark.parametrize(
    ("increment", "is_due"),
    [
        ((0.0, 0.0, 0.0), False),
        ((0.49, 0.0, 0.0), False),
        ((0.3, 0.41, 0.0), True),
        ((-0.51, 0.0, 0.0), True),
        ((0.0, 0.0, -0.99), False),
        ((0.0, 0.0, -1.01), True),
        ((0.26, 0.0, 0.51), True),
    ],
    ids=["still", "near", "aside", "back", "turned little", "turned", "half of both"],
)
def test_way_and_turn_together_make_the_next_one_due(
    last: LastMeasurement, increment: tuple[float, float, float], *, is_due: bool
) -> None:
    assert last.is_due(2 * SECOND, moved(*increment)) == is_due


@pytest.mark.parametrize(("seconds", "is_due"), [(1.0, False), (2.99, False), (3.0, True)])
def test_a_standing_robot_measures_again_after_a_while(
    last: LastMeasurement, seconds: float, *, is_due: bool
) -> None:
    assert last.is_due(round(seconds * SECOND), HERE) == is_due


def test_a_clock_that_was_set_back_does_not_make_the_robot_wait(last: LastMeasurement) -> None:
    assert last.is_due(SECOND - 1, HERE)


def test_the_motion_since_is_seen_from_where_the_robot_was(last: LastMeasurement) -> None:
    assert last.increment_to(moved(0.2, -0.1, 0.3)) == pytest.approx([0.2, -0.1, 0.3])


def test_from_the_same_place_little_is_new(last: LastMeasurement) -> None:
    assert last.novelty(STILL) == Novelty(STANDING, STANDING)


def test_half_the_way_makes_half_a_new_measurement(last: LastMeasurement) -> None:
    new = last.novelty(np.array([0.25, 0.0, 0.0]))
    assert (new.of_scan, new.of_ranges) == pytest.approx((0.5, 0.5))


def test_a_turn_is_newer_to_a_few_rangers_than_to_a_laser(last: LastMeasurement) -> None:
    new = last.novelty(np.array([0.0, 0.0, -0.8]))
    assert new.of_scan == pytest.approx(0.8 / np.pi)
    assert new.of_ranges == pytest.approx(0.8)


def test_nothing_is_newer_than_new(last: LastMeasurement) -> None:
    assert last.novelty(np.array([7.0, 0.0, 3.0])) == Novelty(1.0, 1.0)


def test_what_is_noted_is_a_copy(last: LastMeasurement) -> None:
    odom = HERE.copy()
    last.note(SECOND, odom)
    odom[:] = 9.0
    assert last.increment_to(HERE) == pytest.approx(STILL)


def test_odometry_that_counts_anew_makes_a_measurement_due_but_not_new(
    last: LastMeasurement,
) -> None:
    last.restart_odometry()
    assert last.is_due(SECOND, HERE)
    assert (last.increment_to(moved(50.0, 0.0, 1.0)) == STILL).all()
    assert last.novelty(STILL) == Novelty(STANDING, STANDING)


def test_forgetting_makes_the_next_one_the_first(last: LastMeasurement) -> None:
    last.forget()
    assert last.is_due(SECOND, HERE)
    assert last.novelty(STILL) == Novelty()


def test_a_memory_carries_states_and_where_they_were_measured(last: LastMeasurement) -> None:
    memory = last.memory(HeaviestFirst(), 4, was_localized=True)
    assert memory is not None
    assert memory.poses.shape == (4, 3)
    assert memory.weights == pytest.approx(np.full(4, 0.25))
    assert (memory.odom_from_base == HERE).all()
    assert (memory.stamp_ns, memory.was_localized) == (SECOND, True)
    later = LastMeasurement(EverySoOften())
    later.resume(memory)
    assert not later.is_due(2 * SECOND, moved(0.1, 0.0, 0.0))
    assert later.increment_to(moved(0.1, 0.0, 0.0)) == pytest.approx([0.1, 0.0, 0.0])


def test_without_a_measurement_there_is_no_memory_and_no_search_for_one() -> None:
    last = LastMeasurement(EverySoOften())
    assert last.memory(NeverAsked(), 4, was_localized=False) is None
    last.note(SECOND, HERE)
    last.restart_odometry()
    assert last.memory(NeverAsked(), 4, was_localized=False) is None


@pytest.mark.parametrize("params", [MarkovParams(), ParticleParams()], ids=["markov", "mcl"])
def test_every_method_keeps_a_pace(params: MarkovParams | ParticleParams) -> None:
    last = LastMeasurement(params)
    last.note(0, STILL)
    assert not last.is_due(SECOND // 2, np.array([0.1, 0.0, 0.05]))
    assert last.is_due(SECOND // 2, np.array([0.3, 0.0, 0.0]))
