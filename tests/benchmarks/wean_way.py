"""Which way the robot took through Wean Hall: of all that odometry allows, the one that fits best.

    .venv/bin/python tests/benchmarks/wean_way.py robotdata1 robotdata3

Places all over the map are followed from 0.3 of a log forwards to its end and backwards to its
beginning, refined on every fourth scan; printed are the best ways, apart from each other, with
the sum of the mean evidence of a beam [nat] over all scans, and where they begin and end.
Waypoints of the best are printed for tests/golden/test_localize_wean.py.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import Log, read_log
from pilotage.core.map_files import load_map
from pilotage.localizer.evidence import chosen_beams, weigh
from pilotage.localizer.measurement import Beams, scan_measurement
from pilotage.localizer.modes import is_within
from pilotage.localizer.obstacles import Obstacles, obstacles

HALL = Path(__file__).resolve().parents[3] / "shared" / "datasets" / "wean_hall"
RANGE_MAX = 25.0
EVERY, MIDDLE = 4, 0.3
"""Every fourth scan; where in the log the places are sought."""

HEADINGS, BEST_OF_HEADING, CANDIDATES, LEFT = 72, 400, 6000, 500
"""Headings tried; places kept of each, in all, and after TRIED scans."""

TRIED, SHOWN, WAYPOINTS = 20, 6, 12
WORST = -0.5
"""Evidence of a beam [nat] below which a scan counts no worse: a crowd may hide everything."""

Array = NDArray[np.float64]


def seen_in(log: Log) -> tuple[list[Beams], Array, Array]:
    """Return the scans, their times [s] and where odometry puts them (n, 3)."""
    stamps = np.array([record.stamp for record in log.odometry])
    poses = np.array([record.pose for record in log.odometry])
    poses[:, 2] = np.unwrap(poses[:, 2])
    beams, times, odometry = [], [], []
    for scan in log.scans[::EVERY]:
        angles = scan.angle_min, scan.angle_increment
        measured = scan_measurement(scan.ranges, angles, scan.laser_mount, 60, RANGE_MAX).beams
        assert measured is not None
        beams.append(measured)
        times.append(scan.stamp - log.scans[0].stamp)
        odometry.append([np.interp(scan.stamp, stamps, poses[:, k]) for k in range(3)])
    return beams, np.array(times), np.array(odometry)


def fitted(poses: Array, scan: Beams, around: Obstacles) -> tuple[Array, Array]:
    """Return poses (n, 3) refined on a scan and how well it fits (n,)."""
    weighed = weigh(poses, scan, np.ones(len(chosen_beams(scan).ranges)), around)
    return weighed.poses, np.maximum(weighed.fit, WORST)


def candidates(world: OccupancyMap, scan: Beams, around: Obstacles) -> Array:
    """Return the places (n, 3) anywhere on the map that fit a scan best."""
    cells = world.geometry.centres_of(np.argwhere(world.is_free)[::9])
    found, fits = [], []
    for heading in np.arange(HEADINGS) * 2.0 * np.pi / HEADINGS:
        poses, fit = fitted(np.column_stack([cells, np.full(len(cells), heading)]), scan, around)
        best = np.argsort(-fit)[:BEST_OF_HEADING]
        found.append(poses[best])
        fits.append(fit[best])
    order = np.argsort(-np.concatenate(fits))[:CANDIDATES]
    chosen: Array = np.concatenate(found)[order]
    return chosen


def followed(
    poses: Array, scans: list[Beams], odometry: Array, order: range, around: Obstacles
) -> tuple[list[Array], Array]:
    """Return places (n, 3) at each scan in `order`, and the sum of their fits (n,)."""
    total, last, steps = np.zeros(len(poses)), order[0], []
    for index in order:
        poses = se2.compose(poses, se2.between(odometry[last], odometry[index]))
        poses, fit = fitted(poses, scans[index], around)
        total, last = total + fit, index
        steps.append(poses)
    return steps, total


def ways(world: OccupancyMap, log: Log) -> None:
    """Print the ways through a log that fit best."""
    around = obstacles(world)
    scans, times, odometry = seen_in(log)
    middle = int(MIDDLE * len(scans))
    places = candidates(world, scans[middle], around)
    _, tried = followed(places, scans, odometry, range(middle, middle + TRIED), around)
    places = places[np.argsort(-tried)[:LEFT]]
    on, fit_on = followed(places, scans, odometry, range(middle, len(scans)), around)
    back, fit_back = followed(places, scans, odometry, range(middle, -1, -1), around)
    total = fit_on + fit_back
    left = np.ones(len(places), bool)
    for count in range(SHOWN):
        best = int(np.argmax(np.where(left, total, -np.inf)))
        left &= ~is_within(places, places[best], scale=2.0)
        way = np.array([step[best] for step in back[::-1] + on[1:]])
        ends = f"from {way[0].round(2).tolist()} to {way[-1].round(2).tolist()}"
        print(f"{total[best]:6.1f}  {ends}")
        if count == 0:
            for index in range(0, len(way), len(way) // WAYPOINTS):
                print("        ", round(float(times[index]), 1), way[index].round(1).tolist())


def main() -> None:
    """Find the ways through the logs named on the command line."""
    world = load_map(HALL / "wean.dat.gz")
    for name in sys.argv[1:] or ["robotdata1", "robotdata3"]:
        print(name)
        ways(world, read_log(HALL / f"{name}.log.gz"))


if __name__ == "__main__":
    main()
