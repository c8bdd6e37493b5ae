"""Fixtures that every kind of test shares."""

import os
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parent.parent


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
