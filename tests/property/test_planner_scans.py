"""Laws of what is expected to be seen on a map, and of how much its places say."""

from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from naive import active as naive
from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import FREE, OCCUPIED, UNKNOWN, GridGeometry, OccupancyMap
from pilotage.core.laser_view import View
from pilotage.planner.active_localization import ActiveLocalization, ActiveParams
from pilotage.planner.common_ground import Clearance
from pilotage.planner.expected_scans import HEADINGS, ExpectedScans, SightParams
from pilotage.planner.map_potential import WIDTH, _information, _looks, map_potential
from pilotage.planner.sight import ScanSight
from pilotage.planner.situation import Hypotheses
from planner_world import plan

BIN = 2.0 * np.pi / HEADINGS
seeds = st.integers(0, 2**32 - 1)
SIGHT = SightParams(range_max=4.0, beams=12)


@st.composite
def floors(draw: st.DrawFn, resolution: float = 0.2) -> OccupancyMap:
    """A walled floor of some metres with boxes in it, some of them unknown, lying anyhow."""
    rng = np.random.default_rng(draw(seeds))
    rows, cols = draw(st.integers(8, 14)), draw(st.integers(8, 14))
    cells = np.full((rows, cols), FREE, np.int8)
    for value in (UNKNOWN, OCCUPIED, OCCUPIED):
        row, col = rng.integers(0, (rows, cols))
        cells[row : row + rng.integers(1, 4), col : col + rng.integers(1, 4)] = value
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    origin = tuple(float(value) for value in rng.uniform(-3.0, 3.0, 3))
    geometry = GridGeometry(rows, cols, resolution, (origin[0], origin[1], origin[2]))
    return OccupancyMap(geometry, cells)


def on_the_table(world: OccupancyMap, count: int, seed: int) -> NDArray[np.float64]:
    """Return poses (n, 3) well inside cells and heading bins, on the map and just off it."""
    rng = np.random.default_rng(seed)
    cells = rng.integers(-1, np.array(world.geometry.shape) + 1, (count, 2))
    poses = np.empty((count, 3))
    aside = rng.uniform(-0.4, 0.4, (count, 2)) * world.geometry.resolution
    in_grid = (cells[:, ::-1] + 0.5) * world.geometry.resolution + aside
    poses[:, :2] = se2.transform_points(world.geometry.origin, in_grid)
    poses[:, 2] = wrap((rng.integers(0, HEADINGS, count) + rng.uniform(-0.4, 0.4, count)) * BIN)
    return poses


@given(floors(), seeds)
def test_scans_are_those_of_rays_from_the_nearest_state(world: OccupancyMap, seed: int) -> None:
    scans = ExpectedScans(world, SIGHT)
    poses = on_the_table(world, 8, seed)
    looked_up = scans.at(poses)
    cast = [naive.expected_scan(world, scans.geometry, pose, SIGHT) for pose in poses]
    level = SIGHT.range_max / 255.0
    off = np.abs(looked_up - np.array(cast).T) > 1.01 * level
    # A ray through a corner may take either cell.
    assert off.mean() < 0.05


def test_a_coarser_table_lies_on_the_same_floor() -> None:
    world = plan("######## #......# #......# #...##.# #......# ########", mark=3, resolution=0.1)
    scans = ExpectedScans(world, SIGHT)
    assert scans.geometry.resolution == pytest.approx(0.2)
    rng = np.random.default_rng(7)
    poses = np.zeros((30, 3))
    poses[:, :2] = rng.uniform(0.35, (2.0, 1.4), (30, 2))
    cast = [naive.expected_scan(world, scans.geometry, pose, SIGHT) for pose in poses]
    assert np.mean(np.abs(scans.at(poses) - np.array(cast).T) > 0.02) < 0.05


