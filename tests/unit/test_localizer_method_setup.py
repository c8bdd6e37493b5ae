"""The files that the settings name, and the landmarks that a robot sees."""

import logging
import math
from pathlib import Path

import numpy as np
import pytest

from localizer_bench import STANDING, WORLD, Bench
from localizer_world import START
from pilotage.bus.deployment import ConfigError, Deployment, service_settings
from pilotage.core import se2
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.method_setup import method_setup
from pilotage.localizer.methods import (
    FINDERS,
    METHODS,
    MethodSetup,
    NoMethodError,
    make_method,
    require_method,
)
from pilotage_schemas.sensors import Landmark, LandmarkSightings

AMCL = """\
amcl:
  ros__parameters:
    max_beams: 30
    max_particles: 3000
    robot_model_type: nav2_amcl::DifferentialMotionModel
    tf_broadcast: true
    set_initial_pose: true
    initial_pose: {x: 2.0, y: 4.9, z: 0.0, yaw: 0.2}
"""
LANDMARKS = """\
landmarks:
  - {class: beacon, x: 1.0, y: 5.5, id: north}
  - {class: beacon, x: 6.0, y: 5.5, id: east}
  - {class: beacon, x: 3.0, y: 1.0, id: south}
"""
PLACES = {"north": (1.0, 5.5), "east": (6.0, 5.5), "south": (3.0, 1.0)}


def settings_of(folder: Path, **section: object) -> LocalizerSettings:
    deployment = Deployment(services={"localizer": section}, base=folder)
    return service_settings(deployment, "localizer", LocalizerSettings)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "amcl.yaml").write_text(AMCL, encoding="utf-8")
    (tmp_path / "beacons.yaml").write_text(LANDMARKS, encoding="utf-8")
    return tmp_path


def test_without_files_both_methods_have_their_defaults_and_share_their_table() -> None:
    setup = method_setup(LocalizerSettings(resolution=0.2, headings=36), pytest.fail)
    assert setup.landmarks is None
    assert setup.start is None
    assert setup.sight_of("markov") == setup.sight_of("mcl")


def test_every_parameter_of_amcl_is_accounted_for(folder: Path) -> None:
    said: list[str] = []
    setup = method_setup(settings_of(folder, method="mcl", amcl_file="amcl.yaml"), said.append)
    assert setup.particles.beams == 30
    assert {line.split(":")[0] for line in said} >= {"max_beams", "max_particles", "tf_broadcast"}
    assert setup.start is not None
    assert setup.start[0] == pytest.approx([2.0, 4.9, 0.2])


def test_the_service_logs_what_became_of_amcls_parameters_and_begins_at_its_pose(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.INFO):
        bench = Bench(settings=settings_of(folder, method="mcl", amcl_file="amcl.yaml"))
    assert any(r.message.startswith("amcl_file: max_beams: 30") for r in caplog.records)
    bench.begin()
    bench.latest()
    assert bench.is_right(within=0.3)
    assert bench.beliefs[-1].method == "mcl"


def test_a_pose_of_amcl_that_is_off_the_map_is_ignored_and_said(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (folder / "amcl.yaml").write_text(AMCL.replace("x: 2.0", "x: 90.0"), encoding="utf-8")
    bench = Bench(settings=settings_of(folder, method="mcl", amcl_file="amcl.yaml"))
    bench.begin()
    assert any("its initial pose is ignored" in r.message for r in caplog.records)
    assert bench.latest().state == "unknown"


@pytest.mark.parametrize(
    ("section", "reason"),
    [
        ({"amcl_file": "gone.yaml"}, r"amcl_file: .*gone\.yaml: No such file"),
        ({"amcl_file": "beacons.yaml"}, "amcl_file: .*no parameters of AMCL"),
        ({"landmarks": "gone.yaml"}, r"landmarks: .*gone\.yaml: No such file"),
        ({"landmarks": "amcl.yaml"}, "landmarks: .*there is no list 'landmarks'"),
        ({"sensors": ["landmark"]}, "the sensor landmark needs a file"),
    ],
)
def test_a_file_that_cannot_be_used_ends_the_start_with_its_reason(
    folder: Path, section: dict[str, object], reason: str
) -> None:
    with pytest.raises(ConfigError, match=reason):
        method_setup(settings_of(folder, **section), lambda _line: None)


@pytest.mark.parametrize("section", [{"method": "magic"}, {"sensors": ["nose"]}])
def test_settings_that_nobody_knows_are_refused(folder: Path, section: dict[str, object]) -> None:
    with pytest.raises(ConfigError):
        settings_of(folder, **section)


def test_every_method_can_be_made_and_says_its_name() -> None:
    setup = method_setup(LocalizerSettings(headings=36), lambda _line: None)
    for name in METHODS:
        assert make_method(name, WORLD, setup, np.random.default_rng(0)).name == name


def test_a_method_that_is_missing_is_refused_with_those_there_are() -> None:
    with pytest.raises(NoMethodError, match="no method 'magic'; there are markov, mcl, ekf"):
        require_method("magic")


def test_the_filter_of_lines_needs_no_table_of_the_map() -> None:
    assert MethodSetup().sight_of("ekf") is None
    assert MethodSetup().sight_of("markov") is not None


def sightings(bench: Bench) -> LandmarkSightings:
    """The beacons as the robot's camera, at its centre, sees them from where it stands."""
    seen = []
    for name, place in PLACES.items():
        x, y = se2.transform_points(se2.inverse(bench.pose), np.array([place]))[0]
        seen.append(
            Landmark(
                kind="beacon",
                range=math.hypot(x, y),
                bearing=math.atan2(y, x),
                range_sigma=0.1,
                bearing_sigma=0.02,
                identity=name,
            )
        )
    stamp_ns = bench.clock.now_ns()
    return LandmarkSightings(stamp_ns=stamp_ns, frame_id="base_link", sightings=tuple(seen))


def seeing_bench(folder: Path, method: str) -> Bench:
    section = {"method": method, "sensors": ["landmark"], "landmarks": "beacons.yaml"}
    bench = Bench(settings=settings_of(folder, headings=36, **section))
    bench.put_map()
    return bench


@pytest.mark.parametrize("method", FINDERS)
def test_landmarks_alone_find_the_robot(folder: Path, method: str) -> None:
    bench = seeing_bench(folder, method)
    for _ in range(4):
        bench.clock.advance(1.5)
        bench.say_odometry()
        bench.put("landmarks", sightings(bench))
    bench.latest()
    assert bench.pose == pytest.approx(START)
    assert bench.is_right(within=0.3)


def test_a_picture_without_landmarks_changes_nothing(folder: Path) -> None:
    bench = seeing_bench(folder, "mcl")
    bench.clock.advance(1.0)
    bench.say_odometry()
    empty = sightings(bench).model_copy(update={"sightings": ()})
    bench.put("landmarks", empty)
    assert bench.service._weighed_ns == 0


def test_a_camera_that_nobody_described_is_said(
    folder: Path, caplog: pytest.LogCaptureFixture
) -> None:
    bench = seeing_bench(folder, "mcl")
    bench.describe()
    bench.clock.advance(1.0)
    bench.go(STANDING)
    bench.put("landmarks", sightings(bench).model_copy(update={"frame_id": "camera"}))
    assert any("no mount 'camera'" in record.message for record in caplog.records)
    assert bench.service._weighed_ns == 0
