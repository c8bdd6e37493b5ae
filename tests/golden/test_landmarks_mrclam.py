"""A real robot among fifteen posts (UTIAS MRCLAM, data set 6), found from an unknown start.

The hall is an empty rectangle: only range and bearing of the posts tell where the robot is. Truth
is Vicon's. The bounds are from runs of November 2026: median errors of 0.07 to 0.18 m, with ranges
that err by 0.08 to 0.18 m (median absolute deviation), and sightings that fail for up to 47 s.
"""

import gzip
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from localizer_world import error
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.core.motion import arc
from pilotage.localizer.landmark_sightings import Sightings
from pilotage.localizer.markov_grid import MotionSpread
from pilotage.localizer.measurement import landmarks_measurement
from pilotage.localizer.particle_evidence import EvidenceParams
from pilotage.localizer.particle_localizer import ParticleLocalizer, ParticleParams
from pilotage.localizer.particle_resampling import KldParams
from pilotage.localizer.particle_search import SearchParams

pytestmark = [pytest.mark.data, pytest.mark.timeout(180)]

SPAN = 300.0
"""Seconds of the run that are used."""

RANGE_SIGMA, RANGE_SHARE, BEARING_SIGMA = 0.15, 0.06, 0.04

PARAMS = ParticleParams(
    search=SearchParams(candidates=50_000, kept=20_000),
    kld=KldParams(least=2_000, most=20_000),
    # Over 20 s this odometry errs by 0.17 rad on 1.2 m and 1.2 rad (root mean square).
    motion=MotionSpread(0.1, 0.02, 0.12, 0.12),
    evidence=EvidenceParams(visibility=None),
)


@dataclass(frozen=True)
class Recording:
    """Times (n,) and poses (n, 3) of odometry, sightings by time, and truth (m, 4)."""

    stamps: NDArray[np.float64]
    odometry: NDArray[np.float64]
    sightings: NDArray[np.float64]
    truth: NDArray[np.float64]


def table(file: Path) -> NDArray[np.float64]:
    content = file.read_bytes()
    text = gzip.decompress(content) if file.suffix == ".gz" else content
    return np.loadtxt(text.decode("utf-8").splitlines())


@cache
def posts(folder: Path, *, named: bool) -> LandmarkMap:
    surveyed = table(folder / "Landmark_Groundtruth.dat")
    names = tuple(str(int(subject)) if named else None for subject in surveyed[:, 0])
    return LandmarkMap(surveyed[:, 1:3], ("post",) * len(surveyed), names)


@cache
def recording(folder: Path, robot: int) -> Recording:
    speeds = table(folder / f"Robot{robot}_Odometry.dat.gz")
    speeds = speeds[speeds[:, 0] < speeds[0, 0] + SPAN]
    poses = [np.zeros(3)]
    for (t0, linear, angular), (t1, _, _) in pairwise(speeds):
        poses.append(arc(poses[-1], linear, angular, t1 - t0))
    subject_of = {int(code): int(subject) for subject, code in table(folder / "Barcodes.dat")}
    seen = table(folder / f"Robot{robot}_Measurement.dat.gz")
    seen[:, 1] = [subject_of.get(int(code), 0) for code in seen[:, 1]]
    # The subjects below 6 are the other robots.
    seen = seen[(seen[:, 1] >= 6) & (seen[:, 0] < speeds[-1, 0])]
    truth = table(folder / f"Robot{robot}_Groundtruth.dat.gz")
    return Recording(speeds[:, 0], np.array(poses), seen, truth)


def hall() -> OccupancyMap:
    cells = np.zeros((260, 160), np.int8)
    cells[[0, -1]], cells[:, [0, -1]] = 100, 100
    return OccupancyMap(GridGeometry(260, 160, 0.05, (-1.5, -6.5, 0.0)), cells)


def sightings(seen: NDArray[np.float64], *, named: bool) -> Sightings:
    return Sightings(
        ranges=seen[:, 2],
        bearings=seen[:, 3],
        range_sigmas=np.hypot(RANGE_SIGMA, RANGE_SHARE * seen[:, 2]),
        bearing_sigmas=np.full(len(seen), BEARING_SIGMA),
        kinds=("post",) * len(seen),
        identities=tuple(str(int(subject)) if named else None for subject in seen[:, 1]),
    )


def run(folder: Path, robot: int, *, named: bool) -> Iterator[tuple[str, float, float]]:
    """The state and the error [m], [rad] at each picture with a post in it."""
    log = recording(folder, robot)
    rng = np.random.default_rng(0)
    localizer = ParticleLocalizer(hall(), PARAMS, rng, landmarks=posts(folder, named=named))
    for stamp in np.unique(log.sightings[:, 0]):
        odom = log.odometry[min(np.searchsorted(log.stamps, stamp), len(log.stamps) - 1)]
        seen = log.sightings[log.sightings[:, 0] == stamp]
        measurement = landmarks_measurement(sightings(seen, named=named), np.zeros(3))
        if localizer.wants(round(stamp * 1e9), odom, measurement):
            localizer.update(round(stamp * 1e9), odom, measurement)
        now = min(np.searchsorted(log.truth[:, 0], stamp), len(log.truth) - 1)
        away, turn = error(localizer.pose_at(odom), log.truth[now, 1:])
        yield localizer.estimate.state, away, turn


@pytest.fixture
def folder(data_dir: Path) -> Path:
    return data_dir / "landmarks" / "mrclam-Dataset6"


@pytest.mark.parametrize("named", [True, False], ids=["each post by name", "all posts alike"])
@pytest.mark.parametrize("robot", [1, 2, 3])
def test_posts_tell_a_robot_where_it_is(folder: Path, robot: int, *, named: bool) -> None:
    told = list(run(folder, robot, named=named))
    localized = [(away, turn) for state, away, turn in told if state == "localized"]
    assert len(localized) >= 0.35 * len(told)
    away, turn = np.array(localized).T
    assert np.median(away) <= 0.2
    assert np.median(turn) <= 0.06
    assert np.mean(away > 1.0) <= 0.001
    state, final, _ = told[-1]
    assert state == "localized"
    assert final <= 0.4
