"""`pilotage map`: a log in; a map, a way, a picture and a report out."""

import io
import json
import math
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from dead_reckoning import DeadReckoning
from localizer_world import RANGE_MAX, ROUND, START, flat, poses_along
from pilotage import cli
from pilotage.core import se2
from pilotage.core.map_files import load_map
from pilotage.core.raycast import cast_scan
from pilotage.mapper import methods
from slam_metrics import read_tum

WORLD = flat()
FRONT = np.linspace(-math.pi / 2.0, math.pi / 2.0, 91)
RING = np.arange(8) * math.tau / 8
PRODUCTS = ["map.pgm", "map.png", "map.yaml", "pose_graph.g2o", "report.json", "trajectory.tum"]


def words(*values: float) -> str:
    return " ".join(f"{value:.5f}" for value in values)


def lines_of_log() -> list[str]:
    """A CARMEN log of the way through the flat, with laser and sonar ring."""
    lines = []
    for count, pose in enumerate(poses_along(START, ROUND[:9])):
        tail = f"{100.0 + count:.6f} host 0.0"
        odom = words(*se2.between(START, pose))
        ranges = words(*np.minimum(cast_scan(WORLD, pose, FRONT, RANGE_MAX), 80.0))
        echoes = words(*np.minimum(cast_scan(WORLD, pose, RING, 4.0), 9.0))
        mounts = " ".join(f"0 0 {bearing:.5f}" for bearing in RING)
        lines += [
            f"ODOM {odom} 0 0 0 {tail}",
            f"FLASER {len(FRONT)} {ranges} {odom} {odom} {tail}",
            f"SONAR 0.4 {len(RING)} {echoes} {mounts} {tail}",
        ]
    return lines


class Desk:
    """The files of one test, and the command run on them."""

    def __init__(self, folder: Path) -> None:
        self.log, self.out = folder / "run.log", folder / "out"
        self.log.write_text("\n".join(lines_of_log()) + "\n", encoding="utf-8")
        self.methods: list[DeadReckoning] = []

    def run(self, *more: str) -> int:
        return cli.run(["map", str(self.log), "--out", str(self.out), *more])

    def made(self, name: str) -> DeadReckoning:
        self.methods.append(DeadReckoning(name))
        return self.methods[-1]

    @property
    def report(self) -> dict[str, object]:
        report: dict[str, object] = json.loads((self.out / "report.json").read_text("utf-8"))
        return report


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Desk:
    desk = Desk(tmp_path)
    makers = {name: lambda _setup, name=name: desk.made(name) for name in ("laser", "sonar")}
    monkeypatch.setattr(methods, "METHODS", makers)
    return desk


def test_all_files_of_the_map_are_written_and_nothing_else(desk: Desk) -> None:
    assert desk.run() == 0
    assert sorted(file.name for file in desk.out.iterdir()) == PRODUCTS


def test_map_loads_with_its_walls_and_unknown_cells(desk: Desk) -> None:
    assert desk.run() == 0
    world = load_map(desk.out / "map.yaml")
    assert set(np.unique(world.cells)) == {-1, 0, 100}
    (cell,) = world.geometry.cells_of(np.zeros((1, 2)))
    assert world.cells[tuple(cell)] == 0
    method = desk.methods[0].map()
    assert ((world.cells < 0) == (method.cells < 0)).all()
    assert ((world.cells == 100) == (method.cells == 95)).all()


def test_trajectory_has_all_stamps_of_odometry(desk: Desk) -> None:
    assert desk.run() == 0
    stamps, poses = read_tum(desk.out / "trajectory.tum")
    truth = np.array([se2.between(START, pose) for pose in poses_along(START, ROUND[:9])])
    assert stamps.tolist() == [100.0 + k for k in range(len(truth))]
    assert poses == pytest.approx(truth, abs=1e-4)


def test_picture_is_a_png_of_a_decent_size(desk: Desk) -> None:
    assert desk.run() == 0
    image = Image.open(io.BytesIO((desk.out / "map.png").read_bytes()))
    assert image.format == "PNG"
    assert min(image.size) > 300
    assert max(image.size) < 5000


