"""The mapper makes a map: commands in, a map that grows out, and the pose while it lasts."""

import math
from pathlib import Path

import numpy as np
import pytest

from dead_reckoning_mapping import DeadReckoningMapping
from drawing import draw
from localizer_world import ROUND, START
from mapper_bench import STAND, MapperBench, described, half_mapped, pieced_together, stopped
from pilotage.bus.fabric import RefusedError
from pilotage.core import se2
from pilotage.core.grid import OCCUPIED_FROM
from pilotage.core.logs import Record
from pilotage.core.map_files import save_map
from pilotage.mapper.config import MapperSettings
from pilotage.mapper.live_map import BLOCK, LiveMap, in_blocks
from pilotage.mapper.map_choice import HANDOVER_S
from pilotage.mapper.messages import nearness, path_message, pose_of
from pilotage.mapper.method import MappingStep
from pilotage_schemas.commands import (
    MapLoad,
    MapSave,
    MapStart,
    Nothing,
)
from pilotage_schemas.mapping import GridPatch, OccupancyGrid
from pilotage_schemas.topics import PATCHES_KEPT
from sample_messages import scan as stray_scan


@pytest.fixture
def bench(tmp_path: Path) -> MapperBench:
    return described(tmp_path)


@pytest.fixture
def mapping(tmp_path: Path) -> MapperBench:
    return half_mapped(tmp_path)


