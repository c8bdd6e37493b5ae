"""The mapper's machine code is there before a robot waits for it."""

import pytest
from numba.core.dispatcher import Dispatcher

from mapper_bench import MapperBench
from pilotage.mapper import (
    correlative_kernels,
    laser_grid_kernels,
    map_choice,
    matching_kernels,
    surfel_kernels,
    visibility_kernels,
)
from pilotage.mapper.warm_up import warm_up
from pilotage_schemas.commands import MapStart
from pilotage_schemas.health import Heartbeat


@pytest.mark.parametrize(
    "kernel",
    [
        correlative_kernels.branch_and_bound,
        correlative_kernels.pooled,
        laser_grid_kernels.insert_beams,
        matching_kernels.normal_equations,
        surfel_kernels.pool_points,
        surfel_kernels.spread_nearest,
        surfel_kernels.thin_points,
        surfel_kernels.wall_directions,
        visibility_kernels.beams_through_walls,
    ],
)
def test_what_mapping_by_laser_calls_is_compiled(kernel: Dispatcher) -> None:
    warm_up()
    assert kernel.signatures


def test_whoever_watches_the_mapper_is_told_that_compiling_takes_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench = MapperBench()
    beats = bench.listen("heartbeat/mapper", Heartbeat)
    told: list[tuple[str, float]] = []
    monkeypatch.setattr(
        map_choice, "warm_up", lambda: told.append((beats[-1].state, beats[-1].within))
    )
    bench.ask("map_start", MapStart())
    assert told == [("busy", map_choice.WORK_S)]