def test_report_has_the_keys_that_others_rely_on(desk: Desk) -> None:
    assert desk.run() == 0
    report = desk.report
    assert report["scans"] == 10
    assert report["log_duration_s"] == 9.0
    for name in ("wall_s", "cpu_s", "peak_rss_mb", "free_m2", "driven_m"):
        assert float(str(report[name])) > 0.0
    assert (report["sensor"], report["closures"], report["skipped_lines"]) == ("laser", 0, 0)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress_is_shown_on_a_terminal_only(
    desk: Desk, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert desk.run() == 0
    assert capsys.readouterr() == ("", "")
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    assert desk.run() == 0
    assert "mapping" in terminal.getvalue()
    assert "10/10" in terminal.getvalue()


def test_sonar_is_mapped_with_on_request_and_where_there_is_no_laser(desk: Desk) -> None:
    assert desk.run("--sensor", "sonar") == 0
    assert desk.report["sensor"] == "sonar"
    desk.log.write_text("\n".join(line for line in lines_of_log() if not line.startswith("FL")))
    assert desk.run() == 0
    assert desk.report["sensor"] == "sonar"


def test_few_beams_are_enough_for_a_run(desk: Desk) -> None:
    assert desk.run("--beams", "11") == 0
    assert desk.report["scans"] == 10


BAD_ARGUMENTS = {
    "--beams 1": "--beams",
    "--beams 11 --sensor sonar": "sonar has none to spare",
    "--sensor radar": "radar",
    "--model atm --sensor laser": "chosen for the sonar",
    "--model cubist --sensor sonar": "there is no model 'cubist'",
    "--format betamax": "unknown format 'betamax'",
}


@pytest.mark.parametrize(("arguments", "reason"), BAD_ARGUMENTS.items())
def test_bad_arguments_end_with_2_and_one_line(
    desk: Desk, arguments: str, reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert desk.run(*arguments.split()) == 2
    assert_one_line(capsys, reason)
    assert not desk.out.exists()


BAD_LOGS = {
    "empty": b"",
    "binary": bytes(range(256)) * 20,
    "gzip": b"\x1f\x8b\x08\x00garbage",
    "prose": b"it was a dark and stormy night\n" * 30,
    "odometry only": b"ODOM 0 0 0 0 0 0 1 host 1\nODOM 1 0 0 0 0 0 2 host 2\n",
    "scans only": b"RAWLASER1 0 -1.5 3.0 1.5 8.0 0.01 0 3 1.0 2.0 8.0 0 1 host 1\n" * 3,
}


@pytest.mark.parametrize("content", BAD_LOGS.values(), ids=BAD_LOGS.keys())
def test_log_that_cannot_be_mapped_ends_with_2_and_one_line(
    desk: Desk, content: bytes, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.log.write_bytes(content)
    assert desk.run() == 2
    assert_one_line(capsys, "")
    assert not desk.out.exists()


def test_pipe_is_no_log(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    desk.log.unlink()
    os.mkfifo(desk.log)
    assert desk.run() == 2
    assert_one_line(capsys, "pipe or a device")


def test_missing_log_and_empty_folder_are_told(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.log.unlink()
    assert desk.run() == 2
    assert_one_line(capsys, "does not exist")
    desk.log.mkdir()
    assert desk.run() == 2
    assert_one_line(capsys, str(desk.log))


def test_out_that_is_a_file_is_told(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    desk.out.write_text("mine")
    assert desk.run() == 2
    assert_one_line(capsys, "takes a folder")
    assert desk.out.read_text() == "mine"
    assert cli.run(["map", str(desk.log), "--out", str(desk.out / "below")]) == 2
    assert_one_line(capsys, "takes a folder")


def test_old_map_stays_where_the_new_log_is_damaged(desk: Desk) -> None:
    assert desk.run() == 0
    before = {file.name: file.read_bytes() for file in desk.out.iterdir()}
    desk.log.write_bytes(b"nothing")
    assert desk.run() == 2
    assert {file.name: file.read_bytes() for file in desk.out.iterdir()} == before


def test_log_that_shows_nothing_leaves_no_files(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    blind = " ".join(["80.0"] * 91)
    desk.log.write_text(f"FLASER 91 {blind} 0 0 0 0 0 0 1 host 1\n" * 3)
    assert desk.run() == 2
    assert_one_line(capsys, "nothing to map")
    assert list(desk.out.iterdir()) == []


def assert_one_line(capsys: pytest.CaptureFixture[str], reason: str) -> None:
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith("pilotage: ")
    assert told.err.count("\n") == 1
    assert reason in told.err


def test_folder_that_cannot_be_written_to_is_told_before_any_work(
    desk: Desk, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "access", lambda path, _: Path(path) != desk.out)
    assert desk.run() == 2
    assert_one_line(capsys, "nothing can be written there")