class TestMapping:
    def test_is_announced_before_anything_is_mapped(self, bench: MapperBench) -> None:
        assert bench.status.mode == "idle"
        bench.ask("map_start", MapStart())
        assert (bench.status.mode, bench.status.sensor) == ("mapping", "laser")
        assert bench.status.since_ns == bench.clock.now_ns()
        assert bench.heard["pose"] == []

    def test_shows_a_map_in_the_making_of_what_was_seen(self, mapping: MapperBench) -> None:
        first: OccupancyGrid = mapping.heard["map"][0]
        assert first.in_progress
        assert first.map_id.startswith("growing-")
        cells = pieced_together(mapping.heard["map"], mapping.heard["map_patch"])
        assert (cells >= OCCUPIED_FROM).sum() > 50
        assert (cells == 0).sum() > 5000

    def test_says_cells_that_change_as_patches_of_the_map(self, mapping: MapperBench) -> None:
        patches: list[GridPatch] = mapping.heard["map_patch"]
        assert {patch.map_id for patch in patches} <= {g.map_id for g in mapping.heard["map"]}
        whole = sum(grid.cells.size for grid in mapping.heard["map"])
        assert 0 < sum(patch.cells.size for patch in patches) < whole

    def test_says_the_map_at_most_twice_a_second(self, mapping: MapperBench) -> None:
        stamps = {patch.stamp_ns for patch in mapping.heard["map_patch"]}
        assert np.diff(sorted(stamps)).min() >= 490_000_000

    def test_says_the_pose_on_the_map_that_begins_where_the_robot_stood(
        self, mapping: MapperBench
    ) -> None:
        said = mapping.heard["pose"][-1]
        true = se2.between(START, mapping.truth)
        assert said.state == "localized"
        assert (said.pose.x, said.pose.y) == pytest.approx((true[0], true[1]), abs=0.05)
        assert said.covariance[0, 0] >= 0.01
        gaps = np.diff([pose.stamp_ns for pose in mapping.heard["pose"]])
        assert gaps.max() <= 110_000_000

    def test_shows_the_way_so_far(self, mapping: MapperBench) -> None:
        path = mapping.heard["mapped_path"][-1]
        assert path.map_id == mapping.status.map_id
        assert len(path.poses) > 3

    def test_cannot_begin_twice(self, mapping: MapperBench) -> None:
        for request in (MapStart(), MapStart(go_on=True)):
            with pytest.raises(RefusedError, match="a map is being made: stop that first"):
                mapping.ask("map_start", request)

    def test_keeps_other_maps_out(self, mapping: MapperBench, tmp_path: Path) -> None:
        save_map(draw("...\n...", 0.1), tmp_path / "other.yaml")
        with pytest.raises(RefusedError, match="a map is being made"):
            mapping.ask("map_load", MapLoad(map=str(tmp_path / "other.yaml")))
        assert mapping.status.mode == "mapping"

    def test_can_begin_anew(self, mapping: MapperBench) -> None:
        before = mapping.status.since_ns
        mapping.ask("map_reset", Nothing())
        assert mapping.status.steps == 0
        assert mapping.status.since_ns > before
        mapping.go(STAND, STAND, STAND)
        assert mapping.heard["pose"][-1].pose.x == pytest.approx(0.0, abs=1e-6)

    def test_can_begin_by_the_settings(self, tmp_path: Path) -> None:
        bench = MapperBench(tmp_path, MapperSettings(mapping="laser"))
        assert bench.status.mode == "mapping"

    def test_hears_only_the_sensor_that_was_asked_for(self, bench: MapperBench) -> None:
        bench.ask("map_start", MapStart(sensor="sonar"))
        bench.go(STAND, STAND)
        assert bench.heard["map"] == []

    def test_does_not_place_a_laser_whose_mount_nobody_said(self, tmp_path: Path) -> None:
        bench = MapperBench(tmp_path, MapperSettings(mapping="laser"))
        bench.go(STAND, STAND)
        assert bench.heard["map"] == []
        bench.describe()
        bench.put("scan", bench.scan(frame_id="elsewhere"))
        assert "no mount 'elsewhere'" in bench.node.vitals.last_error
        bench.go(STAND, STAND)
        assert len(bench.heard["map"]) > 0

    def test_drops_and_counts_a_scan_that_comes_too_late(self, mapping: MapperBench) -> None:
        late = stray_scan(mapping.clock.now_ns() - 2_000_000_000)
        mapping.put("scan", late)
        assert "measured no later" in mapping.node.vitals.last_error

    def test_goes_on_when_odometry_is_counted_anew(self, mapping: MapperBench) -> None:
        before = mapping.heard["pose"][-1].pose
        mapping.odom = np.array([0.0, 0.0, 0.0])
        mapping.robot = type(mapping.robot)("robot", "demo", mapping.fabric, mapping.clock)
        mapping.go(STAND)
        after = mapping.heard["pose"][-1].pose
        assert math.hypot(after.x - before.x, after.y - before.y) < 0.05
        assert "counting anew" in mapping.node.vitals.last_error

    def test_announces_long_work_once_it_knows_of_some(self, tmp_path: Path) -> None:
        slow = MapperBench(tmp_path)

        class Slow(DeadReckoningMapping):
            def process(self, record: Record) -> MappingStep | None:
                slow.clock.advance(0.4)
                return super().process(record)

        slow.make = lambda _sensor: Slow()
        slow.service._at._make = slow.make
        slow.describe()
        slow.ask("map_start", MapStart())
        slow.go(STAND, STAND)
        assert slow.service._slowest_s >= 0.4


def test_a_loop_that_is_closed_lets_the_status_say_so(tmp_path: Path) -> None:
    bench = MapperBench(tmp_path, make=lambda _sensor: DeadReckoningMapping(redraws_at=(3,)))
    bench.describe()
    bench.ask("map_start", MapStart())
    bench.go(*[STAND] * 12)
    assert bench.status.redraws == 1


class TestWhoComesLate:
    def test_has_the_same_map_from_the_last_whole_one_and_its_patches(
        self, mapping: MapperBench
    ) -> None:
        grids = mapping.listen("map", OccupancyGrid)
        patches = mapping.listen("map_patch", GridPatch, history=PATCHES_KEPT)
        assert len(grids) == 1
        late = pieced_together(grids, patches)
        early = pieced_together(mapping.heard["map"], mapping.heard["map_patch"])
        assert np.array_equal(late, early)

    def test_never_misses_a_patch_because_there_were_too_many(self) -> None:
        live, rng = LiveMap(most_patches=10), np.random.default_rng(1)
        world = draw("\n".join(["." * 128] * 128), 0.05)
        assert live.news(world) is None
        since = 0
        for _ in range(40):
            cells = world.cells.copy()
            cells[rng.integers(0, 128, 3), rng.integers(0, 128, 3)] = 100
            world = type(world)(world.geometry, cells)
            patches = live.news(world)
            since = 0 if patches is None else since + len(patches)
            assert since <= 10


