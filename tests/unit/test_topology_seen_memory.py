"""What is remembered of the last metre, carried along by odometry."""

import numpy as np

from feature_scenes import corner, door
from pilotage.core import se2
from pilotage.topology.features import Features
from pilotage.topology.seeing.seen_features_memory import MemoryParams, SeenMemory


def at(x: float, turn: float = 0.0) -> np.ndarray:
    return np.array([x, 0.0, turn])


def seen_from(pose: np.ndarray, world: Features) -> Features:
    return world.moved(se2.inverse(pose))


def test_what_is_seen_now_is_there_at_once() -> None:
    memory = SeenMemory()
    assert len(memory.add(at(0.0), door(2.0, 1.0))) == 1


def test_what_was_seen_before_is_still_there_where_odometry_says() -> None:
    memory, world = SeenMemory(), door(2.0, 1.0)
    for x in (0.0, 0.2, 0.4):
        memory.add(at(x), seen_from(at(x), world))
    left = memory.add(at(0.9), Features.none())
    np.testing.assert_allclose(left.poses[:, :2], [[1.1, 1.0]], atol=1e-6)


def test_two_scans_that_see_different_things_make_one_whole() -> None:
    memory = SeenMemory()
    one, other = door(2.0, 1.0), corner(3.0, -1.0, 2.0)
    for x, world in ((0.0, one), (0.1, one), (0.2, other), (0.3, other)):
        kept = memory.add(at(x), seen_from(at(x), world))
    assert sorted(kept.kinds.tolist()) == [0, 1]


def test_what_was_seen_once_is_forgotten_with_the_next_scan() -> None:
    memory = SeenMemory()
    memory.add(at(0.0), door(2.0, 1.0))
    assert len(memory.add(at(0.2), Features.none())) == 0


def test_nothing_is_remembered_for_long() -> None:
    memory, world = SeenMemory(MemoryParams(metres=1.0)), door(5.0, 1.0)
    for x in (0.0, 0.1, 0.2):
        memory.add(at(x), seen_from(at(x), world))
    counts = [len(memory.add(at(x), Features.none())) for x in np.arange(0.3, 1.6, 0.1)]
    assert counts[0] == 1
    assert counts[-1] == 0


def test_turning_makes_the_memory_short() -> None:
    memory, world = SeenMemory(MemoryParams(turn=0.4)), door(5.0, 1.0)
    for x in (0.0, 0.1, 0.2):
        memory.add(at(x), seen_from(at(x), world))
    for turn in (0.15, 0.3, 0.45, 0.6):
        left = memory.add(at(0.2, turn), Features.none())
    assert len(left) == 0


def test_the_longer_ago_the_less_sure() -> None:
    memory, world = SeenMemory(), door(3.0, 1.0)
    for x in (0.0, 0.1, 0.2):
        now = memory.add(at(x), seen_from(at(x), world))
    later = memory.add(at(1.2), Features.none())
    assert np.trace(later.covariances[0]) > 2.0 * np.trace(now.covariances[0])


def test_standing_still_makes_nothing_surer() -> None:
    memory, world = SeenMemory(), door(3.0, 1.0)
    first = memory.add(at(0.0), world)
    for _ in range(20):
        last = memory.add(at(0.0), world)
    np.testing.assert_allclose(last.covariances, first.covariances)


def test_after_it_is_cleared_nothing_is_left() -> None:
    memory, world = SeenMemory(), door(3.0, 1.0)
    for x in (0.0, 0.1, 0.2):
        memory.add(at(x), seen_from(at(x), world))
    memory.clear()
    assert len(memory.add(at(5.0), Features.none())) == 0
