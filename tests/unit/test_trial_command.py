"""`pilotage trial`: a map in, a report and a picture out, or one line and code 2."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pilotage import cli
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.map_files import save_map
from pilotage.experiments import trial_run
from pilotage.experiments.trial_entrants import POLICIES
from trial_floors import TWINS, floor_of


class Desk:
    """The files of one test, and the command run on them."""

    def __init__(self, folder: Path) -> None:
        self.map, self.out = folder / "twins.yaml", folder / "out"
        save_map(TWINS, self.map)

    def run(self, policy: str, *more: str) -> int:
        files = ["--map", str(self.map), "--out", str(self.out)]
        return cli.run(["trial", *files, "--policy", policy, *more])

    @property
    def report(self) -> dict[str, Any]:
        report: dict[str, Any] = json.loads((self.out / "report.json").read_text("utf-8"))
        return report


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


def complaint(capsys: pytest.CaptureFixture[str], code: int) -> str:
    assert code == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    return said.err


def test_a_report_and_the_tracks_are_written(
    desk: Desk, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trial_run, "LONGEST_TIME", 5.0)
    reports = []
    for policy in ("random", "fixed"):
        assert desk.run(policy, "--runs", "1", "--seed", "3") == 0
        reports.append(desk.report)
    assert {path.name for path in desk.out.iterdir()} == {"report.json", "tracks.png"}
    random, fixed = reports
    assert (random["policy"], fixed["policy"]) == ("random", "fixed")
    assert random["map"] == "twins.yaml"
    assert random["starts"] == fixed["starts"]
    assert [run["start"] for run in random["runs"]] == [run["start"] for run in fixed["runs"]]
    assert {"localized", "correct", "travel_m", "steps"} <= set(random["runs"][0])
    said = capsys.readouterr()
    assert said.out == said.err == ""


def test_an_unknown_policy_is_refused_and_the_known_are_named(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    said = complaint(capsys, desk.run("fly"))
    assert "'fly'" in said
    assert all(name in said for name in POLICIES)
    assert not desk.out.exists()


def test_a_map_that_is_not_there_is_told(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    desk.map.unlink()
    assert complaint(capsys, desk.run("random")).count("twins.yaml") == 1


def test_a_damaged_map_is_told(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    desk.map.write_text("image: nothing\n", "utf-8")
    assert "twins.yaml" in complaint(capsys, desk.run("random"))


def test_a_map_without_room_is_told(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    save_map(floor_of("### #.# ###"), desk.map)
    assert "no free place" in complaint(capsys, desk.run("random"))


def test_a_map_without_free_cells_is_told(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    save_map(OccupancyMap(GridGeometry(4, 4, 0.1), np.full((4, 4), 100, np.int8)), desk.map)
    assert "no free cell" in complaint(capsys, desk.run("random"))


def test_a_file_in_place_of_the_folder_is_told(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.out.write_text("here already", "utf-8")
    assert "out" in complaint(capsys, desk.run("random"))


@pytest.mark.parametrize("option", [("--runs", "0"), ("--seed", "-1"), ("--sight", "0")])
def test_numbers_that_make_no_sense_are_refused(
    desk: Desk, capsys: pytest.CaptureFixture[str], option: tuple[str, str]
) -> None:
    assert option[0] in complaint(capsys, desk.run("random", *option))
