"""Who may import what: the contracts of pyproject.toml, and which library belongs where."""

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from architecture.source_tree import Module, product_modules, teach


@dataclass(frozen=True)
class Home:
    """Where a library may be imported, and what to do elsewhere."""

    prefixes: tuple[str, ...]
    lesson: str
    suffixes: tuple[str, ...] = ()

    def admits(self, module: str) -> bool:
        """Whether the module may import the library."""
        return module.startswith(self.prefixes) or bool(
            self.suffixes and module.endswith(self.suffixes)
        )


HTTP = Home(("pilotage.gateway.",), "HTTP is the gateway's: answer a query, it will offer it")
HOMES = {
    "zenoh": Home(("pilotage.bus.",), "replacing Zenoh must touch bus/ only: use pilotage.bus"),
    "fastapi": HTTP,
    "starlette": HTTP,
    "uvicorn": HTTP,
    "pydantic": Home(
        ("pilotage_schemas.", "pilotage.bus.", "pilotage.gateway.", "pilotage.launcher.effective"),
        "validate at the edge (messages, config), trust types inside: use a frozen dataclass",
        suffixes=(".config",),
    ),
    "cbor2": Home(
        ("pilotage_schemas.", "pilotage.gateway.", "pilotage.recorder."),
        "bytes become messages in pilotage_schemas.codec",
    ),
    "typer": Home(("pilotage.cli",), "the command line is cli.py"),
    "matplotlib": Home(
        ("pilotage.experiments.", "pilotage.map_picture", "pilotage.topology_picture"),
        "figures are drawn by experiments and by the map commands: the services send data",
    ),
}

CORE_MAY_IMPORT = {"numpy", "numba", "pilotage", *sys.stdlib_module_names}
CORE_FILES_MAY_IMPORT = {
    "pilotage.core.map_image": {"PIL"},
    "pilotage.core.map_files": {"PIL", "yaml"},
    "pilotage.core.map_yaml": {"yaml"},
    "pilotage.core.landmark_map": {"yaml"},
    "pilotage.core.logs.ros_bag": {"rosbags"},
}

COMPUTING = ("core", "localizer", "mapper", "planner", "topology")
GLUE = {"__main__", "config", "service", "storage", "messages", "warm_up"} | {
    *(
        "queries",
        "map_choice",
        "camera_setup",
        "method_setup",
        "map_show",
        "takeover",
        "hearing",
        "showing",
        "relocalization",
    ),  # parts of a service
}
"""Modules of a computing package that may know messages, clocks or files."""

IMPURE = (
    *("time", "datetime", "threading", "multiprocessing", "concurrent", "subprocess", "asyncio"),
    *("socket", "signal", "logging", "random", "tempfile", "pilotage.bus", "pilotage_schemas"),
)


def is_mathematics(module: Module) -> bool:
    """Whether the module must be pure: whatever computes and is not glue."""
    parts = module.name.split(".")
    return len(parts) > 2 and parts[1] in COMPUTING and not GLUE.intersection(parts)


def test_the_import_contracts_of_pyproject_hold(repository: Path) -> None:
    command = [str(Path(sys.executable).parent / "lint-imports"), "--no-cache"]
    linted = subprocess.run(command, cwd=repository, capture_output=True, text=True, check=False)
    assert linted.returncode == 0, linted.stdout


def test_a_library_is_imported_only_where_it_is_at_home() -> None:
    teach(
        f"{module}:{line} imports {library}: {HOMES[library].lesson}"
        for module in product_modules()
        for line, library in module.libraries()
        if library in HOMES and not HOMES[library].admits(module.name)
    )


def test_the_core_runs_in_a_notebook_with_numpy_and_numba_alone() -> None:
    teach(
        f"{module}:{line} imports {library}: core/ needs numpy and numba only (map files also "
        "PIL and yaml); what talks to the world belongs into a service"
        for module in product_modules()
        for line, library in module.libraries()
        if module.name.startswith("pilotage.core.")
        and library not in CORE_MAY_IMPORT | CORE_FILES_MAY_IMPORT.get(module.name, set())
    )


def test_the_mathematics_knows_no_clock_thread_process_log_or_message() -> None:
    teach(
        f"{module}:{line} imports {imported}: mathematics is pure. Time (`stamp`) and chance "
        "(`rng`) are arguments; messages become arrays in service.py"
        for module in product_modules()
        for line, imported in module.imports()
        if is_mathematics(module) and f"{imported}.".startswith(tuple(f"{i}." for i in IMPURE))
    )


def test_chance_comes_from_a_generator_that_was_handed_in() -> None:
    teach(
        f"{module}:{line}: take an `rng` as argument; a generator made here repeats itself unseen"
        for module in product_modules()
        for line, text in module.lines()
        if "np.random.seed" in text or (is_mathematics(module) and "default_rng(" in text)
    )
