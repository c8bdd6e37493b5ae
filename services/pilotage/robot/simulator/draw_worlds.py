"""Writes the worlds drawn in code as map_server maps: `python -m ...draw_worlds FOLDER`."""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import yaml
from PIL import Image

from pilotage.core.grid import FREE, OCCUPIED, OccupancyMap
from pilotage.robot.simulator.corridor_plan import corridor_doors, corridor_floor
from pilotage.robot.simulator.floor_plans import office_floor, square_hall
from pilotage.robot.simulator.football_field import football_field, football_landmarks
from pilotage.robot.simulator.office_doors import office_doors

FREE_SHADE, OCCUPIED_SHADE, UNKNOWN_SHADE = 254, 0, 205


def write_map(world: OccupancyMap, image: Path) -> None:
    """Write a map of the values -1, 0 and 100 as an image, by its suffix, and a YAML beside it.

    The office is written as PNG: 6 kB, where the PGM of `save_map` would take 1 MB.
    """
    shades = np.full(world.cells.shape, UNKNOWN_SHADE, np.uint8)
    shades[world.cells == FREE] = FREE_SHADE
    shades[world.cells == OCCUPIED] = OCCUPIED_SHADE
    Image.fromarray(shades[::-1]).save(image, optimize=True)
    description = {
        "image": image.name,
        "mode": "trinary",
        "resolution": world.geometry.resolution,
        "origin": list(world.geometry.origin),
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }
    text = yaml.safe_dump(description, sort_keys=False, default_flow_style=None)
    image.with_suffix(".yaml").write_text(text, encoding="utf-8")


def write_list(name: str, entries: Sequence[Mapping[str, object]], file: Path) -> None:
    """Write a list of landmarks or doors, one a line, as the world files read them."""
    lines = (yaml.safe_dump(e, sort_keys=False, default_flow_style=True, width=99) for e in entries)
    text = "".join(f"  - {line}" for line in lines)
    file.write_text(f"{name}:\n{text}", encoding="utf-8")


def main() -> None:
    """Draw the floors and the field into the folder named on the command line."""
    parser = argparse.ArgumentParser(description="draw the maps that come with Pilotage")
    parser.add_argument("folder", type=Path, help="where the maps go, e.g. deploy/worlds")
    folder: Path = parser.parse_args().folder
    write_map(square_hall(), folder / "hall_map.pgm")
    write_map(office_floor(), folder / "office_map.png")
    write_map(football_field(), folder / "robocup_map.pgm")
    write_list("landmarks", football_landmarks(), folder / "robocup_landmarks.yaml")
    write_list("doors", office_doors(), folder / "office_doors.yaml")
    write_map(corridor_floor(), folder / "corridor_map.png")
    write_list("doors", corridor_doors(), folder / "corridor_doors.yaml")


if __name__ == "__main__":
    main()