class TestBlocks:
    def test_surround_a_map_with_unknown_cells_in_its_place(self) -> None:
        world = draw("#.\n.#", 0.05, (-0.05, 1.0, 0.0))
        wide = in_blocks(world)
        assert wide.cells.shape == (BLOCK, 2 * BLOCK)
        found = np.argwhere(wide.cells >= OCCUPIED_FROM)
        centres = wide.geometry.centres_of(found)
        expected = world.geometry.centres_of(np.argwhere(world.cells >= OCCUPIED_FROM))
        assert np.allclose(np.sort(centres, axis=0), np.sort(expected, axis=0))

    def test_stay_when_the_map_grows_within_them(self) -> None:
        small, large = draw("..\n..", 0.05), draw("....\n....", 0.05, (-0.0, 0.0, 0.0))
        assert in_blocks(small).geometry == in_blocks(large).geometry


class TestStopping:
    def test_serves_the_finished_map(self, mapping: MapperBench) -> None:
        reply = stopped(mapping)
        grid: OccupancyGrid = mapping.heard["map"][-1]
        assert (grid.map_id, grid.in_progress) == (reply.map_id, False)
        assert set(np.unique(grid.cells)) <= {-1, 0, 100}

    def test_hands_the_pose_over_when_the_localizer_is_ready(self, mapping: MapperBench) -> None:
        mapping.localizer.ready()
        reply = stopped(mapping)
        status = mapping.status
        assert status.mode == "handing_over"
        assert status.handover is not None
        assert status.handover.map_id == reply.map_id
        assert status.handover.odom_from_base == pose_of(mapping.odom)
        said = len(mapping.heard["pose"])
        mapping.go((0.2, 0.0, 0.0), scans=False)
        assert len(mapping.heard["pose"]) > said
        mapping.believe("another map")
        assert str(mapping.service._at.mode) == "handing_over"
        mapping.believe(reply.map_id)
        assert str(mapping.service._at.mode) == "idle"
        said = len(mapping.heard["pose"])
        mapping.go((0.2, 0.0, 0.0))
        assert len(mapping.heard["pose"]) == said

    def test_says_first_with_what_to_begin_and_then_the_map(self, mapping: MapperBench) -> None:
        mapping.localizer.ready()
        order: list[str] = []
        for topic in ("map", "mapping_status"):
            mapping.fabric.declare_subscriber(
                f"pilotage/@v1/demo/{topic}",
                "latest_wins",
                lambda _sample, topic=topic: order.append(topic),  # type: ignore[misc]  # bound now
            )
        stopped(mapping)
        assert order == ["mapping_status", "map"]

    def test_waits_for_no_localizer_where_there_is_none(self, mapping: MapperBench) -> None:
        stopped(mapping)
        assert mapping.status.mode == "idle"

    def test_waits_for_a_localizer_only_so_long(self, mapping: MapperBench) -> None:
        mapping.localizer.ready()
        stopped(mapping)
        with pytest.raises(RefusedError, match="about to take over"):
            mapping.ask("map_start", MapStart())
        mapping.clock.advance(HANDOVER_S + 2.0)
        mapping.step()
        assert mapping.status.mode == "idle"

    def test_needs_something_mapped(self, bench: MapperBench) -> None:
        for command in ("map_stop", "map_reset"):
            with pytest.raises(RefusedError, match="no map is being made"):
                bench.ask(command, Nothing())
        bench.ask("map_start", MapStart())
        with pytest.raises(RefusedError, match="nothing has been mapped yet"):
            bench.ask("map_stop", Nothing())
        assert bench.status.mode == "mapping"


