"""`pilotage localize`: a log and a map in, a table and a report out."""

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest

from localizer_world import RANGE_MAX, ROUND, START, error, flat, poses_along
from pilotage import cli, localize_command
from pilotage.core import se2
from pilotage.core.map_files import save_map
from pilotage.core.raycast import cast_scan
from pilotage.localize_command import parse_start
from pilotage.localizer.markov_localizer import MarkovParams
from pilotage.localizer.methods import MethodSetup
from pilotage.localizer.pose_grid import PoseGridParams

WORLD = flat()
FRONT = np.linspace(-math.pi / 2.0, math.pi / 2.0, 91)
RING = np.arange(8) * math.tau / 8
HEADER = ["stamp", "x", "y", "theta", "state", "confidence"]
STEPS = ROUND[:9]


def words(*values: float) -> str:
    return " ".join(f"{value:.5f}" for value in values)


def lines_of_log() -> list[str]:
    """A CARMEN log of the way through the flat, with laser, sonar ring and compass."""
    lines = []
    for count, pose in enumerate(poses_along(START, STEPS)):
        tail = f"{100.0 + count:.6f} host 0.0"
        odom = words(*se2.between(START, pose))
        ranges = words(*np.minimum(cast_scan(WORLD, pose, FRONT, RANGE_MAX), 80.0))
        echoes = words(*np.minimum(cast_scan(WORLD, pose, RING, 4.0), 9.0))
        mounts = " ".join(f"0 0 {bearing:.5f}" for bearing in RING)
        lines += [
            f"ODOM {odom} 0 0 0 {tail}",
            f"COMPASS {pose[2]:.5f} 0.1 {100.0 + count:.6f}",
            f"FLASER {len(FRONT)} {ranges} {odom} {odom} {tail}",
            f"SONAR 0.4 {len(RING)} {echoes} {mounts} {tail}",
        ]
    return lines


class Desk:
    """The files of one test, and the command run on them."""

    def __init__(self, folder: Path) -> None:
        self.log, self.map, self.out = folder / "run.log", folder / "flat.yaml", folder / "out"
        save_map(WORLD, self.map)
        self.write(lines_of_log())

    def write(self, lines: list[str]) -> None:
        self.log.write_text("\n".join(lines) + "\n", encoding="utf-8")

    def run(self, *more: str) -> int:
        return cli.run(
            ["localize", str(self.log), "--map", str(self.map), "--out", str(self.out), *more]
        )

    @property
    def rows(self) -> list[dict[str, str]]:
        with (self.out / "estimates.csv").open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            rows = list(reader)
            assert list(reader.fieldnames or []) == HEADER
        return rows

    @property
    def report(self) -> dict[str, object]:
        return dict(json.loads((self.out / "report.json").read_text(encoding="utf-8")))


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


def pose_of(row: dict[str, str]) -> list[float]:
    return [float(row[name]) for name in ("x", "y", "theta")]


def test_table_has_one_row_a_scan_and_ends_at_the_truth(desk: Desk) -> None:
    assert desk.run() == 0
    truth = list(poses_along(START, STEPS))
    assert [float(row["stamp"]) for row in desk.rows] == [100.0 + k for k in range(len(truth))]
    away, turn = error(pose_of(desk.rows[-1]), truth[-1])
    assert away < 0.1
    assert turn < 0.05
    assert {row["state"] for row in desk.rows} <= {"unknown", "ambiguous", "localized", "lost"}
    assert desk.rows[-1]["state"] == "localized"
    assert all(0.0 <= float(row["confidence"]) <= 1.0 for row in desk.rows)


def test_report_says_what_it_cost(desk: Desk) -> None:
    assert desk.run() == 0
    report = desk.report
    assert report["scans"] == len(STEPS) + 1
    for name in ("wall_s", "cpu_s", "peak_rss_mb", "states", "resolution_m"):
        assert float(str(report[name])) > 0.0
    cost = report["cpu_ms_per_update"]
    assert isinstance(cost, dict)
    assert set(cost) == {"p50", "p95", "first"}
    assert 0.0 < cost["p50"] <= cost["p95"]
    assert report["skipped_lines"] == 0


