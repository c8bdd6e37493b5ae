"""A process that saves one of two maps under one name, over and over, until it is killed.

python saving_forever.py FOLDER
"""

import itertools
import sys
from pathlib import Path

import numpy as np

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.map_files import map_documents
from pilotage.mapper.map_library import MapLibrary

NAME = "office"
SIDE = 400


def world(number: int) -> OccupancyMap:
    """Return one of the two maps: of different sizes, free, with walls of its own."""
    rows, cols = SIDE + 50 * number, SIDE
    cells = np.zeros((rows, cols), np.int8)
    cells[:: 7 + number] = 100
    return OccupancyMap(GridGeometry(rows, cols, 0.05), cells)


def files(number: int) -> dict[str, bytes]:
    """Return the files of a map; all of them say which one it is."""
    way = f"{number} 0 0 0 0 0 0 1\n".encode() * 20_000
    return {**map_documents(world(number), "map.yaml"), "trajectory.tum": way}


def main() -> None:
    """Save for ever."""
    library = MapLibrary(Path(sys.argv[1]))
    both = [files(number) for number in (0, 1)]
    sys.stdout.write("begun\n")
    sys.stdout.flush()
    for turn in itertools.count():
        library.save(NAME, both[turn % 2], turn)


if __name__ == "__main__":
    main()
