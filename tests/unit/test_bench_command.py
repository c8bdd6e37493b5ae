"""`pilotage bench`: a file of figures and a table, or one line and code 2."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pilotage import bench_command, cli
from pilotage.bench.entry import Entry, Size, Stopwatch


def two_entries(watch: Stopwatch, peak_mb: Callable[[], float]) -> Iterator[Entry]:
    """A suite of two, which asks what it was given."""
    assert peak_mb() > 1.0
    yield Entry("grid", Size(1000, 4), watch.ms(lambda: None), 20.0, 0.5)
    yield Entry("cloud", Size(10, 60, "particles"), 0.0, 3.0, 1.0, {"memory_mb": 12.0})


@pytest.fixture(autouse=True)
def _short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_command, "run_suite", two_entries)


def test_figures_are_written_and_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "figures.json"
    assert cli.run(["bench", "--out", str(out)]) == 0
    grid, cloud = json.loads(out.read_text("utf-8"))
    assert grid["states"] == 1000
    assert grid["reference_fraction"] == 0.5
    assert cloud == {
        "name": "cloud",
        "particles": 10,
        "beams": 60,
        "cpu_ms": 0.0,
        "reference_cpu_ms": 3.0,
        "reference_fraction": 1.0,
        "memory_mb": 12.0,
    }
    shown = capsys.readouterr().out
    assert "1,000 states" in shown
    assert "memory_mb 12.0" in shown


@pytest.mark.parametrize("name", [".", "missing/figures.json"])
def test_a_file_that_cannot_be_written_is_refused_before_any_work(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    name: str,
) -> None:
    monkeypatch.setattr(bench_command, "run_suite", None)
    assert cli.run(["bench", "--out", str(tmp_path / name)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert tmp_path.name in said.err


def test_bench_without_a_file_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["bench"]) == 2
    assert "--out" in capsys.readouterr().err
