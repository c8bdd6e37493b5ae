"""Does laser SLAM stay bounded? Two hours and more in Freiburg's building 079, to and fro.

    .venv/bin/python tests/benchmarks/slam_two_hours.py [LOG] [ROUNDS]

The log is driven forth, then backwards in time, and so on: the robot goes on from where it is, and
places and odometry stay those of the real one. After each round a line says how much memory the
process has, how many keyframes and edges the graph, and what a scan took of processor time: the
median, the worst one, and the mean with the map drawn every second, as the service does it.
"""

import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from pilotage.core.logs import OdometryRecord, Record, ScanRecord, read_log
from pilotage.mapper.laser_slam import LaserSlam
from pilotage.mapper.log_run import LogUse, records_of

REPOSITORY = Path(__file__).resolve().parents[2]
LOG = REPOSITORY.parent / "shared" / "datasets" / "slam" / "fr079.clf.gz"
ROUNDS = 7
MAP_EVERY = 1.0
"""s of the log between two maps."""


def main(arguments: list[str]) -> int:
    """Print the table."""
    log = Path(arguments[0]) if arguments else LOG
    rounds = int(arguments[1]) if len(arguments) > 1 else ROUNDS
    records = records_of(read_log(log), LogUse())
    slam = LaserSlam()
    heads = ("hours", "rss MB", "keyframes", "edges", "closures", "map m2")
    print("".join(f"{head:>10}" for head in (*heads, "p50 ms", "p95 ms", "max ms", "mean ms")))
    began = time.process_time()
    begin = records[0].stamp
    for part in to_and_fro(records, rounds):
        spent = drive(slam, part)
        mean = 1e3 * (time.process_time() - began) / len(spent)
        hours = (part[-1].stamp - begin) / 3600.0
        graph, world = slam.pose_graph(), slam.map()
        floor = world.is_free.sum() * world.geometry.resolution**2
        print(f"{hours:10.2f}{rss_mb():10.0f}{len(graph.poses):10}{len(graph.edges):10}", end="")
        print(f"{graph.is_closure.sum():10}{floor:10.0f}", end="")
        costs = (*np.percentile(spent, [50, 95, 100]), mean)
        print("".join(f"{cost:10.2f}" for cost in costs), flush=True)
        began = time.process_time()
    return 0


def to_and_fro(records: list[Record], rounds: int) -> Iterator[list[Record]]:
    """Yield the records as they are, then backwards from there on, then again."""
    first, last = records[0].stamp, records[-1].stamp
    for number in range(rounds):
        begin = first + number * (last - first)
        if number % 2 == 0:
            part = [replace(r, stamp=begin + (r.stamp - first)) for r in records]
        else:
            part = [replace(r, stamp=begin + (last - r.stamp)) for r in records]
        yield sorted(part, key=lambda r: (r.stamp, not isinstance(r, OdometryRecord)))


def drive(slam: LaserSlam, records: list[Record]) -> list[float]:
    """Feed the records; return the processor time of each scan in ms."""
    spent = []
    due = records[0].stamp
    for record in records:
        began = time.process_time()
        slam.process(record)
        if isinstance(record, ScanRecord):
            spent.append(1e3 * (time.process_time() - began))
        if record.stamp >= due:
            slam.map()
            due += MAP_EVERY
    return spent


def rss_mb() -> float:
    """Memory that the process has now, MB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4096 / 1e6


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
