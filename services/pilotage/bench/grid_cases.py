"""The Markov grid alone: the paper's hall, and 72 million poses at once."""

from collections.abc import Iterator

import numpy as np

from pilotage.bench.buildings import CORRIDOR_MIDDLE, office_block
from pilotage.bench.entry import Entry, Size, Stopwatch
from pilotage.bench.reference import PlainField, PlainGrid
from pilotage.bench.walk import BEAMS, corridor_walk
from pilotage.core import se2
from pilotage.core.raycast import cast_scan
from pilotage.localizer.likelihood_field import LikelihoodFieldParams, likelihood_field
from pilotage.localizer.markov_grid import MarkovGrid, MotionSpread
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid
from pilotage.localizer.range_model import RangeModelParams, range_likelihoods, range_table
from pilotage.robot.simulator.floor_plans import square_hall

RANGE_MAX = 25.0
RANGERS = np.array([0.0, np.pi / 2.0, -np.pi / 2.0, np.pi])
TURN = np.deg2rad(5.0)
CIRCLE = 72
"""Steps of 0.10 m and 5 degrees that lead once round: what happens now and then has its share."""

COMPASS_SIGMA = np.deg2rad(3.0)
TEMPERING = 0.15


def hall_case(watch: Stopwatch) -> Iterator[Entry]:
    """Yield one step of the paper's hall: four ranges and a compass under M2, P0 and all."""
    world = square_hall()
    states = pose_grid(world, PoseGridParams())
    table = range_table(world, states.geometry, states.headings, RANGE_MAX)
    increment = np.array([0.10, 0.0, TURN])
    pose = np.array([8.0, 5.0, 0.3])
    steps = []
    for _ in range(CIRCLE):
        pose = se2.compose(pose, increment)
        ranges = cast_scan(world, pose, RANGERS, RANGE_MAX)
        likelihoods = range_likelihoods(ranges, RANGE_MAX, RangeModelParams())
        steps.append((float(pose[2]), likelihoods))
    grid = MarkovGrid(states, MotionSpread())

    def round_the_circle() -> None:
        for yaw, likelihoods in steps:
            grid.predict(increment)
            grid.add_floor(1.0, (yaw, COMPASS_SIGMA))
            grid.weigh_ranges(RANGERS, likelihoods, table)
            grid.settle()

    layers = 18
    plain = PlainGrid(states, layers)

    def plain_step() -> None:
        yaw, likelihoods = steps[0]
        plain.predict(increment)
        plain.add_floor(1.0, (yaw, COMPASS_SIGMA))
        plain.weigh_ranges(RANGERS, likelihoods, table)
        plain.settle()

    fraction = layers / states.headings
    yield Entry(
        "square hall: predict and update by 4 ranges and a compass",
        Size(int(np.prod(states.shape)), len(RANGERS)),
        watch.median_ms(round_the_circle, 3) / CIRCLE,
        watch.median_ms(plain_step, 3) / fraction,
        fraction,
    )


def exact_posterior_case(watch: Stopwatch, side: float = 100.0) -> Iterator[Entry]:
    """Yield the exact posterior of one scan over a building of 100 m x 100 m, nothing left out."""
    world = office_block(side)
    states = pose_grid(world, PoseGridParams())
    params = LikelihoodFieldParams()
    field = likelihood_field(world, states.geometry, states.heading_step, params)
    (sight,) = corridor_walk(world, (side / 2.0, side - 1.5, CORRIDOR_MIDDLE), 1)
    ends = sight.scan.ends
    if ends is None:
        return
    grid = MarkovGrid(states, MotionSpread())

    def posterior() -> None:
        grid.add_floor(1.0)
        grid.weigh_scan(ends, field, TEMPERING)
        grid.settle()

    spent = watch.median_ms(posterior, 5)
    layers = 2
    plain, plain_field = PlainGrid(states, layers), PlainField(states, params)

    def plain_posterior() -> None:
        plain.add_floor(1.0, None)
        plain.weigh_scan(ends, plain_field, TEMPERING)
        plain.settle()

    fraction = layers / states.headings
    yield Entry(
        "exact posterior of one scan over 100 m x 100 m",
        Size(int(np.prod(states.shape)), BEAMS),
        spent,
        watch.median_ms(plain_posterior, 1) / fraction,
        fraction,
        {"admissible_states": float(states.admissible_states)},
    )