def test_the_report_has_the_keys_that_others_rely_on(desk: Desk) -> None:
    assert desk.run() == 0
    assert {"scans", "cpu_s", "wall_s", "cpu_ms_per_update", "peak_rss_mb"} <= set(desk.report)
    assert (desk.report["method"], desk.report["coarsened"]) == ("markov", False)


def test_particles_localize_too_and_say_the_same_every_time(desk: Desk) -> None:
    assert desk.run("--method", "mcl") == 0
    away, turn = error(pose_of(desk.rows[-1]), list(poses_along(START, STEPS))[-1])
    assert away < 0.15
    assert turn < 0.05
    assert desk.rows[-1]["state"] == "localized"
    assert desk.report["method"] == "mcl"
    assert int(str(desk.report["particles"])) > 100
    first = desk.rows
    assert desk.run("--method", "mcl") == 0
    assert desk.rows == first


def test_particles_take_a_start_and_the_sonar_too(desk: Desk) -> None:
    start = ",".join(str(part) for part in START)
    assert desk.run("--method", "mcl", "--sensor", "sonar", "--start", start) == 0
    assert error(pose_of(desk.rows[0]), START)[0] < 0.2


def test_a_building_too_large_for_its_cells_is_said_and_reported(
    desk: Desk, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    few = MethodSetup(markov=MarkovParams(grid=PoseGridParams(most_states=200_000)))
    monkeypatch.setattr(localize_command, "MethodSetup", lambda: few)
    assert desk.run() == 0
    report = desk.report
    assert report["coarsened"] is True
    resolution = float(str(report["resolution_m"]))
    assert resolution > 0.1
    assert capsys.readouterr().err == (
        "pilotage: the map is too large for cells of 0.1 m: "
        f"it is localized on with cells of {resolution:.3g} m\n"
    )


def test_a_start_that_is_given_is_used_from_the_first_scan_on(desk: Desk) -> None:
    assert desk.run("--start", ",".join(str(part) for part in START)) == 0
    assert error(pose_of(desk.rows[0]), START)[0] < 0.1


def test_sonar_localizes_in_place_of_the_laser(desk: Desk) -> None:
    assert desk.run("--sensor", "sonar", "--start", ",".join(str(part) for part in START)) == 0
    assert len(desk.rows) == len(STEPS) + 1
    *_, truth = poses_along(START, STEPS)
    assert error(pose_of(desk.rows[-1]), truth)[0] < 0.4


def test_a_compass_that_is_wrong_can_be_left_out(desk: Desk) -> None:
    desk.write([line.replace("COMPASS ", "COMPASS 1") for line in lines_of_log()])
    assert desk.run("--no-compass") == 0
    *_, truth = poses_along(START, STEPS)
    assert error(pose_of(desk.rows[-1]), truth)[0] < 0.1


def test_scans_before_the_first_odometry_have_their_rows_too(desk: Desk) -> None:
    raw = "RAWLASER1 0 -1.5 3.0 1.5 8.0 0.01 0 3 1.0 2.0 8.0 0 90.0 host 0.0"
    odometry = [line for line in lines_of_log() if line.startswith("ODOM")]
    desk.write([raw, *odometry])
    assert desk.run() == 0
    (row,) = desk.rows
    assert (float(row["stamp"]), row["state"]) == (90.0, "unknown")
    assert desk.report["cpu_ms_per_update"] == {"p50": None, "p95": None, "first": None}


def test_damaged_lines_are_passed_over_and_counted(desk: Desk) -> None:
    desk.write([*lines_of_log(), "FLASER 90 1.0 2.0", "ODOM x"])
    assert desk.run() == 0
    assert desk.report["skipped_lines"] == 2


def test_the_folder_for_the_output_is_made(desk: Desk) -> None:
    desk.out = desk.out / "deep" / "er"
    assert desk.run() == 0
    assert desk.rows


def complaint(desk: Desk, capsys: pytest.CaptureFixture[str], *more: str) -> str:
    """Run the command, which must be refused; return its one line."""
    assert desk.run(*more) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert not (desk.out / "estimates.csv").exists()
    return said.err.strip()


def test_a_missing_log_is_refused(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    desk.log = desk.log.with_name("gone.log")
    assert "gone.log" in complaint(desk, capsys)


def test_a_missing_map_is_refused(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    desk.map = desk.map.with_name("gone.yaml")
    assert "gone.yaml" in complaint(desk, capsys)


def test_a_log_in_place_of_the_map_is_refused(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.map = desk.log
    assert "run.log" in complaint(desk, capsys)


def test_a_map_in_place_of_the_log_is_refused(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.log = desk.map
    assert "flat.yaml" in complaint(desk, capsys)


@pytest.mark.parametrize("start", ["here", "1,2", "1,2,3,4", "1,nan,0", "inf,0,0", "", "1;2;3"])
def test_a_start_that_is_none_is_refused(
    desk: Desk, capsys: pytest.CaptureFixture[str], start: str
) -> None:
    assert "--start takes 'unknown' or X,Y,THETA" in complaint(desk, capsys, "--start", start)


def test_a_start_off_the_map_is_refused(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    assert "free space" in complaint(desk, capsys, "--start", "400,0,0")


def test_a_log_without_the_sensor_is_refused(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.write([line for line in lines_of_log() if not line.startswith("SONAR")])
    assert "no sonar" in complaint(desk, capsys, "--sensor", "sonar")
    desk.write([line for line in lines_of_log() if not line.startswith("FLASER")])
    assert "no laser" in complaint(desk, capsys)


def test_a_map_where_nobody_can_stand_is_refused(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    full = flat()
    full.cells[:] = 100
    save_map(full, desk.map)
    assert "no free cell" in complaint(desk, capsys)


def test_walls_are_followed_from_a_start(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    start = ",".join(str(part) for part in START)
    assert desk.run("--method", "ekf", "--start", start) == 0
    assert capsys.readouterr().err == ""
    away, turn = error(pose_of(desk.rows[-1]), list(poses_along(START, STEPS))[-1])
    assert away < 0.1
    assert turn < 0.05
    assert desk.rows[-1]["state"] == "localized"
    assert desk.report["method"] == "ekf"
    assert int(str(desk.report["map_lines"])) > 10


def test_walls_alone_find_no_start_and_that_is_said_in_one_line(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    assert desk.run("--method", "ekf") == 0
    said = capsys.readouterr().err
    assert said.startswith("pilotage: ekf follows a robot but finds none: without --start")
    assert said.count("\n") == 1
    assert {row["state"] for row in desk.rows} == {"unknown"}
    assert {row["confidence"] for row in desk.rows} == {"0.0000"}


@pytest.mark.parametrize(
    "options",
    [["--method", "magic"], ["--sensor", "nose"], ["--format", "cuneiform"], ["--nope"]],
)
def test_unknown_words_are_refused(
    desk: Desk, capsys: pytest.CaptureFixture[str], options: list[str]
) -> None:
    assert options[-1] in complaint(desk, capsys, *options)


def test_a_file_in_place_of_the_output_folder_is_refused(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.out = desk.log
    said = complaint(desk, capsys)
    assert said == f"pilotage: --out takes a folder; {desk.log} is a file"


def test_an_output_folder_below_a_file_is_refused(
    desk: Desk, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.out = desk.log / "deep"
    said = complaint(desk, capsys)
    assert said == f"pilotage: --out {desk.out}: cannot be made: Not a directory"


def test_a_start_is_read_as_numbers() -> None:
    assert parse_start("unknown") is None
    assert parse_start("1.5,-2,3e-1") == pytest.approx([1.5, -2.0, 0.3])
