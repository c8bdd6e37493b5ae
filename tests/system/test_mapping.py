"""Mapping with real processes: a map is made, survives a kill, is kept, and is localized on."""

import io
import os
import signal
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path

import httpx
import numpy as np
import pytest

import processes
from mapping_run import Listener, deployment
from pages import Page
from pilotage.core.map_files import load_map, map_digest
from runs import Run, figure
from waiting import eventually

pytestmark = [pytest.mark.system, pytest.mark.timeout(240)]
COLD_S = 120.0
RIGHT_M = 0.5


@pytest.fixture(scope="module")
def port() -> int:
    return processes.free_port()


@pytest.fixture(scope="module", params=["toys.up", "pilotage"])
def heard(
    request: pytest.FixtureRequest, port: int, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Listener]:
    """A run that maps from its start: by dead reckoning, and by the mapper's own method."""
    folder = tmp_path_factory.mktemp("mapping")
    file, endpoint = deployment(folder, port)
    arguments = {
        "toys.up": [str(file)],
        "pilotage": ["up", str(file), "--no-browser"],
    }[request.param]
    with Run(request.param, arguments, folder) as run, Page(port) as page:
        eventually(lambda: page.answers("/healthz"), COLD_S, "/healthz")
        with Listener(endpoint) as listener:
            listener.until(lambda: listener.errors, COLD_S, "a localized pose")
            yield listener
        assert "Traceback" not in run.text, run.text


@pytest.fixture
def page(port: int) -> Iterator[Page]:
    with Page(port) as page:
        yield page


@pytest.fixture
def client(port: int) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=20.0) as client:
        yield client


def known(heard: Listener) -> int:
    """How many cells the newest whole map knows."""
    return int((heard.maps[-1].cells >= 0).sum())


def test_the_map_grows_while_the_robot_wanders(heard: Listener) -> None:
    began = time.time_ns()
    heard.until(lambda: heard.maps, 20.0, "a map")
    first = known(heard)
    heard.until(lambda: known(heard) > 1.3 * first, 60.0, "the map growing")
    assert heard.maps[-1].in_progress
    assert heard.patches
    assert heard.worst_since(began) < RIGHT_M
    assert heard.longest_silence_since(began) < 1.0
    figure(f"mapping: at most {heard.worst_since(began):.3f} m off, {len(heard.patches)} patches")


def test_a_mapper_that_is_killed_goes_on_with_its_map(heard: Listener, page: Page) -> None:
    heard.until(lambda: heard.status.steps > 60, 60.0, "some mapping")
    since, steps, before = heard.status.since_ns, heard.status.steps, page.process("mapper")
    began, killed = time.monotonic(), time.time_ns()
    os.kill(before["pid"], signal.SIGKILL)
    eventually(lambda: page.is_back("mapper", before["restarts"]), 30.0, "the mapper again")
    figure(f"mapper: ready {time.monotonic() - began:.1f} s after it was killed")
    heard.until(lambda: heard.statuses[-1].stamp_ns > killed, 20.0, "its status")
    assert heard.status.mode == "mapping"
    assert heard.status.since_ns == since
    assert heard.status.steps >= steps - 55
    heard.until(lambda: heard.errors[-1][0] > killed + 2_000_000_000, 20.0, "poses again")
    assert heard.worst_since(killed) < RIGHT_M
    figure(
        f"mapper: {steps - heard.status.steps} steps back, {heard.worst_since(killed):.3f} m off"
    )


def test_a_map_is_kept_listed_and_downloaded(
    heard: Listener, page: Page, client: httpx.Client, tmp_path: Path
) -> None:
    assert heard.status.mode == "mapping"
    saved = page.command("map_save", name="office")
    listed = client.get("/api/v1/maps").json()["maps"]
    assert [one["name"] for one in listed] == ["office"]
    assert listed[0]["can_go_on"]
    archive = zipfile.ZipFile(io.BytesIO(client.get("/api/v1/maps/office/archive").content))
    archive.extractall(tmp_path)
    assert map_digest(load_map(tmp_path / "map.yaml")) == saved["map_id"]
    assert (tmp_path / "trajectory.tum").read_text().count("\n") > 40
    assert "VERTEX_SE2" in (tmp_path / "pose_graph.g2o").read_text()


def test_the_localizer_takes_over_without_a_gap_or_a_wrong_pose(
    heard: Listener, page: Page
) -> None:
    # It stands where it has mapped, for it may be honest about what it drives into afterwards.
    page.command("stop")
    began = time.time_ns()
    page.command("map_stop")
    heard.until(lambda: heard.status.mode == "idle", 60.0, "the hand-over")
    figure(f"hand-over: {(time.time_ns() - began) / 1e9:.2f} s")
    ended = time.time_ns()
    heard.until(lambda: heard.poses[-1].stamp_ns > ended + 5_000_000_000, 30.0, "poses on")
    assert heard.longest_silence_since(began) < 1.0
    assert heard.worst_since(began) < RIGHT_M
    states = [one.state for one in heard.poses if one.stamp_ns > ended]
    assert np.mean([state == "localized" for state in states]) > 0.9
    assert not heard.maps[-1].in_progress
    figure(
        f"hand-over: longest silence {heard.longest_silence_since(began):.2f} s, "
        f"at most {heard.worst_since(began):.3f} m off"
    )


def test_a_kept_map_can_be_used_and_deleted(
    heard: Listener, page: Page, client: httpx.Client
) -> None:
    assert client.post("/api/v1/maps/office/activate").status_code == httpx.codes.OK
    heard.until(lambda: heard.maps[-1].name == "office", 10.0, "the kept map")
    page.command("map_save", name="again")
    assert client.delete("/api/v1/maps/office").status_code == httpx.codes.OK
    assert [one["name"] for one in client.get("/api/v1/maps").json()["maps"]] == ["again"]
