"""Method and map chosen while the localizer runs, and what of that outlives a crash."""

import logging
from pathlib import Path

import numpy as np
import pytest

from localizer_bench import STANDING, WORLD, Bench, pose2
from localizer_world import ROUND, flat
from pilotage.bus.fabric import RefusedError
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.map_files import map_digest, save_map
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.storage import CHOICE_FILE, MEMORY_FILE
from pilotage_schemas.commands import (
    Done,
    MapLoaded,
    Nothing,
    SetAlgorithm,
    SetMap,
    SetMethod,
    SetPose,
)

FLAT_ID = map_digest(WORLD)
AWAY = flat((5.0, -5.0, 0.4))


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def away(tmp_path: Path) -> str:
    """The file of a map that lies elsewhere."""
    save_map(AWAY, tmp_path / "away.yaml")
    return str(tmp_path / "away.yaml")


def methods_of(bench: Bench) -> list[str]:
    return [belief.method for belief in bench.beliefs]


def test_each_method_goes_on_where_the_other_was(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    for method in ("mcl", "ekf", "markov"):
        assert isinstance(bench.ask("set_method", SetMethod(method=method)), Done)
        assert bench.beliefs[-1].method == method
        for _ in range(3):
            bench.go((0.05, 0.0, 0.3))
        assert bench.poses[-1].state == "localized"
        assert bench.is_right(within=0.15)


def test_the_way_driven_since_the_last_measurement_is_not_lost(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    bench.clock.advance(0.3)
    bench.pose = bench.pose + np.array([0.0, 0.1, 0.0])
    bench.odom = bench.odom + np.array([0.0, 0.1, 0.0])
    before = bench.latest().pose
    bench.ask("set_method", SetMethod(method="mcl"))
    after = bench.latest().pose
    assert np.hypot(after.x - before.x, after.y - before.y) < 0.1


def test_a_pose_that_was_just_set_passes_to_the_next_method(bench: Bench) -> None:
    bench.begin()
    bench.ask("set_pose", SetPose(pose=pose2(bench.pose)))
    bench.ask("set_method", SetMethod(method="mcl"))
    bench.latest()
    assert bench.is_right(within=0.3)


def test_a_robot_that_knows_nothing_knows_nothing_by_the_next_method(bench: Bench) -> None:
    bench.begin()
    bench.ask("set_method", SetMethod(method="mcl"))
    assert bench.latest().state == "unknown"
    assert bench.beliefs[-1].entropy > 10.0


def test_the_method_in_use_can_be_asked_for_again(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    method = bench.method
    bench.ask("set_method", SetMethod(method="markov"))
    assert bench.method is method


def test_ekf_that_takes_over_from_nothing_knows_nothing(bench: Bench) -> None:
    bench.begin()
    bench.ask("set_method", SetMethod(method="ekf"))
    assert bench.method.name == "ekf"
    assert [bench.go(step).state for step in ROUND[:6]] == ["unknown"] * 6
    bench.ask("set_pose", SetPose(pose=pose2(bench.pose)))
    states = [bench.go((0.05, 0.0, 0.3)).state for _ in range(10)]
    assert states[-1] == "localized"
    assert bench.is_right()


def test_a_method_can_be_chosen_before_there_is_a_map(bench: Bench) -> None:
    bench.ask("set_method", SetMethod(method="mcl"))
    bench.begin()
    assert methods_of(bench) == ["mcl"]


def test_m1_stays_chosen_on_another_map_and_by_another_method(bench: Bench) -> None:
    bench.begin()
    bench.ask("set_algorithm", SetAlgorithm(algorithm="m1"))
    bench.put_map(AWAY)
    assert bench.method._recovery_weight == 0.0  # type: ignore[attr-defined]  # of Markov
    bench.ask("set_method", SetMethod(method="mcl"))
    assert not bench.method._recovers  # type: ignore[attr-defined]  # of the particles


def test_a_map_file_is_localized_on_in_place_of_the_mappers(bench: Bench, away: str) -> None:
    bench.begin()
    reply = bench.ask("set_map", SetMap(map=away))
    assert reply == MapLoaded(map_id=map_digest(AWAY), rows=64, cols=120)
    assert bench.beliefs[-1].map_id == map_digest(AWAY)
    bench.put_map()
    assert bench.beliefs[-1].map_id == map_digest(AWAY)


def test_the_mappers_map_is_asked_for_by_its_id(bench: Bench, away: str) -> None:
    bench.begin()
    bench.ask("set_map", SetMap(map=away))
    bench.ask("set_map", SetMap(map=FLAT_ID))
    assert bench.beliefs[-1].map_id == FLAT_ID


def test_another_map_of_the_mapper_ends_the_use_of_a_file(bench: Bench, away: str) -> None:
    bench.begin()
    bench.ask("set_map", SetMap(map=away))
    other = flat((1.0, 0.0, 0.0))
    bench.put_map(other)
    assert bench.beliefs[-1].map_id == map_digest(other)


def test_a_map_file_needs_no_mapper(bench: Bench, away: str) -> None:
    bench.describe()
    bench.ask("set_map", SetMap(map=away))
    assert bench.beliefs[-1].map_id == map_digest(AWAY)
    bench.put_map()
    assert bench.beliefs[-1].map_id == map_digest(AWAY)


def test_the_map_in_use_can_be_asked_for_again(bench: Bench) -> None:
    bench.begin()
    bench.drive_round()
    bench.ask("set_map", SetMap(map=FLAT_ID))
    assert bench.latest().state == "localized"


@pytest.mark.parametrize(
    ("asked", "reason"),
    [
        ("nowhere.yaml", "nowhere.yaml: the map file does not exist"),
        ("0123456789abcdef", f"the mapper's map is {FLAT_ID}, not '0123456789abcdef'"),
        ("", "the path is empty"),
    ],
)
def test_an_unknown_map_is_refused_and_the_old_one_stays(
    bench: Bench, asked: str, reason: str
) -> None:
    bench.begin()
    bench.drive_round()
    with pytest.raises(RefusedError) as refused:
        bench.ask("set_map", SetMap(map=asked))
    assert reason in str(refused.value)
    assert bench.go(STANDING).state == "localized"
    assert bench.is_right()
    assert bench.service._at.choice.map_file == ""


def test_without_any_map_an_unknown_one_is_refused(bench: Bench) -> None:
    with pytest.raises(RefusedError, match="the mapper serves no map"):
        bench.ask("set_map", SetMap(map="nowhere.yaml"))


def test_a_map_where_nobody_can_stand_is_refused(bench: Bench, tmp_path: Path) -> None:
    bench.begin()
    full = OccupancyMap(GridGeometry(4, 4, 0.1), np.full((4, 4), 100, np.int8))
    save_map(full, tmp_path / "full.yaml")
    with pytest.raises(RefusedError, match="no free cell"):
        bench.ask("set_map", SetMap(map=str(tmp_path / "full.yaml")))
    assert bench.beliefs[-1].map_id == FLAT_ID


def crash(bench: Bench) -> None:
    """End the localizer as kill -9 does, and let another one take its place."""
    bench.crash_localizer()
    bench.describe()


def test_a_crashed_localizer_goes_on_by_the_method_that_was_chosen(tmp_path: Path) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.drive_round()
    bench.ask("set_method", SetMethod(method="mcl"))
    crash(bench)
    bench.put_map()
    assert bench.method.name == "mcl"
    states = [bench.go((0.05, 0.0, 0.3)).state for _ in range(3)]
    assert states[-1] == "localized"
    assert bench.is_right(within=0.15)


def test_a_crashed_localizer_goes_on_by_m1_if_that_was_chosen(tmp_path: Path) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.ask("set_algorithm", SetAlgorithm(algorithm="m1"))
    crash(bench)
    bench.put_map()
    assert bench.method._recovery_weight == 0.0  # type: ignore[attr-defined]  # of Markov


def test_a_crashed_localizer_goes_on_on_the_file_that_was_chosen(tmp_path: Path, away: str) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.ask("set_map", SetMap(map=away))
    crash(bench)
    assert bench.beliefs[-1].map_id == map_digest(AWAY)
    bench.put_map()
    assert bench.beliefs[-1].map_id == map_digest(AWAY)


def test_a_chosen_file_that_is_gone_after_a_crash_gives_way_to_the_mappers_map(
    tmp_path: Path, away: str, caplog: pytest.LogCaptureFixture
) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.ask("set_map", SetMap(map=away))
    Path(away).unlink()
    with caplog.at_level(logging.WARNING):
        crash(bench)
    assert any("cannot be used any more" in record.message for record in caplog.records)
    bench.put_map()
    assert bench.beliefs[-1].map_id == FLAT_ID


def test_settings_that_were_edited_count_more_than_what_was_chosen(tmp_path: Path) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.drive_round()
    bench.ask("set_method", SetMethod(method="mcl"))
    bench.settings = LocalizerSettings(headings=24, resolution=0.2)
    crash(bench)
    bench.put_map()
    assert bench.method.name == "markov"
    assert bench.go((0.1, 0.0, 0.3)).state == "localized"
    assert bench.is_right(within=0.2)


def test_what_relocalize_forgot_does_not_come_back_with_a_crash(tmp_path: Path) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.drive_round()
    bench.ask("relocalize", Nothing())
    assert not (tmp_path / MEMORY_FILE).exists()
    crash(bench)
    bench.put_map()
    assert bench.beliefs[-1].entropy > 10.0


def test_a_set_pose_outlives_a_crash_that_comes_before_the_next_scan(tmp_path: Path) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.drive_round()
    bench.ask("set_pose", SetPose(pose=pose2(np.array([8.6, 1.0, 2.6]))))
    crash(bench)
    bench.put_map()
    said = bench.latest().pose
    assert np.hypot(said.x - 8.6, said.y - 1.0) < 0.3


def test_a_robot_that_restarted_while_the_localizer_was_down_is_not_moved(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.drive_round()
    bench.go(STANDING, seconds=1.5)
    bench.odom = np.zeros(3)
    with caplog.at_level(logging.WARNING):
        crash(bench)
        bench.put_map()
        states = [bench.go(STANDING).state for _ in range(3)]
    assert any("counting anew" in record.message for record in caplog.records)
    assert states[-1] == "localized"
    assert bench.is_right()


def test_a_damaged_memory_is_said_and_ignored(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / MEMORY_FILE).write_bytes(b"\x00" * 500)
    (tmp_path / CHOICE_FILE).write_bytes(b"\x00" * 500)
    with caplog.at_level(logging.WARNING):
        bench = Bench(folder=tmp_path)
        bench.begin()
    assert bench.beliefs[-1].entropy > 10.0
    assert (
        bench.service._node.vitals.last_error == f"memory: {MEMORY_FILE} is ignored: it is damaged"
    )
    assert [record.message for record in caplog.records] == [
        f"memory: {CHOICE_FILE} is ignored: it is damaged"
    ]


def test_the_way_driven_while_nobody_localized_is_made_up_for(tmp_path: Path) -> None:
    bench = Bench(folder=tmp_path)
    bench.begin()
    bench.drive_round()
    bench.go(STANDING, seconds=1.5)
    crash(bench)
    bench.put_map()
    assert bench.go((-0.3, 0.0, 0.2), seconds=3.0).state == "localized"
    assert bench.is_right()
