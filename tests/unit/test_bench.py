"""What the benchmark measures, and what it says."""

from typing import Literal

import numpy as np
import pytest

from pilotage.bench import (
    building_cases,
    ekf_cases,
    grid_cases,
    line_cases,
    mapping_cases,
    particle_cases,
    planner_cases,
)
from pilotage.bench.buildings import office_block
from pilotage.bench.entry import Entry, Size, Stopwatch
from pilotage.bench.suite import ENTRIES, run_suite
from pilotage.bench.walk import BEAMS, LASER_BEAMS, STEP, corridor_walk, increments
from pilotage.core import se2
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.localizer.ekf_sight import seen_walls, walls_of_map
from pilotage.localizer.line_ekf import GaussianPose, LineEkfParams, track
from pilotage.localizer.measurement import Beams
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid
from pilotage.robot.simulator.floor_plans import office_floor


class Ticking:
    """A clock that a piece of work turns by hand."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def __call__(self) -> float:
        return self.seconds


def test_a_call_takes_what_the_clock_says() -> None:
    clock = Ticking()

    def work() -> None:
        clock.seconds += 0.25

    assert Stopwatch(clock).ms(work) == 250.0


def test_the_first_call_and_the_preparation_do_not_count() -> None:
    clock, costs = Ticking(), iter([9.0, 0.001, 0.003, 0.002])

    def work() -> None:
        clock.seconds += next(costs)

    def prepare() -> None:
        clock.seconds += 100.0

    assert Stopwatch(clock).median_ms(work, 3, prepare) == pytest.approx(2.0)


@pytest.mark.parametrize("kind", ["states", "particles", "cells", "lines"])
def test_an_entry_has_the_keys_that_others_rely_on(
    kind: Literal["states", "particles", "cells", "lines"],
) -> None:
    size = Size(7, 60, kind)
    entry = Entry("a case", size, 1.0, 20.0, 0.5, {"memory_mb": 3.0})
    assert entry.as_json() == {
        "name": "a case",
        kind: 7,
        "beams": 60,
        "cpu_ms": 1.0,
        "reference_cpu_ms": 20.0,
        "reference_fraction": 0.5,
        "memory_mb": 3.0,
    }


@pytest.mark.parametrize("side", [10.0, 17.3, 31.6])
def test_a_building_is_as_large_as_asked_and_furnished(side: float) -> None:
    world = office_block(side)
    states = pose_grid(world, PoseGridParams())
    assert states.geometry.size_m == pytest.approx((side, side))
    assert 0.85 < states.admissible.mask.mean() < 1.0


def test_the_largest_building_has_72_million_poses() -> None:
    states = pose_grid(office_block(100.0), PoseGridParams())
    assert np.prod(states.shape) == 72_000_000


def test_the_corridor_of_a_building_is_free() -> None:
    world = office_block(20.0)
    walk = corridor_walk(world, (1.5, 18.5, 5.0), 150)
    cells = world.geometry.cells_of(np.array([sight.pose[:2] for sight in walk]))
    assert world.is_free[tuple(cells.T)].all()


def test_the_corridor_of_the_office_is_free() -> None:
    world = office_floor()
    x_from, x_to, y = building_cases.OFFICE_CORRIDOR
    points = np.column_stack([np.arange(x_from, x_to, 0.1), np.full(565, y)])
    assert world.is_free[tuple(world.geometry.cells_of(points).T)].all()


def test_a_walk_turns_back_at_the_end_of_the_corridor() -> None:
    walk = corridor_walk(office_block(10.0), (2.0, 4.0, 5.0), 14)
    x = np.array([sight.pose[0] for sight in walk])
    assert x.min() >= 2.0
    assert x.max() <= 4.0
    assert np.abs(np.diff(x)).max() == pytest.approx(STEP)
    assert x[-1] < 3.0


def test_scans_of_a_walk_fit_the_walls() -> None:
    world = office_block(10.0)
    distance = distance_to_walls(world.is_wall, world.geometry.resolution)
    for sight in corridor_walk(world, (2.0, 8.0, 5.0), 5):
        assert sight.scan.ends is not None
        assert sight.scan.all_ends is not None
        assert len(sight.scan.ends) == BEAMS
        assert len(sight.scan.all_ends) <= LASER_BEAMS
        ends = se2.transform_points(sight.pose, sight.scan.all_ends)
        assert np.mean(distance[tuple(world.geometry.cells_of(ends).T)] < 0.11) > 0.95


def test_increments_lead_along_the_walk() -> None:
    walk = corridor_walk(office_block(10.0), (2.0, 8.0, 5.0), 6)
    pose = walk[0].pose
    for increment in increments(walk):
        pose = se2.compose(pose, increment)
    assert pose == pytest.approx(walk[-1].pose)


def test_the_suite_measures_everything_and_says_how_much_there_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On small places and with a clock that stands: what matters is that all of it runs."""
    monkeypatch.setattr(grid_cases, "CIRCLE", 3)
    monkeypatch.setattr(building_cases, "AREAS", (36.0, 49.0, 64.0, 81.0, 100.0))
    monkeypatch.setattr(mapping_cases, "REDRAWN", 5)
    monkeypatch.setattr(mapping_cases, "SCANS", 4)
    monkeypatch.setattr(line_cases, "SCANS", 2)
    monkeypatch.setattr(ekf_cases, "CYCLES", 2)
    in_office = building_cases, particle_cases, mapping_cases, planner_cases, line_cases, ekf_cases
    for module in in_office:
        monkeypatch.setattr(module, "office_floor", small_office)
        monkeypatch.setattr(module, "OFFICE_CORRIDOR", (1.5, 7.0, 5.0))
    monkeypatch.setattr(building_cases, "CORRIDOR_MIDDLE", 3.0)
    monkeypatch.setattr(building_cases, "TRACKED", 3)
    monkeypatch.setattr(particle_cases, "COUNTS", (200, 300))
    monkeypatch.setattr(particle_cases, "UPDATES", 2)
    monkeypatch.setattr(planner_cases, "SAMPLES", 50)
    monkeypatch.setattr("pilotage.bench.suite.exact_posterior_case", small_posterior)
    entries = [*run_suite(Stopwatch(Ticking()), lambda: 0.0)]
    assert len(entries) == ENTRIES
    assert len({entry.name + str(entry.size.count) for entry in entries}) == ENTRIES
    by_name = {entry.name: entry for entry in entries}
    assert by_name["square hall: predict and update by 4 ranges and a compass"].size == Size(
        1_620_000, 4
    )
    assert {entry.size.beams for entry in entries} == {0, 4, 36, 60, 361}
    tracking = [entry for entry in entries if entry.name.endswith("while tracking")]
    assert len(tracking) == len(building_cases.AREAS) + 1
    assert tracking[-1].extra["localized_share"] == 1.0


def small_office() -> OccupancyMap:
    return office_block(9.0)


def small_posterior(watch: Stopwatch) -> object:
    return grid_cases.exact_posterior_case(watch, side=10.0)


def test_the_plain_filter_of_lines_corrects_a_pose_as_the_product_does() -> None:
    world, params = small_office(), LineEkfParams()
    known = walls_of_map(world)
    rng, bearings = np.random.default_rng(1), np.linspace(-np.pi / 2.0, np.pi / 2.0, 361)
    for pose in ([3.0, 5.0, 0.1], [6.0, 5.0, 2.0]):
        ranges = cast_scan(world, pose, bearings, 12.0) + 0.01 * rng.standard_normal(361)
        belief = GaussianPose(np.array(pose) + np.array([0.03, -0.04, 0.01]), ekf_cases.SURE)
        beams = Beams(bearings, ranges, np.zeros(3), 12.0)
        plain = ekf_cases.plain_cycle(belief, beams, known, params)
        step = track(belief, np.zeros(3), seen_walls(beams), known, params)
        assert len(step.pairs.lines) >= 2
        assert plain.mean == pytest.approx(step.belief.mean, abs=0.01)
        assert np.hypot(*(plain.mean - pose)[:2]) < 0.04
