"""Ranges weigh a state where it lies, not where the middle of its cell does."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.localizer.layers import Layers
from pilotage.localizer.markov_grid import MarkovGrid
from pilotage.localizer.modes import find_modes
from pilotage.localizer.motion_spread import MotionSpread
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid
from pilotage.localizer.range_model import RangeModelParams, range_likelihoods, range_table

CELL, HEADINGS, RANGE_MAX = 0.2, 24, 8.0
BEARINGS = np.array([0.0, 0.5, 1.0, -1.0, -0.5]) * math.pi
STILL = MotionSpread(0.0, 0.0, 0.0, 0.0)


def hall(origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> OccupancyMap:
    """6 m x 5 m, walls of one cell all round."""
    cells = np.zeros((25, 30), np.int8)
    cells[[0, -1]], cells[:, [0, -1]] = 100, 100
    return OccupancyMap(GridGeometry(25, 30, CELL, origin), cells)


WORLD = hall()
STATES = pose_grid(WORLD, PoseGridParams(CELL, HEADINGS))
TABLE = range_table(WORLD, STATES.geometry, HEADINGS, RANGE_MAX)
PARTS = st.floats(-0.49, 0.49)


@settings(max_examples=30, deadline=None)
@given(PARTS, PARTS, st.sampled_from([0, 6, 12, 18]))
def test_a_robot_between_the_cells_is_found_there(right: float, up: float, layer: int) -> None:
    """The layers lie half a cell off, and so does the robot: nothing pulls it to a cell."""
    grid = MarkovGrid(STATES, STILL)
    start = se2.compose(STATES.geometry.origin, [2.3, 1.7, layer * STATES.heading_step])
    step = se2.between(start, np.add(start, [right * CELL, up * CELL, 0.0]))
    grid.set_gaussian(start, np.diag([0.15, 0.15, 1e-6]))
    grid.predict(step)
    truth = se2.compose(start, step)
    ranges = cast_scan(WORLD, truth, BEARINGS, RANGE_MAX)
    for _ in range(3):
        grid.add_floor(0.0)
        likelihoods = range_likelihoods(ranges, RANGE_MAX, RangeModelParams(delta=0.1))
        grid.weigh_ranges(BEARINGS, likelihoods, TABLE)
        grid.settle()
    found = find_modes(*grid.heaviest(1000))[0].pose
    assert found[:2] == pytest.approx(truth[:2], abs=0.25 * CELL)


@given(st.floats(-3.0, 3.0), PARTS, PARTS, st.floats(-3.0, 3.0))
def test_a_wall_met_head_on_is_nearer_by_how_far_ahead_a_state_lies(
    turn: float, right: float, up: float, bearing: float
) -> None:
    states = pose_grid(hall((1.0, -2.0, turn)), PoseGridParams(CELL, HEADINGS))
    layers = Layers(states)
    layers.move(0.0, 0.0, 0.2)
    layers.offsets[:] = right, up
    ahead = layers.offsets_along(np.array([bearing]))
    assert ahead.shape == (HEADINGS, 1)
    cells = np.array([[k, 5, 7] for k in range(HEADINGS)])
    poses = layers.poses_of(cells)
    centres = states.geometry.centres_of(cells[:, 1:])
    for k, (pose, centre) in enumerate(zip(poses, centres, strict=True)):
        beam = pose[2] + bearing
        off = pose[:2] - centre
        assert ahead[k, 0] == pytest.approx(off @ [math.cos(beam), math.sin(beam)], abs=1e-9)
