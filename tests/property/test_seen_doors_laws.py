"""Laws of doors in a scan: they move with the robot's frame, and a mirror turns them round."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.topology.features import KINDS, Features
from pilotage.topology.seeing.door_edges import SeenEdges
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.seeing.seen_doors import seen_doors

FIRST, STEP, BEAMS = float(np.deg2rad(-120.0)), float(np.deg2rad(0.5)), 481
BEARINGS = FIRST + STEP * np.arange(BEAMS)


@st.composite
def scans(draw: st.DrawFn) -> tuple[NDArray[np.float64], float, float]:
    """A wall `distance` m ahead with a door; its ranges, and where the door begins and ends."""
    distance, begin = draw(st.floats(0.8, 2.5)), draw(st.floats(-1.2, 0.4))
    width, depth = draw(st.floats(0.75, 1.2)), draw(st.sampled_from([0.1, 0.15, 3.0]))
    ahead = np.maximum(np.cos(BEARINGS), 1e-6)
    on_wall = distance / ahead
    across = on_wall * np.sin(BEARINGS)
    behind = (distance + depth) / ahead
    shows_leaf = (behind * np.sin(BEARINGS) > begin) & (behind * np.sin(BEARINGS) < begin + width)
    jamb = np.where(behind * np.sin(BEARINGS) > begin, begin + width, begin)
    at_jamb = jamb / np.where(np.abs(BEARINGS) < 1e-9, 1e-9, np.sin(BEARINGS))
    in_gap = (across > begin) & (across < begin + width)
    ranges = np.where(in_gap, np.where(shows_leaf, behind, np.abs(at_jamb)), on_wall)
    noise = 0.005 * np.random.default_rng(draw(st.integers(0, 2**32 - 1))).standard_normal(BEAMS)
    return np.where(ranges < 8.0, ranges + noise, np.inf), begin, begin + width


def frame(begin: float, end: float, distance: float) -> SeenEdges:
    across = np.array([begin - 0.07, begin, end, end + 0.07])
    return SeenEdges(np.zeros(2), np.arctan2(across, distance), 0.002)


def doors(features: Features) -> Features:
    return features.chosen(features.kinds == KINDS.index("door"))


@given(scans())
@settings(deadline=None, max_examples=60)
def test_the_door_is_found_where_it_is(scan: tuple[NDArray[np.float64], float, float]) -> None:
    ranges, begin, end = scan
    found = doors(seen_doors(ScanView.of(ranges, (FIRST, STEP))))
    assert len(found) == 1
    assert found.poses[0, 1] == pytest.approx((begin + end) / 2.0, abs=0.05)
    assert found.widths[0] == pytest.approx(end - begin, abs=0.08)


@given(scans(), st.tuples(*[st.floats(-1.0, 1.0)] * 2, st.floats(-np.pi, np.pi)))
@settings(deadline=None, max_examples=40)
def test_doors_move_with_the_mount(
    scan: tuple[NDArray[np.float64], float, float], mount: tuple[float, float, float]
) -> None:
    ranges, begin, end = scan
    distance = float(ranges[BEAMS // 2])
    here = seen_doors(ScanView.of(ranges, (FIRST, STEP)), frame(begin, end, distance))
    edges = frame(begin, end, distance).moved(mount)
    there = seen_doors(ScanView.of(ranges, (FIRST, STEP), mount), edges)
    expected = here.moved(mount)
    assert there.kinds.tolist() == expected.kinds.tolist()
    assert there.poses[:, :2] == pytest.approx(expected.poses[:, :2], abs=1e-6)
    assert there.covariances == pytest.approx(expected.covariances, abs=1e-9)


@given(scans())
@settings(deadline=None, max_examples=40)
def test_in_a_mirror_doors_change_sides(scan: tuple[NDArray[np.float64], float, float]) -> None:
    ranges, begin, end = scan
    here = doors(seen_doors(ScanView.of(ranges, (FIRST, STEP))))
    there = doors(seen_doors(ScanView.of(ranges[::-1].copy(), (FIRST, STEP))))
    assert there.poses[:, 1] == pytest.approx(-here.poses[:, 1], abs=0.02)
    assert there.widths == pytest.approx(here.widths, abs=0.02)
    assert begin < end


@given(st.integers(0, 2**32 - 1), st.integers(0, 6))
@settings(deadline=None, max_examples=40)
def test_any_scan_and_any_edges_give_finite_doors(seed: int, edges: int) -> None:
    rng = np.random.default_rng(seed)
    ranges = rng.uniform(0.1, 6.0, BEAMS)
    ranges[rng.random(BEAMS) < 0.1] = np.inf
    ranges[rng.random(BEAMS) < 0.1] = np.nan
    seen = SeenEdges(rng.uniform(-0.2, 0.2, 2), rng.uniform(-np.pi, np.pi, edges), 0.002)
    found = seen_doors(ScanView.of(ranges, (FIRST, STEP)), seen)
    assert np.isfinite(found.poses).all()
    assert np.isfinite(found.widths).all()
    assert (np.linalg.eigvalsh(found.covariances) > 0.0).all()
    assert len(se2.inverse(found.poses)) == len(found)
