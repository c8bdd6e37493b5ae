"""A pipe given for a file is refused at once: reading it might never end."""

import os
from pathlib import Path

import pytest

from pilotage.bus.deployment import ConfigError, read_deployment
from pilotage.core.logs import LogError, read_log
from pilotage.core.map_files import MapFileError, load_map


@pytest.fixture
def pipe(tmp_path: Path) -> Path:
    os.mkfifo(tmp_path / "pipe")
    return tmp_path / "pipe"


def test_no_pipe_is_a_map(pipe: Path) -> None:
    with pytest.raises(MapFileError, match="pipe or a device"):
        load_map(pipe)


def test_no_pipe_is_a_log(pipe: Path) -> None:
    with pytest.raises(LogError, match="pipe or a device"):
        read_log(pipe)


def test_no_pipe_is_a_deployment(pipe: Path) -> None:
    with pytest.raises(ConfigError, match="pipe or a device"):
        read_deployment(pipe)
