"""What the sensors saw, in base_link, ready to weigh a belief."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.scans import bearings_of, scan_points
from pilotage.localizer.landmark_sightings import Sightings


@dataclass(frozen=True)
class Ranges:
    """Single rangers: `bearings` (n,) in base_link, `ranges` (n,) from its origin, infinite = none.

    `range_max` [m] is the farthest an echo can come from.
    """

    bearings: NDArray[np.float64]
    ranges: NDArray[np.float64]
    range_max: float


@dataclass(frozen=True)
class Beams:
    """A laser scan: `bearings` (n,) and `ranges` (n,) from the laser, infinite = nothing came back.

    `base_from_laser` (3,) is the laser's mount, `range_max` [m] how far it sees.
    """

    bearings: NDArray[np.float64]
    ranges: NDArray[np.float64]
    base_from_laser: NDArray[np.float64]
    range_max: float


@dataclass(frozen=True)
class Measurement:
    """What the sensors saw at one moment.

    `beams`: the laser's scan as it was; `ends`: (n, 2) ends of the laser beams that weigh the
    belief, in base_link; `all_ends` (m, 2) of all of them; `compass`: yaw in map and its standard
    deviation [rad]; `landmarks`: sightings from base_link.
    """

    beams: Beams | None = None
    ends: NDArray[np.float64] | None = None
    all_ends: NDArray[np.float64] | None = None
    ranges: Ranges | None = None
    compass: tuple[float, float] | None = None
    landmarks: Sightings | None = None

    def with_compass(self, compass: tuple[float, float] | None) -> "Measurement":
        """Return the same measurement with what the compass said."""
        return replace(self, compass=compass)


def scan_measurement(
    ranges: NDArray[np.float32],
    angles: tuple[float, float],
    base_from_laser: ArrayLike,
    beams: int,
    range_max: float,
) -> Measurement:
    """Return a laser scan (n,) as a measurement: `beams` of it evenly, and all of it.

    Args:
        ranges: infinite where nothing came back.
        angles: of the first beam, and from beam to beam [rad].
        base_from_laser: mount of the laser (3,).
        beams: how many weigh the belief.
        range_max: how far the laser sees [m].
    """
    all_ends = se2.transform_points(base_from_laser, scan_points(ranges, *angles))
    count = min(beams, len(all_ends))
    chosen = np.rint(np.linspace(0, len(all_ends) - 1, count)).astype(np.int64)
    mount = np.asarray(base_from_laser, float)
    scan = Beams(bearings_of(len(ranges), *angles), ranges.astype(float), mount, range_max)
    return Measurement(beams=scan, ends=all_ends[chosen], all_ends=all_ends)


def ranges_measurement(
    ranges: NDArray[np.float32], mounts: NDArray[np.float32], range_max: float
) -> Measurement:
    """Return single rangers (n,) at mounts (n, 3) as a measurement from the robot's centre.

    Each range is lengthened by how far its sensor sits from the centre along its direction; for
    rings that look outward this is exact. A range of `range_max` or more is no echo.
    """
    x, y, directions = mounts.astype(np.float64).T
    ahead = x * np.cos(directions) + y * np.sin(directions)
    heard = np.where(ranges < range_max, ranges, np.inf).astype(np.float64)
    return Measurement(ranges=Ranges(directions, heard + ahead, range_max))


def landmarks_measurement(seen: Sightings, base_from_sensor: ArrayLike) -> Measurement:
    """Return sightings from a sensor's mount (3,) as a measurement."""
    return Measurement(landmarks=seen.from_mount(base_from_sensor))
