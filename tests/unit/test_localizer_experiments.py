"""The experiments of Wu & Bell 2003 on small halls: symmetry, compass, kidnapping."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest

from localizer_world import error
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.markov_localizer import MarkovLocalizer, MarkovParams
from pilotage.localizer.measurement import Measurement, Ranges, scan_measurement
from pilotage.localizer.modes import find_modes
from pilotage.localizer.pose_grid import PoseGridParams

CELL, BIN = 0.2, math.radians(5.0)
FOUR = np.array([0.0, math.pi / 2.0, -math.pi / 2.0, math.pi])
"""Rangers to the front, left, right and back."""

RANGE_MAX = 8.0
M2 = MarkovParams(
    algorithm="m2",
    recovery_weight=1.0,
    update_way=0.1,
    update_turn=BIN,
    grid=PoseGridParams(CELL, 72),
)
"""The paper's floor to the letter, P0 = 1 / |Omega|, and its actions: each is a measurement."""

M1 = replace(M2, algorithm="m1")


def hall(width: float, height: float, origin: tuple[float, float, float]) -> OccupancyMap:
    """A featureless rectangle within walls of one cell."""
    cells = np.full((round(height / CELL) + 2, round(width / CELL) + 2), 100, np.int8)
    cells[1:-1, 1:-1] = 0
    return OccupancyMap(GridGeometry(*cells.shape, CELL, origin), cells)


SQUARE = hall(6.0, 6.0, (-3.2, -3.2, 0.0))
CORRIDOR = hall(8.0, 1.8, (-4.2, -1.1, 0.0))
"""Both about the origin of the map frame."""


@dataclass
class Run:
    """A robot in a hall, its odometry exact, with four rangers and maybe a compass."""

    world: OccupancyMap
    localizer: MarkovLocalizer
    pose: np.ndarray
    has_compass: bool
    odom: np.ndarray
    seconds: int = 0

    def go(self, step: tuple[float, float, float]) -> Estimate:
        self.pose, self.odom = se2.compose(self.pose, step), se2.compose(self.odom, step)
        return self.measure()

    def measure(self) -> Estimate:
        self.seconds += 1
        ranges = Ranges(FOUR, cast_scan(self.world, self.pose, FOUR, RANGE_MAX), RANGE_MAX)
        compass = (float(self.pose[2]), 0.1) if self.has_compass else None
        measurement = Measurement(ranges=ranges, compass=compass)
        return self.localizer.update(self.seconds * 10**9, self.odom, measurement)


def begin(
    world: OccupancyMap, params: MarkovParams, start: np.ndarray, *, has_compass: bool
) -> Run:
    return Run(world, MarkovLocalizer(world, params), start, has_compass, np.zeros(3))


def wander(count: int, seed: int) -> Iterator[tuple[float, float, float]]:
    """The paper's actions: forward 0.10 m, turned by 5 degrees either way or not at all."""
    turns = np.random.default_rng(seed).choice([-BIN, 0.0, BIN], count)
    return ((0.1, 0.0, float(turn)) for turn in turns)


def turned(pose: np.ndarray, quarters: int) -> np.ndarray:
    """The pose that looks alike in a square hall about the origin."""
    return se2.compose([0.0, 0.0, quarters * math.pi / 2.0], pose)


@pytest.mark.parametrize("params", [M1, M2], ids=["m1", "m2"])
def test_a_square_hall_leaves_four_equal_poses_however_far_the_robot_goes(
    params: MarkovParams,
) -> None:
    run = begin(SQUARE, params, np.array([-1.17, -0.79, 0.5]), has_compass=False)
    for count, step in enumerate(wander(35, seed=4)):
        estimate = run.go(step)
        if count >= 9:
            assert [mode.mass for mode in estimate.modes] == pytest.approx([0.25] * 4, rel=0.05)
            for quarters in range(4):
                alike = turned(run.pose, quarters)
                assert min(error(mode.pose, alike)[0] for mode in estimate.modes) < 2.0 * CELL
            assert estimate.state == "ambiguous"


def test_the_belief_of_a_square_hall_is_four_fold_symmetric_all_the_way() -> None:
    run = begin(SQUARE, M2, np.array([-1.17, -0.79, 0.5]), has_compass=False)
    for step in wander(20, seed=5):
        run.go(step)
        masses = np.split(run.localizer.grid.belief.sum(axis=(1, 2), dtype=np.float64), 4)
        for quarter in masses[1:]:
            assert quarter == pytest.approx(masses[0], rel=0.05, abs=1e-3 * masses[0].sum())


