"""What the gateway answers to those who ask."""

import io
from collections.abc import Iterator
from pathlib import Path

import jsonschema_rs
import numpy as np
import pytest
from PIL import Image

from gateway_world import (
    ROBOT,
    GatewayWorld,
    belief,
    deployment,
    description,
    grid,
    odometry,
    planning_status,
    pose_estimate,
    process,
    scan,
    status,
)
from pilotage.gateway.routes import page
from pilotage.gateway.routes.robots import HEALTH_SCHEMA, SUMMARY_SCHEMA, TRAJECTORY_SCHEMA
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.health import Health
from pilotage_schemas.planning import ActivePlan, Candidate, PotentialField
from pilotage_schemas.planning import Path as PathMessage
from pilotage_schemas.topics import TOPICS


@pytest.fixture
def world() -> Iterator[GatewayWorld]:
    with GatewayWorld() as world:
        yield world


def test_a_living_gateway_is_healthy(world: GatewayWorld) -> None:
    assert world.client.get("/healthz").json() == {"status": "ok"}


def test_it_is_ready_once_map_and_pose_have_come(world: GatewayWorld) -> None:
    answer = world.client.get("/readyz")
    assert answer.status_code == 503
    assert answer.json()["detail"] == "waiting for map and pose"
    world.publish("mapper", "map", grid("#."))
    assert world.client.get("/readyz").json()["detail"] == "waiting for pose"
    world.publish("localizer", "pose", pose_estimate(world.now_ns))
    assert world.client.get("/readyz").json() == {"status": "ok"}


def test_the_page_is_served_fresh(
    world: GatewayWorld, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "WEB", tmp_path)
    assert world.client.get("/").status_code == 404
    (tmp_path / "index.html").write_text("<p>here</p>", encoding="utf-8")
    answer = world.client.get("/")
    assert answer.text == "<p>here</p>"
    assert answer.headers["cache-control"] == "no-cache"


def test_an_unknown_address_is_a_problem(world: GatewayWorld) -> None:
    answer = world.client.get("/api/v2")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json() == {
        "type": "urn:pilotage:problem:not-found",
        "title": "Not Found",
        "status": 404,
        "detail": "Not Found",
        "instance": "/api/v2",
    }


def test_a_wrong_method_is_a_problem_that_names_the_right_one(world: GatewayWorld) -> None:
    answer = world.client.put(f"{ROBOT}/pose")
    assert answer.status_code == 405
    assert answer.headers["allow"] == "GET"
    assert answer.json()["type"] == "urn:pilotage:problem:method-not-allowed"


