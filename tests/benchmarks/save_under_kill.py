"""Kills a process that saves maps, at random moments: is it always the old map or the new one?

    python tests/benchmarks/save_under_kill.py [TRIES]

Run with services, schemas and tests on PYTHONPATH. Prints how often which map was found.
"""

import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

from killed_saves import killed_saves

TRIES = 100


def main() -> None:
    """Kill and count."""
    tries = int(sys.argv[1]) if len(sys.argv) > 1 else TRIES
    found: Counter[int] = Counter()
    cut_short = 0
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        for number, left in killed_saves(Path(folder), tries, np.random.default_rng(1)):
            found[number] += 1
            cut_short += left > 1
    print(f"{tries} kills in {time.monotonic() - began:.0f} s, {cut_short} of them during a save")
    print(f"whole map found: {sum(found.values())} of {tries} times {dict(sorted(found.items()))}")


if __name__ == "__main__":
    main()
