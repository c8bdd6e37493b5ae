"""How far off a reckoned way is, as the thesis counts it (Li 2008, tables 5-1 and 5-3); pure."""

import numpy as np

from pilotage.core.angles import wrap
from pilotage.experiments.sonar_drive import SonarDrive
from pilotage.experiments.wall_segments import Floats


def pose_errors(drive: SonarDrive, reckoned: Floats) -> dict[str, float]:
    """Return the errors of poses (n + 1, 3) against those of a drive, absolute, by name.

    Places and, where nothing turned, the rotation are judged at the end of the way; with turns
    the rotation is the mean of the errors of a left and of a right turn, as in table 5-3.
    """
    off = reckoned[-1] - drive.truth[-1]
    errors = {
        "pose_error_m": float(np.hypot(off[0], off[1])),
        "pose_error_x_m": abs(float(off[0])),
        "pose_error_y_m": abs(float(off[1])),
        "heading_error_rad": abs(wrap(float(off[2]))),
    }
    left, right = turn_errors(drive, reckoned)
    if not len(left) or not len(right):
        return errors | {"rotation_error_rad": errors["heading_error_rad"]}
    sides = {"left": float(left.mean()), "right": float(right.mean())}
    return (
        errors
        | {"rotation_error_rad": (sides["left"] + sides["right"]) / 2.0}
        | {f"{side}_turn_error_rad": error for side, error in sides.items()}
    )


def turn_errors(drive: SonarDrive, reckoned: Floats) -> tuple[Floats, Floats]:
    """Return by how much each left turn and each right turn is off, absolute, rad.

    A turn lasts until the robot goes on; turns without a way between them are one.
    """
    changes = np.flatnonzero(np.diff(drive.is_turning, prepend=False, append=False))
    turns = changes.reshape(-1, 2)
    true = wrap(np.diff(drive.truth[turns, 2], axis=1)[:, 0])
    off = np.abs(wrap(np.diff(reckoned[turns, 2], axis=1)[:, 0] - true))
    return off[true > 0.0], off[true < 0.0]


def distances(drive: SonarDrive, reckoned: Floats) -> Floats:
    """Return how far off the place is at every pose (n + 1,), m."""
    return np.asarray(np.hypot(*(reckoned - drive.truth)[:, :2].T), float)
