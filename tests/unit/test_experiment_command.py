"""`pilotage experiment`: a report and plots, or one line and code 2."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from pilotage import cli
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.experiments import catalogue, corridor, kidnap, square_hall
from pilotage.experiments.catalogue import CATALOGUE, Experiment
from pilotage.experiments.outcome import Outcome, Request
from pilotage.experiments.symmetric_walk import Symmetry


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Request]:
    """An experiment `toy` that notes what it is asked."""
    requests: list[Request] = []

    def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
        requests.append(request)
        advance(1.0)
        return Outcome({"answer": 42}, {"toy": Figure()})

    monkeypatch.setitem(catalogue.CATALOGUE, "toy", Experiment("a toy", "nobody", 7, conduct))
    return requests


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert cli.run(["experiment", *arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    return said.err


def report_of(folder: Path) -> dict[str, Any]:
    report: dict[str, Any] = json.loads((folder / "report.json").read_text("utf-8"))
    return report


def test_the_list_names_every_experiment_and_its_paper(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["experiment", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    for line, (name, experiment) in zip(lines, CATALOGUE.items(), strict=True):
        assert line.startswith(name)
        assert experiment.paper in line


def test_a_report_and_plots_are_written(tmp_path: Path, asked: list[Request]) -> None:
    out = tmp_path / "new" / "folder"
    assert cli.run(["experiment", "toy", "--out", str(out)]) == 0
    assert {path.name for path in out.iterdir()} == {"report.json", "toy.png", "toy.svg"}
    report = report_of(out)
    assert report["experiment"] == "toy"
    assert report["answer"] == 42
    assert report["plots"] == ["toy"]
    assert asked == [Request(runs=7, seed=0)]


def test_runs_and_seed_are_handed_on(tmp_path: Path, asked: list[Request]) -> None:
    options = ["--runs", "3", "--seed", "5", "--out", str(tmp_path)]
    assert cli.run(["experiment", "toy", *options]) == 0
    assert asked == [Request(runs=3, seed=5)]


def test_an_unknown_experiment_is_refused_and_the_known_are_named(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    said = complaint(capsys, "fly", "--out", str(tmp_path / "out"))
    assert "'fly'" in said
    assert "square-hall" in said
    assert not (tmp_path / "out").exists()


def test_an_experiment_without_a_folder_is_refused(
    capsys: pytest.CaptureFixture[str], asked: list[Request]
) -> None:
    assert "--out" in complaint(capsys, "toy")
    assert asked == []


@pytest.mark.parametrize(
    "options", [("--runs", "0"), ("--runs", "-3"), ("--runs", "x"), ("--seed", "-1")]
)
def test_numbers_that_make_no_sense_are_refused(
    capsys: pytest.CaptureFixture[str], asked: list[Request], options: tuple[str, str]
) -> None:
    assert options[0] in complaint(capsys, "toy", *options, "--out", "x")
    assert asked == []


def test_a_folder_that_cannot_be_is_refused_before_any_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, asked: list[Request]
) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert "file" in complaint(capsys, "toy", "--out", str(tmp_path / "file"))
    assert "file" in complaint(capsys, "toy", "--out", str(tmp_path / "file" / "below"))
    assert asked == []


def test_the_same_seed_draws_the_same_plot(tmp_path: Path, asked: list[Request]) -> None:
    for name in ("a", "b"):
        cli.run(["experiment", "toy", "--out", str(tmp_path / name)])
    assert len(asked) == 2
    one, other = ((tmp_path / name / "toy.png").read_bytes() for name in ("a", "b"))
    assert one == other


def small_hall() -> OccupancyMap:
    """A featureless hall of 3 m x 3 m."""
    cells = np.full((32, 32), 100, np.int8)
    cells[1:-1, 1:-1] = 0
    return OccupancyMap(GridGeometry(32, 32, 0.1, (-0.1, -0.1, 0.0)), cells)


def test_every_experiment_writes_what_it_claims(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Each with its own code in a smaller place: the figures themselves are the experiments'."""
    monkeypatch.setattr(square_hall, "METRES", 2)
    monkeypatch.setattr(square_hall, "square_hall", small_hall)
    monkeypatch.setattr(square_hall, "HALL_SIZE", 3.0)
    monkeypatch.setattr(square_hall, "CLEAR", 0.8)
    monkeypatch.setattr(square_hall, "FOUR_FOLD", Symmetry(4, (1.5, 1.5)))
    monkeypatch.setattr(corridor, "METRES", 1)
    monkeypatch.setattr(kidnap, "square_hall", small_hall)
    monkeypatch.setattr("pilotage.experiments.kidnapping.CARRIED_AT_LEAST", 0.8)
    monkeypatch.setattr("pilotage.experiments.kidnapping.CLEAR", 0.6)
    for name in ("square-hall", "corridor", "kidnap"):
        assert cli.run(["experiment", name, "--runs", "1", "--out", str(tmp_path / name)]) == 0
        assert (tmp_path / name / f"{name}.png").stat().st_size > 10_000
        assert (tmp_path / name / f"{name}.svg").stat().st_size > 10_000
    hall = report_of(tmp_path / "square-hall")
    assert hall["states"] == 30 * 30 * 72
    assert hall["without_compass"]["modes"] == [4, 4]
    assert hall["with_compass"]["modes"] == [1, 1]
    assert report_of(tmp_path / "corridor")["with_compass"]["modes"] == [1]
    assert report_of(tmp_path / "kidnap")["m1"]["recovered"] == 0.0
    assert report_of(tmp_path / "kidnap")["m2"]["recovered"] == 1.0