@pytest.mark.parametrize("kind", ["scan", "ranges"])
def test_a_symmetric_world_gives_a_symmetric_belief(kind: str) -> None:
    """Half a turn about the middle takes the corridor, and so the belief, to itself."""
    localizer = MarkovLocalizer(CORRIDOR, M2)
    pose = np.array([-2.1, 0.13, 0.3])
    bearings = np.linspace(-1.7, 1.9, 41)
    ranges = cast_scan(CORRIDOR, pose, bearings, RANGE_MAX)
    seen = {
        "scan": scan_measurement(
            ranges.astype(np.float32), (-1.7, 3.6 / 40), np.zeros(3), 41, RANGE_MAX
        ),
        "ranges": Measurement(ranges=Ranges(bearings[::8], ranges[::8], RANGE_MAX)),
    }
    localizer.update(10**9, np.zeros(3), seen[kind])
    belief = localizer.grid.belief / localizer.grid.belief.max()
    turned_round = np.roll(belief, len(belief) // 2, axis=0)[:, ::-1, ::-1]
    heavy = np.maximum(belief, turned_round) > 1e-3
    assert belief[heavy] == pytest.approx(turned_round[heavy], rel=0.05)


def test_with_a_compass_one_pose_is_left_and_it_is_right() -> None:
    run = begin(SQUARE, M2, np.array([-1.17, -0.79, 0.5]), has_compass=True)
    for count, step in enumerate(wander(35, seed=4)):
        estimate = run.go(step)
        if count >= 4:
            assert len(estimate.modes) == 1
            assert estimate.state == "localized"
            away, turn = error(estimate.pose, run.pose)
            assert away <= math.hypot(CELL, CELL)
            assert turn <= BIN


def test_a_corridor_leaves_two_poses_and_the_compass_one() -> None:
    start = np.array([-2.1, 0.11, 0.05])
    plain = begin(CORRIDOR, M2, start, has_compass=False)
    compass = begin(CORRIDOR, M2, start, has_compass=True)
    for step in wander(20, seed=6):
        two, one = plain.go(step).modes, compass.go(step).modes
    assert two[0].mass == pytest.approx(two[1].mass, rel=0.05)
    assert two[0].mass + two[1].mass > 0.85
    assert error(two[0].pose, turned(two[1].pose, 2))[0] < CELL
    assert one[0].mass > 0.9
    assert error(one[0].pose, compass.pose)[0] < 2.0 * CELL


def kidnapped(params: MarkovParams) -> Run:
    """A robot that was sure of its place, carried to another without its odometry noticing."""
    run = begin(SQUARE, params, np.array([-1.5, -1.2, 0.6]), has_compass=True)
    run.localizer.start_at(run.pose, np.diag([0.01, 0.01, 0.01]))
    estimates = [run.go(step) for step in wander(6, seed=8)]
    assert estimates[-1].state == "localized"
    run.pose = np.array([1.3, 0.4, -2.2])
    return run


def is_far(estimate: Estimate, run: Run) -> bool:
    return all(error(mode.pose, run.pose)[0] > 0.5 for mode in estimate.modes)


def is_right(estimate: Estimate, run: Run) -> bool:
    away, turn = error(estimate.pose, run.pose)
    return away <= math.hypot(CELL, CELL) and turn <= BIN


def test_m1_never_recovers_from_a_kidnapping() -> None:
    run = kidnapped(M1)
    for _ in range(60):
        estimate = run.go((0.0, 0.0, BIN))
        assert is_far(estimate, run)


@pytest.mark.parametrize(("weight", "noticed_by"), [(1.0, 1), (1e-3, 2), (1e-6, 2)])
def test_m2_recovers_from_a_kidnapping_whatever_the_weight_of_its_floor(
    weight: float, noticed_by: int
) -> None:
    """Four rangers outweigh a smaller floor later: it is the price of a sharper belief."""
    run = kidnapped(replace(M2, recovery_weight=weight))
    estimates = [run.go((0.0, 0.0, BIN)) for _ in range(10)]
    assert estimates[noticed_by - 1].state != "localized"
    assert estimates[-1].state == "localized"
    assert is_right(estimates[-1], run)


def test_choosing_m2_later_ends_what_m1_cannot() -> None:
    run = kidnapped(M1)
    assert is_far([run.go((0.0, 0.0, BIN)) for _ in range(5)][-1], run)
    run.localizer.choose_algorithm("m2", 1.0)
    assert is_right([run.go((0.0, 0.0, BIN)) for _ in range(8)][-1], run)


def test_m2_needs_no_initial_belief_at_all() -> None:
    """The belief may start from zero (section 4): the floor is enough."""
    run = begin(SQUARE, M2, np.array([1.0, 0.5, 0.2]), has_compass=True)
    run.localizer.grid.belief[:] = 0.0
    run.localizer.grid.settle()
    assert is_right([run.go((0.0, 0.0, BIN)) for _ in range(6)][-1], run)


@pytest.mark.parametrize(
    ("theta", "within"),
    [(math.pi / 2.0, 0.05), (12 * BIN, 0.1), (0.4, 1.0), (-2.0, 1.0)],
    ids=["a quarter", "whole bins", "parts of a bin", "far"],
)
def test_a_hall_whose_map_is_turned_gives_the_same_answer_turned(
    theta: float, within: float
) -> None:
    """Within a share of a cell; parts of a bin round each beam's direction otherwise."""
    motion = np.array([4.0, -7.0, theta])
    corner = se2.compose(motion, [*SQUARE.geometry.origin])
    elsewhere = OccupancyMap(
        replace(SQUARE.geometry, origin=(corner[0], corner[1], corner[2])), SQUARE.cells
    )
    start = np.array([-1.17, -0.79, 0.5])
    here = begin(SQUARE, M2, start, has_compass=True)
    there = begin(elsewhere, M2, se2.compose(motion, start), has_compass=True)
    for step in wander(8, seed=7):
        expected = se2.compose(motion, here.go(step).pose)
        assert error(there.go(step).pose, expected)[0] < within * CELL


def test_a_hall_without_walls_tells_nothing_and_the_localizer_says_so() -> None:
    cells = np.zeros((20, 20), np.int8)
    world = OccupancyMap(GridGeometry(20, 20, CELL, (-2.0, -2.0, 0.0)), cells)
    run = begin(world, M2, np.zeros(3), has_compass=False)
    estimate = run.measure()
    assert run.localizer.grid.entropy() == pytest.approx(math.log2(20 * 20 * 72), abs=2e-3)
    assert estimate.state == "unknown"
    assert find_modes(*run.localizer.grid.heaviest(100))[0].mass < 0.05
