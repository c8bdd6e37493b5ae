"""Places and ways with real processes: the map appears, ways are found, nodes are reached."""

import json
import math
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import networkx as nx
import numpy as np
import pytest
from geojson_pydantic import FeatureCollection

import processes
from naive.routes import read_as_nav2_route
from pages import Page
from runs import REPOSITORY, Run, figure
from waiting import eventually

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]

DEMO = REPOSITORY / "deploy" / "config" / "demo.yaml"
COLD_S = 120.0
ALONG_M = 2.0
BEFORE_M = 1.5


@pytest.fixture(scope="module")
def port() -> int:
    return processes.free_port()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("topology")


@pytest.fixture(scope="module")
def page(port: int, folder: Path) -> Iterator[Page]:
    """The page of the demo, shared by the tests of this module, the robot localized."""
    arguments = ["up", str(DEMO), "--no-browser", "--port", str(port)]
    with Run("pilotage", arguments, folder) as run, Page(port) as page:
        eventually(lambda: page.answers("/healthz"), COLD_S, "/healthz")
        eventually(lambda: page.get("topology"), COLD_S, "the places")
        page.localized(COLD_S)
        yield page
        assert "Traceback" not in run.text, run.text


def topology(page: Page) -> dict[str, Any]:
    found = page.get("topology")
    assert found is not None
    return found


@contextmanager
def events(port: int) -> Iterator[list[str]]:
    """The texts of what happens meanwhile."""
    texts: list[str] = []
    address = f"http://127.0.0.1:{port}/api/v1/robots/demo/events"
    ended = threading.Event()

    def follow() -> None:
        with httpx.stream("GET", address, timeout=30.0) as answer:
            for line in answer.iter_lines():
                if line.startswith("data: "):
                    told = json.loads(line.removeprefix("data: "))
                    if told["stamp_ns"] > began:
                        texts.append(told["text"])
                if ended.is_set():
                    return

    began = time.time_ns()
    follower = threading.Thread(target=follow, daemon=True)
    follower.start()
    try:
        yield texts
    finally:
        ended.set()
        follower.join(15.0)


def before(node: dict[str, Any]) -> dict[str, float]:
    """A pose on the way to a node, looking at it."""
    pose = node["pose"]
    return {
        "x": pose["x"] - BEFORE_M * math.cos(pose["theta"]),
        "y": pose["y"] - BEFORE_M * math.sin(pose["theta"]),
        "theta": pose["theta"],
    }


def corridor_nodes(page: Page) -> list[dict[str, Any]]:
    """Nodes of the long corridor that are bound to many features."""
    nodes = topology(page)["nodes"]
    found = [one for one in nodes if "corridor" in one["name"] and len(one["features"]) >= 8]
    assert len(found) >= 3
    return found


def test_the_places_are_those_of_the_map_in_use(page: Page) -> None:
    world, grid = topology(page), page.get("map")
    assert grid is not None
    assert world["map_id"] == grid["map_id"]
    kinds = [node["kind"] for node in world["nodes"]]
    assert kinds.count("door") >= 20
    assert len(world["edges"]) >= len(world["nodes"]) - 5


def test_a_way_over_http_keeps_to_the_ways_of_the_map(page: Page) -> None:
    first, last = corridor_nodes(page)[0], corridor_nodes(page)[-1]
    goal = f"{last['pose']['x']:.3f},{last['pose']['y']:.3f}"
    began = time.monotonic()
    route = page.get(f"topology/route?from={first['id']}&to={goal}")
    taken = time.monotonic() - began
    assert route is not None
    assert (route["nodes"][0], route["nodes"][-1]) == (first["id"], last["id"])
    steps = np.hypot(*np.diff(np.array(route["way"]), axis=0).T)
    assert route["cost"] >= float(steps.sum()) - 0.1
    known = {edge["id"] for edge in topology(page)["edges"]}
    assert set(route["edges"]) <= known
    figure(f"a way of {steps.sum():.1f} m over HTTP: {1e3 * taken:.1f} ms")
    assert taken < 0.5


def test_the_geojson_is_what_nav2_reads(page: Page, port: int) -> None:
    answer = httpx.get(
        f"http://127.0.0.1:{port}/api/v1/robots/demo/topology",
        params={"format": "geojson"},
        timeout=20.0,
    )
    collection: FeatureCollection[Any] = FeatureCollection.model_validate_json(answer.content)
    graph = read_as_nav2_route(answer.json())
    assert len(graph) == len(topology(page)["nodes"])
    assert len(collection.features) == len(graph) + 2 * len(topology(page)["edges"])
    route = page.get("topology/route?from=0&to=1")
    assert route is not None
    assert nx.dijkstra_path_length(graph, 0, 1, "cost") == pytest.approx(route["cost"])


def test_a_node_that_is_reached_is_told(page: Page, port: int) -> None:
    node = corridor_nodes(page)[0]
    page.command("wander", enabled=False)
    page.command("stop")
    with events(port) as texts:
        page.command("kidnap", pose=before(node))
        page.command("set_pose", pose=before(node))
        page.localized(within=30.0)
        page.command("forward", distance=ALONG_M)
        eventually(lambda: any(f"At {node['name']}:" in text for text in texts), 30.0, "the node")
    arrived = next(text for text in texts if f"At {node['name']}:" in text)
    seen = int(arrived.split(": ")[1].split(" ")[0])
    figure(arrived)
    assert seen >= 2


def test_a_collision_is_made_good(page: Page, port: int) -> None:
    """Whoever does it, the localizer or the node: half a metre and 20 degrees, in a corridor."""
    node = corridor_nodes(page)[1]
    page.command("set_method", method="ekf")
    pose = before(node)
    wrong = pose | {"x": pose["x"] + 0.3, "y": pose["y"] + 0.4, "theta": pose["theta"] + 0.35}
    wrong["theta"] = math.remainder(wrong["theta"], math.tau)
    with events(port) as texts:
        page.command("kidnap", pose=pose)
        page.command("set_pose", pose=wrong, covariance=np.diag([0.01, 0.01, 0.003]).tolist())
        page.command("forward", distance=ALONG_M)
        page.localized(within=30.0)
    figure("; ".join(texts))
    page.command("set_method", method="markov")


def test_a_saved_map_outlives_the_service(page: Page, port: int, folder: Path) -> None:
    saved = page.command("topology_save", name="office", floor="ground floor")
    assert (folder / "state").exists()
    assert Path(saved["path"]).is_file()
    listed = httpx.get(f"http://127.0.0.1:{port}/api/v1/topologies", timeout=10.0).json()
    assert [one["name"] for one in listed["topologies"]] == ["office"]
    one = page.process("topology")
    began = time.monotonic()
    os.kill(one["pid"], signal.SIGKILL)
    eventually(lambda: page.is_back("topology", one["restarts"]), 60.0, "the topology service")
    eventually(lambda: page.get("topology/nearest?x=20&y=7"), 30.0, "an answer")
    figure(f"topology killed: answers {time.monotonic() - began:.1f} s later")
    assert (topology(page)["name"], topology(page)["floor"]) == ("office", "ground floor")
