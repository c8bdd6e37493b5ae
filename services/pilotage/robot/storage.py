"""Where a simulated robot stands, on disk: the end of this process must not move the robot.

A real robot stays where it is when its driver crashes; without this memory a simulated one would
be carried to its world's start.
"""

from pathlib import Path

from pilotage_schemas.geometry import Pose2

PLACE_FILE = "simulated_robot.json"


def save_place(folder: Path, pose: Pose2) -> None:
    """Write the place so that a crash leaves the old one or the new one; OSError."""
    temporary = folder / f"{PLACE_FILE}.new"
    temporary.write_text(pose.model_dump_json(), encoding="utf-8")
    temporary.replace(folder / PLACE_FILE)


def load_place(folder: Path) -> Pose2 | None:
    """Return the place that was kept, None if there is none or it is damaged."""
    try:
        return Pose2.model_validate_json((folder / PLACE_FILE).read_bytes())
    except (OSError, ValueError):
        return None
