"""Landmarks from YAML, and what is said of a file that will not do."""

from pathlib import Path

import numpy as np
import pytest

from pilotage.core.landmark_map import (
    NO_LANDMARKS,
    LandmarkFileError,
    LandmarkMap,
    landmarks_of,
    read_landmarks,
)

GOOD = """
landmarks:
  - {class: beacon, x: 1.5, y: -2, id: north}
  - {class: beacon, x: 1.5, y: 3.0}
  - {class: 17, x: 0, y: 0, id: 5}
"""


def write(folder: Path, text: str) -> Path:
    file = folder / "landmarks.yaml"
    file.write_text(text, "utf-8")
    return file


def test_landmarks_are_read_with_class_place_and_identity(tmp_path: Path) -> None:
    landmarks = read_landmarks(write(tmp_path, GOOD))
    assert landmarks.classes == ("beacon", "beacon", "17")
    assert landmarks.identities == ("north", None, "5")
    assert landmarks.positions == pytest.approx(np.array([[1.5, -2.0], [1.5, 3.0], [0.0, 0.0]]))


def test_a_sighting_may_belong_to_its_likes_or_to_the_one_it_names(tmp_path: Path) -> None:
    landmarks = read_landmarks(write(tmp_path, GOOD))
    assert len(landmarks.candidates("beacon", None)) == 2
    assert landmarks.candidates("beacon", "north") == pytest.approx(np.array([[1.5, -2.0]]))
    assert len(landmarks.candidates("goal", None)) == 0
    assert len(landmarks.candidates("beacon", "south")) == 0


def test_a_list_from_elsewhere_is_read_as_one_in_a_file(tmp_path: Path) -> None:
    entries = [{"class": "beacon", "x": 1.5, "y": -2, "id": "north"}]
    listed = landmarks_of(entries)
    filed = read_landmarks(
        write(tmp_path, "landmarks: [{class: beacon, x: 1.5, y: -2, id: north}]")
    )
    assert np.array_equal(listed.positions, filed.positions)
    assert (listed.classes, listed.identities) == (filed.classes, filed.identities)
    assert landmarks_of([]).classes == NO_LANDMARKS.classes == ()


def test_no_landmark_at_all_is_a_map_too(tmp_path: Path) -> None:
    empty = read_landmarks(write(tmp_path, "landmarks: []"))
    assert empty.positions.shape == (0, 2)
    assert empty.candidates("beacon", None).shape == (0, 2)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("", "there is no list 'landmarks'"),
        ("[]", "there is no list 'landmarks'"),
        ("landmarks: 3", "there is no list 'landmarks'"),
        ("{landmarks: [], beacons: []}", "unknown key 'beacons'"),
        ("landmarks: [3]", "landmark 1 must be a mapping with class, x and y, not 3"),
        ("landmarks: [{class: a, x: 1}]", "landmark 1: the key 'y' is missing"),
        ("landmarks: [{x: 1, y: 1}]", "landmark 1: the key 'class' is missing"),
        ("landmarks: [{class: a, x: 1, y: 1, z: 1}]", "landmark 1: unknown key 'z'"),
        ("landmarks: [{class: a, x: far, y: 1}]", "landmark 1: x must be a finite number"),
        ("landmarks: [{class: a, x: 1, y: .inf}]", "landmark 1: y must be a finite number"),
        ("landmarks: [{class: a, x: true, y: 1}]", "landmark 1: x must be a finite number"),
        ("landmarks: [{class: '', x: 1, y: 1}]", "landmark 1: class must be a name"),
        (f"landmarks: [{{class: {65 * 'a'}, x: 1, y: 1}}]", "class has more than 64 characters"),
        ("landmarks: [{class: a, x: 1, y: 1, id: 1.5}]", "landmark 1: id must be a name"),
        (
            "landmarks: [{class: a, x: 1, y: 1, id: b}, {class: a, x: 2, y: 1, id: b}]",
            "the id 'b' is given to two landmarks",
        ),
        ("landmarks: [", "not readable as YAML"),
    ],
)
def test_a_fault_is_named_in_one_line(tmp_path: Path, text: str, fault: str) -> None:
    with pytest.raises(LandmarkFileError) as caught:
        read_landmarks(write(tmp_path, text))
    assert fault in str(caught.value)
    assert "landmarks.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(LandmarkFileError, match=r"nowhere\.yaml: No such file"):
        read_landmarks(tmp_path / "nowhere.yaml")


def test_positions_classes_and_identities_belong_together() -> None:
    with pytest.raises(ValueError, match="need a position"):
        LandmarkMap(np.zeros((2, 2)), ("a",), (None,))
    with pytest.raises(ValueError, match="finite"):
        LandmarkMap(np.full((1, 2), np.nan), ("a",), (None,))
