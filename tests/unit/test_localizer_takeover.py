"""The localizer leaves the pose to the mapper, and takes it over on the finished map."""

import numpy as np
import pytest

from localizer_bench import Bench
from localizer_world import ELSEWHERE, ROUND, flat
from pilotage.bus.fabric import RefusedError
from pilotage.core import se2
from pilotage.core.map_files import map_digest
from pilotage.localizer.takeover import LEAST_SIGMAS, Takeover, memory_of
from pilotage.mapper.messages import grid_message, pose_of
from pilotage_schemas.commands import Nothing, SetMap, SetPose
from pilotage_schemas.mapping import Handover, MappingStatus

SHIFTED = flat((3.0, -2.0, 0.4))
"""The flat as a map in another frame: what a mapper that began elsewhere makes of it."""


def handover(bench: Bench, covariance: np.ndarray | None = None) -> Handover:
    """What the mapper says of the robot of the bench, on the map SHIFTED."""
    pose = se2.compose(SHIFTED.geometry.origin, bench.pose)
    return Handover(
        map_id=map_digest(SHIFTED),
        pose=pose_of(pose),
        covariance=np.diag([0.01, 0.01, 0.001]) if covariance is None else covariance,
        odom_from_base=pose_of(bench.odom),
        stamp_ns=bench.clock.now_ns(),
    )


def status(bench: Bench, mode: str, given: Handover | None = None) -> None:
    message = MappingStatus.model_validate(
        {
            "stamp_ns": bench.clock.now_ns(),
            "frame_id": "map",
            "mode": mode,
            "sensor": "laser",
            "handover": given,
        }
    )
    bench.put("mapping_status", message, by=bench.mapper)


def growing(bench: Bench) -> None:
    grid = grid_message(SHIFTED, "growing", bench.clock.now_ns(), growing_id="growing-1")
    bench.put("map", grid, by=bench.mapper)


@pytest.fixture
def bench() -> Bench:
    made = Bench()
    made.begin()
    made.drive_round()
    return made


def test_nothing_is_said_while_a_map_is_made(bench: Bench) -> None:
    status(bench, "mapping")
    poses, beliefs = len(bench.poses), len(bench.beliefs)
    growing(bench)
    for step in ROUND[:3]:
        bench.go(step)
    assert (len(bench.poses), len(bench.beliefs)) == (poses, beliefs)
    said = {line.topic: line.limit for line in bench.node.vitals.report().topics}
    assert said["pose"] is None
    assert said["belief"] is None


def test_nobody_localizes_on_a_map_in_the_making(bench: Bench) -> None:
    before = bench.service._at.map_id
    growing(bench)
    assert bench.service._at.map_id == before


def test_what_only_the_owner_of_the_pose_can_do_is_refused(bench: Bench) -> None:
    status(bench, "mapping")
    requests = {
        "set_pose": SetPose(pose=pose_of(np.zeros(3))),
        "relocalize": Nothing(),
        "set_map": SetMap(map="x"),
    }
    for query, request in requests.items():
        with pytest.raises(RefusedError, match="a map is being made"):
            bench.ask(query, request)


def test_the_finished_map_is_taken_over_where_the_mapper_left_off(bench: Bench) -> None:
    status(bench, "mapping")
    bench.go((0.2, 0.0, 0.0))
    status(bench, "handing_over", handover(bench))
    bench.put("map", grid_message(SHIFTED, "made", bench.clock.now_ns()), by=bench.mapper)
    poses = len(bench.poses)
    bench.go((0.1, 0.0, 0.1))
    assert len(bench.poses) == poses
    assert bench.beliefs[-1].map_id == map_digest(SHIFTED)
    status(bench, "idle", handover(bench))
    said = bench.latest()
    assert len(bench.poses) > poses
    assert said.state == "localized"
    true = se2.compose(SHIFTED.geometry.origin, bench.pose)
    assert (said.pose.x, said.pose.y) == pytest.approx((true[0], true[1]), abs=0.15)


def test_the_mapper_is_told_only_when_a_scan_has_been_weighed(bench: Bench) -> None:
    status(bench, "mapping")
    status(bench, "handing_over", handover(bench))
    beliefs = len(bench.beliefs)
    bench.put("map", grid_message(SHIFTED, "made", bench.clock.now_ns()), by=bench.mapper)
    assert len(bench.beliefs) == beliefs
    bench.go((0.1, 0.0, 0.0))
    assert len(bench.beliefs) > beliefs


def test_a_mapper_that_comes_back_without_a_map_leaves_the_old_one(bench: Bench) -> None:
    status(bench, "mapping")
    bench.go((0.2, 0.0, 0.0))
    status(bench, "idle")
    bench.go((0.2, 0.0, 0.0))
    assert bench.poses[-1].state == "localized"
    assert bench.is_right()


def test_a_map_of_which_nothing_was_said_begins_anywhere(bench: Bench) -> None:
    status(bench, "mapping")
    status(bench, "idle")
    bench.put("map", grid_message(SHIFTED, "other", bench.clock.now_ns()), by=bench.mapper)
    assert bench.beliefs[-1].map_id == map_digest(SHIFTED)
    assert bench.latest().state == "unknown"


def test_a_localizer_that_begins_during_mapping_says_nothing() -> None:
    bench = Bench()
    status(bench, "mapping")
    growing(bench)
    bench.describe()
    bench.clock.advance(0.1)
    bench.say_odometry()
    bench.put("scan", bench.scan())
    assert bench.poses == []
    assert bench.beliefs == []


def test_a_hand_over_is_used_once_and_only_for_its_map() -> None:
    takeover, bench = Takeover(), Bench()
    given = handover(bench)
    takeover.take(MappingStatus(stamp_ns=1, frame_id="map", mode="handing_over", handover=given))
    assert takeover.memory_on("another") is None
    assert takeover.memory_on(given.map_id) is not None
    assert takeover.memory_on(given.map_id) is None


def test_the_belief_handed_over_has_the_mapper_s_mean_and_covariance() -> None:
    covariance = np.array([[0.09, 0.03, 0.0], [0.03, 0.04, 0.01], [0.0, 0.01, 0.02]])
    bench = Bench(pose=np.array(ELSEWHERE))
    given = handover(bench, covariance)
    memory = memory_of(given)
    mean = memory.weights @ memory.poses
    assert mean[:2] == pytest.approx([given.pose.x, given.pose.y], abs=1e-9)
    off = memory.poses - np.array([given.pose.x, given.pose.y, given.pose.theta])
    off[:, 2] = np.angle(np.exp(1j * off[:, 2]))
    found = (off * memory.weights[:, None]).T @ off
    # Laid out to two standard deviations only, it is a little narrower.
    assert found == pytest.approx(0.8 * covariance, abs=0.012)
    assert memory.was_localized


def test_a_belief_handed_over_is_never_sharper_than_the_states() -> None:
    memory = memory_of(handover(Bench(), np.zeros((3, 3))))
    spread = np.sqrt(
        np.average((memory.poses - memory.poses.mean(axis=0)) ** 2, axis=0, weights=memory.weights)
    )
    assert np.all(spread > 0.8 * np.array(LEAST_SIGMAS))
