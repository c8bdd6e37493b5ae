"""The topology's machine code is there before a robot waits for it."""

import pkgutil
from importlib import import_module

import numpy as np
import pytest
from numba.core.dispatcher import Dispatcher

from floor_plans import FLAT, floor_plan
from pilotage import core, topology
from pilotage.core.grid import OccupancyMap
from pilotage.topology.map_building import build_topology
from pilotage.topology.route import Router
from pilotage.topology.warm_up import warm_up


def kernels_of(package: str, path: list[str]) -> dict[str, Dispatcher]:
    """All kernels that the modules of a package define, by module and name."""
    found = {}
    for module in pkgutil.iter_modules(path, f"{package}."):
        if not module.name.endswith("__main__"):
            for name, value in vars(import_module(module.name)).items():
                if isinstance(value, Dispatcher) and value.__module__ == module.name:
                    found[f"{module.name}.{name}"] = value
    return found


def within_others(kernels: dict[str, Dispatcher]) -> set[str]:
    """Those that other kernels call: machine code from the cache knows nothing of them."""
    called = {
        id(kernel.py_func.__globals__.get(name))
        for kernel in kernels.values()
        for name in kernel.py_func.__code__.co_names
    }
    return {name for name, kernel in kernels.items() if id(kernel) in called}


KERNELS = kernels_of("pilotage.topology", list(topology.__path__))
ALL = KERNELS | kernels_of("pilotage.core", list(core.__path__))
OUTER = sorted(KERNELS.keys() - within_others(KERNELS))


@pytest.mark.parametrize("name", OUTER)
def test_every_kernel_of_the_topology_is_made(name: str) -> None:
    warm_up()
    assert KERNELS[name].signatures


@pytest.mark.parametrize("from_the_bus", [True, False])
def test_nothing_is_left_to_compile_when_a_map_comes(*, from_the_bus: bool) -> None:
    warm_up()
    before = {name: len(kernel.signatures) for name, kernel in ALL.items()}
    drawn = floor_plan(FLAT)
    cells = drawn.cells.copy()
    cells.flags.writeable = not from_the_bus
    world = build_topology(OccupancyMap(drawn.geometry, cells), "0123")
    router = Router(world)
    assert router.route(world.nodes[0].id, world.nodes[-1].id).cost > 0.0
    assert router.nearest(np.array([1.0, 1.0])) is not None
    after = {name: len(kernel.signatures) for name, kernel in ALL.items()}
    assert {name for name in ALL if after[name] > before[name]} == set()
