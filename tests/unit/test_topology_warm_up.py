"""The topology service's machine code is there before a robot waits for it."""

from typing import Any

import pytest
from numba.core.dispatcher import Dispatcher

from pilotage.bus.fabric import Sample
from pilotage.topology import map_choice, service
from pilotage.topology.at_nodes import matching_kernels
from pilotage.topology.from_map import chords, ways
from pilotage.topology.node_chains import kernels as chain_kernels
from pilotage.topology.routes import route_kernels
from pilotage.topology.warm_up import warm_up
from pilotage_schemas.codec import decode
from pilotage_schemas.health import Heartbeat
from topology_bench import TopologyBench


@pytest.mark.parametrize(
    "kernel",
    [
        chords.opposite_walls,
        ways.spread,
        chain_kernels.weigh_places,
        matching_kernels.count_votes,
        matching_kernels.settle,
        route_kernels.cheapest_steps,
        route_kernels.landmark_costs,
    ],
)
def test_what_the_service_calls_is_compiled(kernel: Dispatcher) -> None:
    warm_up()
    assert kernel.signatures


def test_a_map_and_a_drive_compile_nothing_more() -> None:
    warm_up()
    kernels: list[Any] = [ways.spread, matching_kernels.settle]
    kernels.append(chain_kernels.weigh_places)
    before = [len(kernel.signatures) for kernel in kernels]
    bench = TopologyBench()
    bench.describe()
    bench.put_map()
    bench.ride((2.45, 7.0), (2.45, 10.0))
    bench.ride((2.45, 11.0), state="unknown")
    assert [len(kernel.signatures) for kernel in kernels] == before


def test_whoever_watches_the_service_is_told_that_compiling_takes_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    beats: list[Heartbeat] = []
    told: list[tuple[str, float]] = []
    bench = TopologyBench()

    def hear(sample: Sample) -> None:
        beats.append(decode(Heartbeat, sample.payload))

    bench.fabric.declare_subscriber("pilotage/@v1/demo/heartbeat/topology", "latest_wins", hear)
    monkeypatch.setattr(
        service, "warm_up", lambda: told.append((beats[-1].state, beats[-1].within))
    )
    bench.begin()
    assert told == [("busy", map_choice.WORK_S)]
