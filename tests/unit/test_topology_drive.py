"""What a drive keeps of itself for a restart."""

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.topology.drive import Drive, Plan
from pilotage.topology.features import Features
from topology_maps import features

DOORS = features(("door", 3.0, 1.0, 1.57), ("corner", 6.0, 1.0, -2.3), ("corner", 6.0, -1.0, 2.3))
SPEED = 0.3


def driven(plan: Plan, metres: float = 12.0) -> Drive:
    """A drive along x past a door and two corners, a look every 0.06 m."""
    drive = Drive(plan)
    for i in range(round(metres / 0.06)):
        pose = np.array([0.06 * i, 0.0, 0.0])
        drive.add(100.0 + 0.2 * i, pose, near(pose))
    return drive


def near(pose: np.ndarray) -> Features:
    off = DOORS.poses[:, :2] - pose[:2]
    seen = DOORS.chosen(np.hypot(off[:, 0], off[:, 1]) < 4.0)
    return seen.moved(se2.inverse(pose))


def places(drive: Drive) -> np.ndarray:
    return drive.floor("m").map.places


def test_nodes_of_equal_spacing_lie_as_far_apart_as_was_wanted() -> None:
    gaps = np.diff(places(driven(Plan("equal", 2.0)))[:, 0])
    assert len(gaps) >= 3
    np.testing.assert_allclose(gaps, 2.0, atol=0.3)


def test_a_resumed_drive_is_the_same_drive() -> None:
    drive = driven(Plan("variable", 3.0))
    again = Drive.resumed(drive.remember())
    assert again.plan == drive.plan
    assert len(again) == len(drive)
    np.testing.assert_array_equal(places(again), places(drive))
    again.finish()
    drive.finish()
    np.testing.assert_array_equal(places(again), places(drive))


def test_a_drive_of_nothing_is_remembered_too() -> None:
    empty = Drive.resumed(Drive(Plan("equal", 1.0)).remember())
    empty.finish()
    assert len(empty) == 0
    assert empty.floor("m").map.nodes == ()


@pytest.mark.parametrize("name", ["stamps", "counts", "poses_map", "metres"])
def test_a_memory_with_a_hole_is_refused(name: str) -> None:
    memory = driven(Plan("variable", 3.0), metres=3.0).remember()
    del memory[name]
    with pytest.raises(KeyError):
        Drive.resumed(memory)


def test_what_was_driven_earlier_does_not_move_it() -> None:
    drive = driven(Plan("variable", 3.0))
    before = places(drive)
    assert not drive.correct(np.array([1.0, 2.0]), np.array([[50.0, 0.0, 0.0], [51.0, 0.0, 0.0]]))
    np.testing.assert_array_equal(places(drive), before)


def test_corrected_poses_move_it_and_its_memory() -> None:
    drive = driven(Plan("variable", 3.0))
    before = places(drive)
    stamps = np.linspace(100.0, 139.8, 200)
    poses = np.column_stack([SPEED * (stamps - 100.0), np.full(200, 2.0), np.zeros(200)])
    assert drive.correct(stamps, poses)
    np.testing.assert_allclose(places(drive)[:, 1], before[:, 1] + 2.0, atol=0.05)
    np.testing.assert_allclose(places(Drive.resumed(drive.remember())), places(drive), atol=1e-9)
