"""A save that is killed leaves the old map or the new one, whole."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from killed_saves import ENVIRONMENT, killed_saves
from pilotage.mapper.map_library import VERSIONS, MapLibrary
from pilotage.mapper.storage import StateFolder
from saving_forever import NAME, files
from waiting import eventually

pytestmark = pytest.mark.system
STATE_WRITER = """
import itertools, pathlib, sys
import numpy as np
from pilotage.mapper.storage import State, StateFolder
kept = StateFolder(pathlib.Path(sys.argv[1]), print)
found = kept.load()
first = 1 if found is None else found.facts["rows"]
rng = np.random.default_rng(1).random((4000, 300))
for rows in itertools.count(first, 7):
    rows = rows % 3900 + 50
    kept.save(State({"rows": rows}, {"rows": rng[:rows], "sum": rng[:rows].sum(axis=0)}))
"""


def test_of_a_map_there_is_always_the_old_one_or_the_new_one(tmp_path: Path) -> None:
    found = list(killed_saves(tmp_path, tries=8, rng=np.random.default_rng(7)))
    assert len(found) == 8
    MapLibrary(tmp_path).save(NAME, files(1), 1)
    assert len(list((tmp_path / VERSIONS).iterdir())) == 1


def test_of_a_mapping_run_too(tmp_path: Path) -> None:
    whole = np.random.default_rng(1).random((4000, 300))
    for seed in range(6):
        process = subprocess.Popen(
            [sys.executable, "-c", STATE_WRITER, str(tmp_path)], env=ENVIRONMENT
        )
        eventually((tmp_path / "mapper.state").exists, 20.0, "a first state")
        time.sleep(float(np.random.default_rng(seed).uniform(0.4, 0.8)))
        os.kill(process.pid, signal.SIGKILL)
        process.wait(10.0)
        troubles: list[str] = []
        found = StateFolder(tmp_path, troubles.append).load()
        assert troubles == []
        assert found is not None
        rows = found.facts["rows"]
        assert np.array_equal(found.arrays["rows"], whole[:rows])
        assert np.allclose(found.arrays["sum"], whole[:rows].sum(axis=0))
