"""Whether laser SLAM draws real buildings right, and closes no wrong loop in them.

    .venv/bin/python tests/benchmarks/slam_buildings.py [RUNS] [SCANS] [MAP ...]

For the own office and every map of ../shared/datasets/maps: RUNS simulated tracks of SCANS scans,
0.3 m apart, per case (experiments/clutter says what they are). Printed: error of the trajectory
against the truth after rigid alignment (mean and worst, m; and odometry's), error over steps of
0.9 m, keyframes, closures and how many of them are more than 0.4 m or 0.2 rad off, processor time.
"""

import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.logs import OdometryRecord, ScanRecord
from pilotage.experiments.clutter import CONDITIONS, altered
from pilotage.experiments.tracks import Track, drive_through
from pilotage.mapper.laser_slam import LaserSlam

# tests/ is no package of the installation.
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.building_trials import names_of_maps, world_of
from slam_metrics import alignment

CASES = "clean", "hard", "extreme"
HEADS = "mean m", "max m", "odo m", "step m", "keyframes", "closures", "wrong", "ms/scan"


def main(arguments: list[str]) -> int:
    """Print the table."""
    runs = int(arguments[0]) if arguments else 1
    scans = int(arguments[1]) if len(arguments) > 1 else 600
    print(f"{'map':16}{'case':9}{'run':>4}" + "".join(f"{head:>10}" for head in HEADS))
    for name in arguments[2:] or names_of_maps():
        for case in CASES:
            for seed in range(runs):
                figures = trial(name, case, scans, seed)
                row = "".join(f"{figure:10.3f}" for figure in figures)
                print(f"{name:16}{case:9}{seed:4}{row}", flush=True)
    return 0


def trial(name: str, case: str, scans: int, seed: int) -> tuple[float, ...]:
    """Return the figures of one run."""
    rng = np.random.default_rng(seed)
    walls = altered(world_of(name), CONDITIONS[case], rng)
    track = drive_through(walls, CONDITIONS[case], (scans,), rng)
    began = time.process_time()
    slam = mapped(track)
    spent = 1e3 * (time.process_time() - began) / scans
    _, poses = slam.trajectory()
    graph = slam.pose_graph()
    errors, odometry = off(poses, track.truth), off(track.odometry, track.truth)
    wrong = wrong_closures(slam, track)
    sizes = len(graph.poses), int(graph.is_closure.sum()), wrong
    return errors.mean(), errors.max(), odometry.mean(), step_error(poses, track), *sizes, spent


def mapped(track: Track) -> LaserSlam:
    """Return the map of a track."""
    slam = LaserSlam()
    for record in track.log().records:
        if isinstance(record, ScanRecord) and record.odom_pose is not None:
            slam.process(OdometryRecord(record.stamp, record.odom_pose))
            slam.process(record)
    slam.settle()
    return slam


def off(poses: NDArray[np.float64], truth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distances (n,) of poses (n, 3) from the truth where both fit best."""
    here, there = poses[:, :2], truth[:, :2]
    laid = se2.transform_points(alignment(here, there), here)
    distances: NDArray[np.float64] = np.linalg.norm(laid - there, axis=1)
    return distances


def step_error(poses: NDArray[np.float64], track: Track) -> float:
    """Return the mean error over three scans [m]."""
    step, true = (se2.between(way[:-3], way[3:]) for way in (poses, track.truth))
    error = se2.between(true, step)
    return float(np.hypot(error[:, 0], error[:, 1]).mean())


def wrong_closures(slam: LaserSlam, track: Track) -> int:
    """Return how many closures contradict the truth."""
    graph = slam.pose_graph()
    stamps = np.array([record.stamp for record in track.log().scans])
    truth = track.truth[np.searchsorted(stamps, graph.stamps - 1e-6)]
    edges = graph.edges[graph.is_closure]
    true = se2.between(truth[edges[:, 0]], truth[edges[:, 1]])
    error = se2.between(true, graph.relative[graph.is_closure])
    is_wrong = (np.hypot(error[:, 0], error[:, 1]) > 0.4) | (np.abs(error[:, 2]) > 0.2)
    return int(is_wrong.sum())


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