class TestGoingOn:
    def localized(self, bench: MapperBench) -> np.ndarray:
        """Say as the localizer where the robot is, and return that."""
        pose = se2.between(START, bench.truth)
        said = bench.heard["pose"][-1].model_copy(
            update={"pose": pose_of(pose), "stamp_ns": bench.clock.now_ns()}
        )
        bench.put("pose", said, by=bench.localizer)
        return pose

    def test_begins_where_the_localizer_says_that_the_robot_is(self, mapping: MapperBench) -> None:
        stopped(mapping)
        steps = mapping.status.steps
        mapping.go(*ROUND[8:10], scans=False)
        mapping.odom = se2.compose(mapping.odom, [0.5, 0.0, 0.2])  # odometry has slipped
        mapping.go(STAND, scans=False)
        pose = self.localized(mapping)
        mapping.ask("map_start", MapStart(go_on=True))
        mapping.go(STAND, STAND)
        said = mapping.heard["pose"][-1].pose
        assert (said.x, said.y) == pytest.approx((pose[0], pose[1]), abs=0.02)
        assert mapping.status.steps > steps

    def test_is_refused_without_a_pose_or_a_map_of_its_own(
        self, mapping: MapperBench, tmp_path: Path
    ) -> None:
        stopped(mapping)
        with pytest.raises(RefusedError, match="does not know where it is"):
            mapping.ask("map_start", MapStart(go_on=True))
        with pytest.raises(RefusedError, match="made by laser, not by sonar"):
            mapping.ask("map_start", MapStart(go_on=True, sensor="sonar"))
        save_map(draw("...\n...", 0.1), tmp_path / "other.yaml")
        mapping.ask("map_load", MapLoad(map=str(tmp_path / "other.yaml")))
        with pytest.raises(RefusedError, match="was not made here"):
            mapping.ask("map_start", MapStart(go_on=True))

    def test_works_with_a_map_of_the_library(self, mapping: MapperBench) -> None:
        mapping.ask("map_save", MapSave(name="flat"))
        stopped(mapping)
        mapping.ask("map_load", MapLoad(map="flat"))
        steps = mapping.status.steps
        mapping.go(STAND, scans=False)
        self.localized(mapping)
        mapping.ask("map_start", MapStart(go_on=True))
        mapping.go(*[STAND] * 8)
        assert mapping.status.steps > steps


def test_the_probability_of_being_near_falls_with_the_covariance() -> None:
    sure = nearness(np.diag([0.0004, 0.0004, 0.0001]))
    doubtful = nearness(np.diag([0.25, 0.25, 0.1]))
    assert sure > 0.999
    assert 0.0 < doubtful < 0.4
    assert nearness(np.zeros((3, 3))) == pytest.approx(1.0)


def test_near_is_as_often_true_as_it_is_said() -> None:
    covariance = np.diag([0.09, 0.09, 0.02])
    drawn = np.random.default_rng(5).multivariate_normal(np.zeros(3), covariance, 40_000)
    is_near = (np.hypot(drawn[:, 0], drawn[:, 1]) < 0.5) & (np.abs(drawn[:, 2]) < math.radians(15))
    assert nearness(covariance) == pytest.approx(is_near.mean(), abs=0.01)


def test_a_long_way_is_shown_with_a_bounded_number_of_poses() -> None:
    way = np.zeros((200_000, 3))
    way[:, 0] = np.arange(200_000) * 0.02
    stamps = np.arange(200_000, dtype=float) / 10.0
    message = path_message("m", (stamps, way), 30_000_000_000_000)
    shown = message.poses
    assert len(shown) <= 5002
    np.testing.assert_allclose(message.ages, 30_000.0 - 5.0 * shown[:, 0], atol=0.01)
    assert shown[0, 0] == 0.0
    assert shown[-1, 0] == pytest.approx(way[-1, 0])
    assert path_message("m", (np.zeros(0), np.zeros((0, 3))), 1).poses.shape == (0, 3)
    assert len(path_message("m", (np.zeros(1), np.zeros((1, 3))), 1).poses) == 1
