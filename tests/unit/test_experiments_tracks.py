"""Simulated tracks: where the robot goes, what it counts, and the log they become."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from localizer_world import COARSE, error, flat
from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.logs import ScanRecord, TruthRecord
from pilotage.experiments.clutter import CONDITIONS, Condition
from pilotage.experiments.tracks import BODY, PERIOD, SHARPEST_TURN, STRIDE, Track, drive_through
from pilotage.localizer.log_run import LogSensors, localize_log
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.robot.simulator.range_sensors import LaserParams
from pilotage.robot.simulator.walls import Walls

WORLD = flat()
WALLS = Walls.of(WORLD)
EXACT = Condition(
    odometry=0.0,
    laser=LaserParams(beams=90, sigma=0.0, share_without_return=0.0, share_too_short=0.0),
)


def track(condition: Condition = EXACT, lengths: tuple[int, ...] = (60,), seed: int = 1) -> Track:
    return drive_through(WALLS, condition, lengths, np.random.default_rng(seed))


def steps(poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """The motions (n - 1, 3) from pose to pose, each as seen from the one before."""
    return se2.between(poses[:-1], poses[1:])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_robot_keeps_clear_of_walls(seed: int) -> None:
    clear = [WALLS.nearest(x, y, 1.0)[0] for x, y, _ in track(seed=seed).truth]
    assert min(clear) >= 0.5 * BODY
    assert np.mean(np.array(clear) >= BODY) > 0.9


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_steps_and_turns_are_no_larger_than_said(seed: int) -> None:
    moved = steps(track(seed=seed).truth)
    assert np.hypot(*moved[:, :2].T).max() <= STRIDE + 1e-9
    assert np.abs(moved[:, 2]).max() <= SHARPEST_TURN + 1e-9


def test_the_robot_gets_about() -> None:
    truth = track(lengths=(120,)).truth
    assert np.ptp(truth[:, 0]) > 3.0
    assert np.hypot(*steps(truth)[:, :2].T).sum() > 10.0


def test_a_track_has_as_many_scans_as_its_parts() -> None:
    run = track(lengths=(20, 15))
    assert run.truth.shape == run.odometry.shape == (35, 3)
    assert run.ranges.shape == (35, 90)


def test_odometry_without_noise_counts_the_way_from_its_own_origin() -> None:
    run = track()
    assert run.odometry[0] == pytest.approx(np.zeros(3))
    expected = se2.between(run.truth[0], run.truth)
    assert run.odometry[:, :2] == pytest.approx(expected[:, :2], abs=1e-6)
    assert np.abs(wrap(run.odometry[:, 2] - expected[:, 2])).max() < 1e-6


def test_odometry_errs_in_proportion_to_its_factor() -> None:
    def spread(factor: float) -> float:
        run = track(replace(EXACT, odometry=factor), (400,))
        return float(np.std((steps(run.odometry) - steps(run.truth))[:, 0]))

    assert spread(3.0) == pytest.approx(3.0 * spread(1.0), rel=0.15)
    assert spread(1.0) > 0.0


def test_odometry_does_not_notice_a_kidnapping() -> None:
    run = track(lengths=(20, 20), seed=4)
    assert run.kidnapped == 20
    away, counted = steps(run.truth)[19], steps(run.odometry)[19]
    assert np.hypot(away[0], away[1]) > 1.0
    assert counted == pytest.approx(np.zeros(3), abs=1e-9)


def test_a_track_in_one_part_is_no_kidnapping() -> None:
    assert track().kidnapped is None


def test_a_scan_shows_what_stands_about_the_robot() -> None:
    run = track()
    laser = EXACT.laser
    for pose, ranges in list(zip(run.truth, run.ranges, strict=True))[::10]:
        at = se2.compose(pose, [laser.mount_x, 0.0, 0.0])
        expected = WALLS.ranges(at, laser.bearings, laser.range_max)
        assert ranges == pytest.approx(expected, abs=1e-4)


def test_the_given_share_of_beams_measures_anything() -> None:
    clean, noisy = track(), track(replace(EXACT, outliers=0.2))
    laser = EXACT.laser
    off = 0
    for pose, ranges in zip(noisy.truth, noisy.ranges, strict=True):
        at = se2.compose(pose, [laser.mount_x, 0.0, 0.0])
        expected = WALLS.ranges(at, laser.bearings, laser.range_max)
        off += int(np.count_nonzero(np.abs(ranges - expected) > 1e-3))
    assert off / noisy.ranges.size == pytest.approx(0.2, abs=0.02)
    assert np.isfinite(clean.ranges).all()


def test_people_stand_in_the_way_and_walk() -> None:
    empty, crowded = track(), track(replace(EXACT, people=8))
    assert np.median(crowded.ranges) < np.median(empty.ranges)


def test_the_same_seed_is_the_same_track() -> None:
    one, again, other = (track(CONDITIONS["hard"], (12,), seed) for seed in (5, 5, 6))
    assert (one.truth == again.truth).all()
    assert (one.ranges == again.ranges).all()
    assert (one.odometry == again.odometry).all()
    assert (one.truth != other.truth).any()


def test_the_log_tells_truth_odometry_and_scans_in_order() -> None:
    run = track(lengths=(6,))
    records = run.log().records
    assert [type(record) for record in records] == [TruthRecord, ScanRecord] * 6
    stamps = [record.stamp for record in records[::2]]
    assert np.diff(stamps) == pytest.approx(PERIOD)
    scan = records[5]
    assert isinstance(scan, ScanRecord)
    assert scan.odom_pose == pytest.approx(run.odometry[2])
    assert (scan.ranges == run.ranges[2]).all()
    bearings = scan.angle_min + scan.angle_increment * np.arange(90)
    assert bearings == pytest.approx(EXACT.laser.bearings)
    assert scan.laser_mount == (EXACT.laser.mount_x, 0.0, 0.0)
    assert scan.range_max == EXACT.laser.range_max


def test_the_log_can_be_localized() -> None:
    run = track(lengths=(25,))
    estimates = list(localize_log(run.log(), MarkovLocalizer(WORLD, COARSE), LogSensors()))
    assert len(estimates) == 25
    assert estimates[-1].estimate.state == "localized"
    assert error(estimates[-1].pose, run.truth[-1])[0] < 0.1
