"""The localizer's machine code is there before a robot waits for it."""

from functools import partial

import pytest

from localizer_bench import Bench
from pilotage.bus.fabric import Sample
from pilotage.core.warm_up import WARM_UPS
from pilotage.localizer import service, warm_up
from pilotage_schemas.codec import decode
from pilotage_schemas.health import Heartbeat


def test_whoever_watches_the_localizer_is_told_that_compiling_takes_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    beats: list[Heartbeat] = []
    told: list[tuple[str, float]] = []
    bench = Bench()

    def hear(sample: Sample) -> None:
        beats.append(decode(Heartbeat, sample.payload))

    bench.fabric.declare_subscriber("pilotage/@v1/demo/heartbeat/localizer", "latest_wins", hear)
    monkeypatch.setattr(
        service, "warm_up", lambda: told.append((beats[-1].state, beats[-1].within))
    )
    bench.begin_localizer()
    assert told == [("busy", service.MAP_WORK_S)]


def test_all_kernels_of_the_localizer_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    modules = {entry.split(":")[0] for entry in WARM_UPS if ".localizer." in entry}
    called: list[str] = []
    for module in modules:
        monkeypatch.setattr(f"{module}.warm_up", partial(called.append, module))
    warm_up.warm_up()
    assert set(called) == modules