@given(seeds)
def test_looks_are_fourier_sums_that_do_not_turn_with_the_robot(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scans = rng.uniform(0.0, 12.0, (36, 3)).astype(np.float32)
    looks = _looks(scans)
    assert looks == pytest.approx(np.array([naive.look(scan, 10) for scan in scans.T]), abs=1e-4)
    turned = np.roll(scans, int(rng.integers(36)), axis=0)
    assert _looks(turned) == pytest.approx(looks, abs=1e-4)


@given(seeds, st.integers(1, 9), st.integers(1, 9))
def test_information_counts_those_that_look_alike(seed: int, count: int, others: int) -> None:
    rng = np.random.default_rng(seed)
    looks = rng.normal(0.0, rng.choice([0.1, 1.0, 9.0]), (count, 4)).astype(np.float32)
    met = rng.normal(0.0, 1.0, (others, 4)).astype(np.float32)
    bits = _information(looks, met, WIDTH)
    assert bits == pytest.approx(naive.information(looks, met, WIDTH), abs=1e-4)
    assert (bits >= 0.0).all()
    assert (bits <= np.log2(others + 1.0) + 1e-6).all()


@given(floors())
def test_a_potential_is_never_negative_and_nothing_where_nobody_stands(
    world: OccupancyMap,
) -> None:
    potential = map_potential(world, ExpectedScans(world, SIGHT), 0.165)
    assert (potential.bits >= 0.0).all()
    assert np.isfinite(potential.bits).all()
    centres = potential.geometry.centres_of(np.argwhere(potential.bits > 0.0))
    cells = world.geometry.cells_of(centres)
    cells = np.clip(cells, 0, np.array(world.geometry.shape) - 1)
    assert (Clearance(world).metres[tuple(cells.T)] > 0.165).all()
    tops = potential.geometry.cells_of(potential.maxima())
    heights = potential.bits[tuple(tops.T)]
    assert (np.diff(heights) <= 0.0).all()
    assert potential.bits.max() == (heights.max() if len(heights) else 0.0)


@given(floors())
def test_the_room_around_a_cell_is_that_of_the_twin(world: OccupancyMap) -> None:
    assert Clearance(world).metres == pytest.approx(naive.clearance(world), abs=1e-5)


ODD = """
    ##################
    #....#....#....#.#
    #....#....#....#.#
    #....#....#.##.#.#
    #....#....#.##.#.#
    #....#....#....#.#
    ##################
    """


def rotated(world: OccupancyMap) -> OccupancyMap:
    """Return the same floor a quarter turn to the left."""
    cells = np.ascontiguousarray(np.rot90(world.cells, -1))
    rows, cols = cells.shape
    return OccupancyMap(GridGeometry(rows, cols, world.geometry.resolution), cells)


def test_the_potential_turns_with_the_building() -> None:
    # Three cells to a cell of the potential: its centre lies within one of them.
    world = plan(ODD, mark=6, resolution=0.15)
    straight = map_potential(world, ExpectedScans(world, SIGHT), 0.165).bits
    turned = rotated(world)
    bits = map_potential(turned, ExpectedScans(turned, SIGHT), 0.165).bits
    off = np.abs(np.rot90(bits, 1) - straight)
    assert np.median(off) < 0.01
    assert np.mean(off > 0.3) < 0.05


def test_an_odd_room_says_more_than_one_of_two_alike() -> None:
    world = plan(ODD, mark=4, resolution=0.2)
    potential = map_potential(world, ExpectedScans(world, SIGHT), 0.165)

    def mean_of(first: int, last: int) -> float:
        """Of the columns of marks, two cells each."""
        columns = potential.bits[:, first * 2 : (last + 1) * 2]
        return float(columns[columns > 0.0].mean())

    alike, also, odd = mean_of(1, 4), mean_of(6, 9), mean_of(11, 14)
    assert alike == pytest.approx(also, abs=0.1)
    assert odd > alike + 0.5


@lru_cache
def _active(theta: float, shift: tuple[int, int]) -> ActiveLocalization:
    """On the odd rooms, moved by whole cells in a map that lies at an angle."""
    world = plan(ODD, mark=4, resolution=0.2)
    geometry = GridGeometry(*world.geometry.shape, 0.2, (0.2 * shift[0], 0.2 * shift[1], theta))
    sight = SightParams(range_max=4.0)
    return ActiveLocalization(OccupancyMap(geometry, world.cells), ActiveParams(sight=sight))


@given(
    seeds,
    st.sampled_from([(0.0, (7, -3)), (3 * BIN, (0, 0)), (-20 * BIN, (4, 9)), (13 * BIN, (0, 1))]),
)
def test_nothing_changes_if_map_and_belief_are_moved_together(
    seed: int, moved: tuple[float, tuple[int, int]]
) -> None:
    rng = np.random.default_rng(seed)
    here, there = _active(0.0, (0, 0)), _active(*moved)
    cells = rng.integers((5, 5), (23, 60), (6, 2)) + rng.uniform(0.25, 0.75, (6, 2))
    headings = (rng.integers(0, HEADINGS, 6) + rng.uniform(-0.3, 0.3, 6)) * BIN
    poses = np.column_stack([0.2 * cells[:, ::-1], headings])
    weights = rng.dirichlet(np.ones(6))
    frame = np.array([0.2 * moved[1][0], 0.2 * moved[1][1], moved[0]])
    # No way off: that could end on the boundary of two cells.
    points = np.zeros((1, 2))
    one = here.gains(Hypotheses(poses, weights), points)
    other = there.gains(Hypotheses(se2.compose(frame, poses), weights), points)
    assert one == pytest.approx(other, abs=0.02)


@given(seeds)
def test_gains_lie_between_nothing_and_all_there_is_to_know(seed: int) -> None:
    rng = np.random.default_rng(seed)
    active = _active(0.0, (0, 0))
    count = int(rng.integers(1, 20))
    poses = np.column_stack(
        [rng.uniform(1.0, 13.0, count), rng.uniform(1.0, 4.5, count), rng.uniform(-3.0, 3.0, count)]
    )
    times = rng.integers(1, 4, count)
    weights = times / times.sum()
    gains = active.gains(Hypotheses(poses, weights), rng.uniform(-2.0, 2.0, (4, 2)))
    assert (gains <= np.log2(count) + 1e-6).all()
    assert (gains >= -0.02).all()


def test_a_gain_is_what_the_twins_make_of_it() -> None:
    world, rng = plan(ODD, mark=4, resolution=0.2), np.random.default_rng(5)
    params = ActiveParams(sight=SightParams(range_max=4.0), observations=7)
    poses = np.empty((7, 3))
    poses[:, :2] = 0.2 * rng.integers(6, (56, 22), (7, 2)) + 0.1
    poses[:, 2] = BIN * rng.integers(0, HEADINGS, 7)
    scans = [naive.expected_scan(world, world.geometry, pose, params.sight) for pose in poses]
    seen = np.array(scans, np.float32).T
    logs = naive.log_likelihoods(seen, np.arange(7), params.sight).astype(np.float32)
    places = Hypotheses(poses, np.full(7, 1.0 / 7.0))
    gain = ActiveLocalization(world, params).gains(places, np.zeros((1, 2)))
    assert gain == pytest.approx([naive.expected_gain(logs, places.weights)], abs=0.02)


@given(st.floats(0.3, np.pi), st.floats(-3.1, 3.1), st.integers(20, 90))
def test_a_laser_sees_what_is_not_the_gap(half: float, turn: float, beams: int) -> None:
    """However the laser is mounted, and though its bearings wrap."""
    bearings = wrap(turn + np.linspace(-half, half, beams))
    sight = ScanSight(plan("### #.# ###", 2, 0.2), SIGHT, 0.165)
    step = 2.0 * half / (beams - 1)
    middle, found = sight.window(View(np.zeros((0, 2)), bearings))
    assert found == pytest.approx(half, abs=0.5 * step + 1e-6)
    # Of a full turn any direction is the middle.
    assert abs(wrap(middle - turn)) < 1e-6 or half > np.pi - step


def test_who_looks_nowhere_has_no_view() -> None:
    sight = ScanSight(plan("### #.# ###", 2, 0.2), SIGHT, 0.165)
    assert sight.window(View(np.zeros((0, 2)), np.zeros(0))) == (0.0, 0.0)
    assert sight.window(View(np.zeros((0, 2)), np.zeros(1))) == (0.0, 0.0)


@given(floors(), seeds, st.floats(-np.pi, np.pi), st.floats(0.2, 3.0))
def test_a_window_shows_those_beams_of_the_turn_that_lie_in_it(
    world: OccupancyMap, seed: int, middle: float, half: float
) -> None:
    scans, poses = ExpectedScans(world, SIGHT), on_the_table(world, 4, seed)
    around = np.arange(SIGHT.beams) * 2.0 * np.pi / SIGHT.beams
    inside = np.abs(wrap(around - middle)) <= half + 1e-9
    assert (scans.at(poses, (middle, half)) == scans.at(poses)[inside]).all()
