"""Fixtures that every kind of test shares."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

import processes

settings.register_profile(
    "pilotage",
    deadline=None,  # two cores shared by everything: a slow example says nothing
    max_examples=50,
    derandomize=True,  # the same verdict every time; PILOTAGE_FUZZ looks further
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("further", settings.get_profile("pilotage"), derandomize=False)
settings.load_profile("further" if "PILOTAGE_FUZZ" in os.environ else "pilotage")

REPOSITORY = Path(__file__).resolve().parent.parent


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let random input and long logs not count as coverage: they pass by more than they check."""
    for item in items:
        if item.path.parent.name in ("fuzz", "golden"):
            item.add_marker("no_cover")


@pytest.fixture(scope="session")
def repository() -> Path:
    """The root of the checkout."""
    return REPOSITORY


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of recorded logs and maps; the test is skipped, saying so, without it."""
    folder = Path(os.environ.get("PILOTAGE_DATA", REPOSITORY.parent / "shared" / "datasets"))
    if not folder.is_dir():
        pytest.skip(f"recorded data not found at {folder}; set PILOTAGE_DATA")
    return folder


@pytest.fixture
def free_port() -> int:
    """A TCP port of this machine that nobody listens at."""
    return processes.free_port()


@pytest.fixture(scope="session")
def router_endpoint(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The endpoint of a real router process, one for all tests of the session.

    Tests that share it choose robot names of their own.
    """
    with processes.RouterProcess(tmp_path_factory.mktemp("router")) as router:
        yield router.endpoint
