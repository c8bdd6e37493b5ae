"""Kills a process that saves maps at random moments, and looks at what is left."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pilotage.core.map_files import load_map, map_digest
from pilotage.mapper.map_library import VERSIONS, MapLibrary
from runs import SOURCES
from saving_forever import NAME, files, world

SCRIPT = Path(__file__).resolve().parent / "saving_forever.py"
ENVIRONMENT = os.environ | {"PYTHONPATH": os.pathsep.join(SOURCES)}
DIGESTS = {map_digest(world(number)): number for number in (0, 1)}


def killed_saves(folder: Path, tries: int, rng: np.random.Generator) -> Iterator[tuple[int, int]]:
    """Yield, for each kill, which of the maps is there whole, and how many versions were left.

    AssertionError: what is there is neither of the two maps, whole.
    """
    MapLibrary(folder).save(NAME, files(0), 0)
    for _ in range(tries):
        process = subprocess.Popen(
            [sys.executable, str(SCRIPT), str(folder)], env=ENVIRONMENT, stdout=subprocess.PIPE
        )
        with process:
            assert process.stdout is not None
            assert process.stdout.readline() == b"begun\n"
            # A save takes some tens of ms: so kills fall into every step of it.
            time.sleep(float(rng.uniform(0.0, 0.15)))
            process.kill()
        left = len(list((folder / VERSIONS).iterdir()))
        yield whole_map(folder), left


def whole_map(folder: Path) -> int:
    """Return which of the two maps the library has, every file of it; AssertionError if neither."""
    library = MapLibrary(folder)
    number = DIGESTS.get(map_digest(library.load(NAME)))
    assert number is not None
    kept = {file: library.read(NAME, file) for file in library.about(NAME).files}
    assert kept == files(number)
    by_others = load_map(folder / NAME / "map.yaml")
    assert map_digest(by_others) == map_digest(world(number))
    return number
