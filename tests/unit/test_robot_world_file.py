"""World files: what they may say, and what is refused in one line."""

from pathlib import Path

import numpy as np
import pytest

from pilotage.bus.deployment import ConfigError
from pilotage.core.map_files import save_map
from pilotage.robot.simulator.camera import RecognitionParams
from pilotage.robot.simulator.config import open_world, read_world
from robot_world import ROOM


def world(folder: Path, text: str) -> Path:
    save_map(ROOM, folder / "room.yaml")
    file = folder / "world.yaml"
    file.write_text(f"map: room.yaml\n{text}\n", encoding="utf-8")
    return file


def test_a_map_is_all_a_world_needs(tmp_path: Path) -> None:
    simulation = open_world(world(tmp_path, ""))
    assert not simulation.walls.overlaps(simulation.pose[0], simulation.pose[1], 0.165)


def test_the_start_may_be_given(tmp_path: Path) -> None:
    simulation = open_world(world(tmp_path, "start: [1.5, 1.75, 0.5]"))
    assert simulation.pose == pytest.approx([1.5, 1.75, 0.5])


def test_a_seed_makes_the_random_start_the_same(tmp_path: Path) -> None:
    file = world(tmp_path, "seed: 3")
    poses = [open_world(file).pose, open_world(file).pose, open_world(file, seed=4).pose]
    assert poses[0] == pytest.approx(poses[1])
    assert np.abs(poses[0] - poses[2]).max() > 0.01


def test_parameters_of_the_robot_are_set_one_by_one(tmp_path: Path) -> None:
    text = "robot: {laser: {beams: 90, range_max: 5}, drive: {radius: 0.3}}"
    params = open_world(world(tmp_path, text)).params
    assert (params.laser.beams, params.laser.range_max, params.drive.radius) == (90, 5.0, 0.3)
    assert params.laser.sigma == 0.01


def test_unmapped_furniture_and_people_are_there(tmp_path: Path) -> None:
    simulation = open_world(world(tmp_path, "unmapped: [[3, 1.5, 3.4, 2.0]]\npeople: 2"))
    assert simulation.walls.overlaps(3.2, 1.7, 0.05)
    assert len(simulation.people.discs) == 2


def test_landmarks_stand_in_the_world_file_or_in_one_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "posts.yaml").write_text("landmarks: [{class: post, x: 3, y: 1.5}]", "utf-8")
    inline = open_world(world(tmp_path, "landmarks: [{class: post, x: 3, y: 1.5, id: red}]"))
    apart = open_world(world(tmp_path, "landmarks: posts.yaml"))
    for simulation in (inline, apart):
        assert simulation.camera is not None
        assert simulation.camera.landmarks.classes == ("post",)
        assert simulation.camera.landmarks.positions == pytest.approx(np.array([[3.0, 1.5]]))
    assert inline.camera is not None
    assert inline.camera.landmarks.identities == ("red",)


def test_a_world_without_landmarks_has_a_camera_only_if_it_asks_for_one(tmp_path: Path) -> None:
    assert open_world(world(tmp_path, "")).camera is None
    assert open_world(world(tmp_path, "landmarks: []")).camera is None
    assert open_world(world(tmp_path, "robot: {camera: {}}")).camera is not None


def test_figures_of_the_camera_are_set_one_by_one(tmp_path: Path) -> None:
    text = """
landmarks: [{class: post, x: 3, y: 1.5}, {class: line, x: 2, y: 1.5}]
robot:
  camera:
    field_of_view: 1.2
    recognition: {half_distance: 5.0}
    recognition_by_class: {line: {half_distance: 1.2, width: 0.15}}
"""
    camera = open_world(world(tmp_path, text)).camera
    assert camera is not None
    assert (camera.params.field_of_view, camera.params.range_share) == (1.2, 0.1)
    assert camera.params.recognition_of("post") == RecognitionParams(5.0, 0.6)
    assert camera.params.recognition_of("line") == RecognitionParams(1.2, 0.15)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("start: here", "start: .*must be random or"),
        ("start: [1, 2]", "start: .*must be random or"),
        ("start: [1, 2, .inf]", "start: .*must be random or"),
        ("start: [0.2, 0.2, 0]", r"start: \(0.20, 0.20\) lies in a wall"),
        ("start: [90, 0.2, 0]", "lies outside of the map"),
        ("people: -1", "people"),
        ("people: many", "people"),
        ("furniture: []", "furniture: Extra inputs"),
        ("unmapped: [[1, 2, 3]]", "unmapped.0"),
        ("robot: {lidar: {}}", "robot.lidar"),
        ("robot: {laser: {beams: 0}}", "beams must be 2 to"),
        ("robot: {laser: {sigma: .nan}}", "sigma"),
        ("robot: {drive: {radius: 3.0}}", "no free place"),
        ("seed: -1", "seed"),
        ("landmarks: 3", "landmarks: .*must be a list of landmarks or a file with one"),
        ("landmarks: {class: a}", "landmarks: .*must be a list of landmarks or a file with one"),
        ("landmarks: gone.yaml", r"landmarks: .*gone\.yaml: No such file"),
        ("landmarks: room.yaml", r"landmarks: .*room\.yaml: there is no list 'landmarks'"),
        ("landmarks: [{class: a, x: 1}]", "landmarks: .*landmark 1: the key 'y' is missing"),
        ("landmarks: [{class: a, x: 1, y: .nan}]", "landmark 1: y must be a finite number"),
        (f"landmarks: [{{class: {'a' * 65}, x: 1, y: 1}}]", "more than 64 characters"),
        (
            "landmarks: [{class: a, x: 1, y: 1}, {class: b, x: 90, y: 1}]",
            r"landmarks: landmark 2 \(b\) at \(90, 1\) lies outside of the map",
        ),
        ("landmarks: [{class: a, x: 1.0e+300, y: 1}]", "lies outside of the map"),
        ("robot: {camera: {field_of_view: 60}}", "field_of_view must be a full turn at most"),
        ("robot: {camera: {recognition: {width: 0}}}", "width must be more than 0"),
        (
            "robot: {camera: {recognition_by_class: {becon: {}}}}",
            "robot.camera.recognition_by_class: no landmark is a 'becon'",
        ),
        ("robot: {camera: {zoom: 2}}", "robot.camera.*zoom"),
        ("{", "not valid YAML"),
    ],
)
def test_a_wrong_world_is_refused_in_one_line(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(ConfigError, match=reason) as refused:
        open_world(world(tmp_path, text))
    assert "\n" not in str(refused.value)
    assert "world.yaml" in str(refused.value)


@pytest.mark.parametrize("content", [b"", b"[1, 2]", b"map", b"\xff\xfe"])
def test_what_is_no_world_is_refused(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "world.yaml"
    file.write_bytes(content)
    with pytest.raises(ConfigError, match=r"world\.yaml"):
        read_world(file)


def test_a_missing_world_and_a_missing_map_are_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"nowhere\.yaml: cannot be read: No such file"):
        open_world(tmp_path / "nowhere.yaml")
    lost = tmp_path / "lost.yaml"
    lost.write_text("map: gone.yaml", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"gone\.yaml: the map file does not exist"):
        open_world(lost)


@pytest.mark.parametrize("name", ["office", "hall", "busy_office", "robocup"])
def test_the_worlds_that_come_with_pilotage_open(repository: Path, name: str) -> None:
    simulation = open_world(repository / "deploy" / "worlds" / f"{name}.yaml", seed=1)
    assert not simulation.walls.overlaps(simulation.pose[0], simulation.pose[1], 0.165)