def test_a_fault_of_the_gateway_is_a_problem_without_its_insides(
    world: GatewayWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(world.service, "state", None)
    answer = world.client.get(f"{ROBOT}/pose")
    assert answer.status_code == 500
    assert answer.json()["detail"] == "the gateway failed; its log says why"


def test_robots_are_listed_before_anything_has_come(world: GatewayWorld) -> None:
    (robot,) = world.client.get("/api/v1/robots").json()
    jsonschema_rs.validator_for(SUMMARY_SCHEMA).validate(robot)
    assert robot["id"] == "demo"
    assert robot["state"] is None


def test_a_robot_says_what_it_is_does_and_can(world: GatewayWorld) -> None:
    world.publish("robot", "description", description(world.now_ns))
    world.publish("robot", "status", status(world.now_ns))
    world.publish("localizer", "pose", pose_estimate(world.now_ns))
    assert world.client.get(ROBOT).json() == {
        "id": "demo",
        "connected": True,
        "name": "simulator",
        "source": "simulation",
        "mode": "wandering",
        "state": "localized",
        "commands": ["forward", "stop", "kidnap"],
    }


@pytest.mark.parametrize("path", ["", "/pose", "/map", "/map.png", "/sensors/scan", "/events"])
def test_there_is_no_other_robot(world: GatewayWorld, path: str) -> None:
    answer = world.client.get(f"/api/v1/robots/r2d2{path}")
    assert answer.status_code == 404
    assert "demo" in answer.json()["detail"]


@pytest.mark.parametrize(
    ("path", "owner"),
    [
        ("pose", "localizer"),
        ("belief", "localizer"),
        ("map", "mapper"),
        ("map.png", "mapper"),
        ("deployment", "launcher"),
        ("sensors/scan", "robot"),
        ("planning", "planner"),
        ("plan", "planner"),
        ("path", "planner"),
        ("potential", "planner"),
    ],
)
def test_what_has_not_come_is_not_found_and_whose_it_is(
    world: GatewayWorld, path: str, owner: str
) -> None:
    answer = world.client.get(f"{ROBOT}/{path}")
    assert answer.status_code == 404
    assert f"{owner} should send it" in answer.json()["detail"]


def test_the_pose_comes_with_its_age(world: GatewayWorld) -> None:
    stamp_ns = world.now_ns
    world.publish("localizer", "pose", pose_estimate(stamp_ns))
    world.clock.advance(1.5)
    pose = world.client.get(f"{ROBOT}/pose").json()
    assert pose["pose"] == {"x": 1.0, "y": 2.0, "theta": 0.5}
    assert pose["state"] == "localized"
    assert pose["received_ns"] == stamp_ns
    assert pose["age_ms"] == pytest.approx(1500.0)


def test_the_belief_lists_the_places(world: GatewayWorld) -> None:
    world.publish("localizer", "belief", belief(world.now_ns))
    answer = world.client.get(f"{ROBOT}/belief").json()
    assert answer["modes"][0]["mass"] == 0.8
    assert answer["samples"] == [[1.0, 2.0, 0.5, 0.8], [4.0, 2.0, 0.5, 0.2]]


def test_what_the_planner_is_about_comes_with_its_reason(world: GatewayWorld) -> None:
    pose = {"x": 3.0, "y": 2.0, "theta": 0.0}
    going = planning_status(world.now_ns, mode="going", reason="going", goal=Pose2(**pose))
    world.publish("planner", "planning_status", going)
    answer = world.client.get(f"{ROBOT}/planning").json()
    assert (answer["mode"], answer["goal"], answer["distance_left"]) == ("going", pose, None)


def test_the_next_look_comes_with_what_speaks_for_it(world: GatewayWorld) -> None:
    here = Pose2(x=1.0, y=2.0, theta=0.0)
    look = Candidate(pose=here, expected_gain=1.3, travel=4.0, kind="potential")
    plan = ActivePlan(
        stamp_ns=world.now_ns, frame_id="map", candidates=(look,), reason="Would tell 1 from 2"
    )
    world.publish("planner", "plan", plan)
    answer = world.client.get(f"{ROBOT}/plan").json()
    assert answer["candidates"][0]["expected_gain"] == 1.3
    assert answer["reason"] == "Would tell 1 from 2"


def test_the_way_and_the_potential_are_nested_lists(world: GatewayWorld) -> None:
    stamp = {"stamp_ns": world.now_ns, "frame_id": "map"}
    path = PathMessage.model_validate(stamp | {"poses": np.zeros((2, 3), np.float32)})
    world.publish("planner", "path", path)
    assert world.client.get(f"{ROBOT}/path").json()["poses"] == [[0.0, 0.0, 0.0]] * 2
    here = Pose2(x=0.0, y=0.0, theta=0.0)
    field = PotentialField(
        stamp_ns=world.now_ns,
        frame_id="map",
        resolution=0.5,
        origin=here,
        potential=np.ones((1, 2), np.float32),
    )
    world.publish("planner", "potential", field)
    assert world.client.get(f"{ROBOT}/potential").json()["potential"] == [[1.0, 1.0]]


def test_a_scan_without_return_has_null(world: GatewayWorld) -> None:
    world.publish("robot", "scan", scan(world.now_ns, 1.25, np.inf))
    assert world.client.get(f"{ROBOT}/sensors/scan").json()["ranges"] == [1.25, None]


@pytest.mark.parametrize(
    "topic", [topic.name for topic in TOPICS.values() if topic.owner == "robot"]
)
def test_every_topic_of_the_robot_has_an_address(world: GatewayWorld, topic: str) -> None:
    answer = world.client.get(f"{ROBOT}/sensors/{topic}")
    assert answer.json()["detail"] == f"no {topic} has come yet; robot should send it"


def test_an_unknown_sensor_names_the_known_ones(world: GatewayWorld) -> None:
    assert "odometry, scan" in world.client.get(f"{ROBOT}/sensors/nose").json()["detail"]


def test_the_trajectory_has_poses_and_breaks(world: GatewayWorld) -> None:
    for x in (1.0, 1.1, 5.0):
        world.publish("localizer", "pose", pose_estimate(world.now_ns, x))
        world.clock.advance(0.1)
    answer = world.client.get(f"{ROBOT}/trajectory").json()
    jsonschema_rs.validator_for(TRAJECTORY_SCHEMA).validate(answer)
    assert [pose[1] for pose in answer["poses"]] == [1.0, 1.1, 5.0]
    assert answer["breaks"] == [2]


def test_the_deployment_lists_its_processes(world: GatewayWorld) -> None:
    world.publish("launcher", "deployment", deployment(world.now_ns, process("robot", "ready")))
    (robot,) = world.client.get(f"{ROBOT}/deployment").json()["processes"]
    assert (robot["name"], robot["state"], robot["pid"]) == ("robot", "ready", 4711)


def test_health_has_every_service_and_the_latency(world: GatewayWorld) -> None:
    world.publish("robot", "odometry", odometry(world.now_ns - 4_000_000))
    world.publish("robot", "health", world.other("robot").vitals.report())
    answer = world.client.get(f"{ROBOT}/health").json()
    jsonschema_rs.validator_for(HEALTH_SCHEMA).validate(answer)
    assert answer["services"]["robot"]["service"] == "robot"
    assert answer["latency"]["odometry"]["p50_ms"] == pytest.approx(4.0)


def test_the_metrics_say_whether_the_planner_drives_and_how_long_it_thinks(
    world: GatewayWorld,
) -> None:
    assert "planner_drives" not in world.client.get("/metrics").text
    status = planning_status(world.now_ns, mode="localizing", decision_ms=120.0)
    world.publish("planner", "planning_status", status)
    text = world.client.get("/metrics").text
    assert "pilotage_planner_drives 1" in text
    assert "pilotage_planner_decision_seconds 0.12" in text


def test_a_map_has_facts_and_files(world: GatewayWorld) -> None:
    world.publish("mapper", "map", grid("#?.\n#.."))
    assert world.client.get(f"{ROBOT}/map").json() == {
        "map_id": "abc",
        "name": "drawn",
        "resolution": 0.5,
        "origin": {"x": -1.0, "y": -2.0, "theta": 0.0},
        "rows": 2,
        "cols": 3,
        "stamp_ns": 1,
    }
    picture = world.client.get(f"{ROBOT}/map.png")
    assert picture.headers["content-type"] == "image/png"
    with Image.open(io.BytesIO(picture.content)) as image:
        assert np.asarray(image).tolist() == [[0, 205, 254], [0, 254, 254]]
    assert world.client.get(f"{ROBOT}/map.pgm").content.startswith(b"P5\n3 2\n255\n")
    assert "image: map.pgm" in world.client.get(f"{ROBOT}/map.yaml").text


@pytest.mark.parametrize("file", ["map.png", "map.pgm", "map.yaml"])
def test_a_map_that_the_caller_has_is_not_sent_again(world: GatewayWorld, file: str) -> None:
    world.publish("mapper", "map", grid("#."))
    tag = world.client.get(f"{ROBOT}/{file}").headers["etag"]
    for has in (tag, f"W/{tag}", f'"other", {tag}', "*"):
        answer = world.client.get(f"{ROBOT}/{file}", headers={"if-none-match": has})
        assert answer.status_code == 304
        assert answer.content == b""
        assert answer.headers["etag"] == tag
    world.publish("mapper", "map", grid(".#", map_id="other"))
    answer = world.client.get(f"{ROBOT}/{file}", headers={"if-none-match": tag})
    assert answer.status_code == 200
    assert answer.headers["etag"] != tag


def test_a_map_name_cannot_break_a_header(world: GatewayWorld) -> None:
    world.publish("mapper", "map", grid("#.", map_id='x"\r\nset-cookie: a=b\u2028é'))
    answer = world.client.get(f"{ROBOT}/map.png")
    assert answer.status_code == 200
    assert "set-cookie" not in answer.headers


def test_metrics_count_every_service_and_topic(world: GatewayWorld) -> None:
    world.publish("robot", "odometry", odometry(world.now_ns - 4_000_000))
    world.publish("robot", "health", world.other("robot").vitals.report())
    crashed = process("localizer", "down", restarts=3)
    world.publish("launcher", "deployment", deployment(world.now_ns, crashed))
    answer = world.client.get("/metrics")
    assert answer.headers["content-type"] == "text/plain; version=0.0.4; charset=utf-8"
    lines = answer.text.splitlines()
    assert "pilotage_up 1" in lines
    assert "pilotage_link_up 1" in lines
    odometry_out = '{service="robot",topic="odometry",direction="out"}'
    assert f"pilotage_messages_total{odometry_out} 1" in lines
    assert 'pilotage_service_dropped_total{service="robot"} 0' in lines
    assert 'pilotage_process_restarts_total{service="localizer"} 3' in lines
    assert 'pilotage_process_up{service="localizer"} 0' in lines
    assert 'pilotage_latency_seconds{topic="odometry",quantile="0.99"} 0.004' in lines


def test_each_metric_is_described_once_before_its_samples(world: GatewayWorld) -> None:
    described: set[str] = set()
    for line in world.client.get("/metrics").text.splitlines():
        if line.startswith("# TYPE"):
            name = line.split()[2]
            assert name not in described
            described.add(name)
        elif not line.startswith("#"):
            assert line.split("{")[0].split()[0] in described


def test_names_from_the_bus_cannot_forge_metrics(world: GatewayWorld) -> None:
    forged = Health.model_validate(
        world.other("robot").vitals.report().model_dump() | {"topics": ()}
    )
    named = process('a"} 1\nforged_metric{x="\\', "ready")
    world.publish("robot", "health", forged)
    world.publish("launcher", "deployment", deployment(world.now_ns, named))
    lines = world.client.get("/metrics").text.splitlines()
    assert not any(line.startswith("forged") for line in lines)
    assert 'pilotage_process_up{service="a\\"} 1\\nforged_metric{x=\\"\\\\"} 1' in lines
