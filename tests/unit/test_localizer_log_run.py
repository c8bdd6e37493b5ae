"""The localizer over a log, record by record."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from localizer_world import (
    ANGLE_MIN,
    ANGLE_STEP,
    COARSE,
    RANGE_MAX,
    ROUND,
    START,
    error,
    flat,
    poses_along,
    scan_at,
)
from pilotage.core import se2
from pilotage.core.logs import HeadingRecord, Log, OdometryRecord, Record, ScanRecord
from pilotage.localizer.log_run import LogEstimate, LogSensors, localize_log
from pilotage.localizer.markov_localizer import MarkovLocalizer

WORLD = flat()
TRUTH = list(poses_along(START, ROUND))


def odom_of(pose: np.ndarray) -> tuple[float, float, float]:
    x, y, theta = (float(value) for value in se2.between(START, pose))
    return x, y, theta


def scan(stamp: float, pose: np.ndarray, *, says_where: bool = False) -> ScanRecord:
    return ScanRecord(
        stamp=stamp,
        ranges=scan_at(WORLD, pose),
        angle_min=ANGLE_MIN,
        angle_increment=ANGLE_STEP,
        range_max=RANGE_MAX,
        odom_pose=odom_of(pose) if says_where else None,
        laser_mount=(0.0, 0.0, 0.0),
    )


def odometry(stamp: float, pose: np.ndarray) -> OdometryRecord:
    return OdometryRecord(stamp, odom_of(pose))


def driven() -> list[Record]:
    """Odometry and a scan every second, at the same moment."""
    records: list[Record] = []
    for second, pose in enumerate(TRUTH):
        records += [odometry(float(second), pose), scan(float(second), pose)]
    return records


def run(records: list[Record], use: LogSensors | None = None) -> list[LogEstimate]:
    localizer = MarkovLocalizer(WORLD, COARSE)
    return list(localize_log(Log("made", tuple(records), 0), localizer, use or LogSensors()))


def is_right(estimate: LogEstimate, pose: np.ndarray) -> bool:
    away, turn = error(estimate.pose, pose)
    return away < 0.1 and turn < 0.05


def test_each_scan_has_its_estimate_and_the_last_is_right() -> None:
    estimates = run(driven())
    assert [e.stamp for e in estimates] == [float(k) for k in range(len(TRUTH))]
    assert all(e.updated for e in estimates)
    assert estimates[-1].estimate.state == "localized"
    assert is_right(estimates[-1], TRUTH[-1])


def test_the_order_of_records_at_one_moment_does_not_matter() -> None:
    records = driven()
    swapped = [record for pair in zip(records[1::2], records[::2], strict=True) for record in pair]
    poses = [np.array([e.pose for e in run(order)]) for order in (records, swapped)]
    assert np.array_equal(poses[0], poses[1])


def test_a_scan_that_says_where_it_was_taken_needs_no_odometry() -> None:
    records: list[Record] = [scan(float(k), pose, says_where=True) for k, pose in enumerate(TRUTH)]
    assert is_right(run(records)[-1], TRUTH[-1])


def test_scans_repeated_at_once_move_the_pose_but_weigh_once() -> None:
    records = driven()
    again = replace(records[-1], stamp=records[-1].stamp + 0.001)
    estimates = run([*records, again])
    assert not estimates[-1].updated
    assert is_right(estimates[-1], TRUTH[-1])


def test_scans_off_for_a_while_leave_the_pose_to_odometry() -> None:
    records = driven()
    quiet = [r for r in records if isinstance(r, OdometryRecord) or not 8.0 <= r.stamp < 14.0]
    estimates = run(quiet)
    assert len(estimates) == len(TRUTH) - 6
    assert all(is_right(e, TRUTH[int(e.stamp)]) for e in estimates if e.stamp >= 8.0)


def test_single_scans_of_rubbish_do_not_carry_the_pose_away() -> None:
    """A spiked scan may cost the verdict a moment, never the place."""
    rubbish = np.random.default_rng(3).uniform(0.3, 2.0, 90).astype(np.float32)
    spiked: list[Record] = [
        replace(r, ranges=rubbish) if isinstance(r, ScanRecord) and r.stamp in {9.0, 13.0} else r
        for r in driven()
    ]
    estimates = run(spiked)
    assert is_right(estimates[-1], TRUTH[-1])
    for e in estimates:
        assert e.estimate.state != "localized" or error(e.pose, TRUTH[int(e.stamp)])[0] < 0.5


def test_scans_that_come_late_are_weighed_where_they_were_taken() -> None:
    """Odometry between two records is interpolated at the scan's own time."""
    records: list[Record] = []
    middles = [se2.interpolate(pose, after, 0.5) for pose, after in pairwise(TRUTH)]
    for second, (pose, middle) in enumerate(zip(TRUTH, middles, strict=False)):
        records += [odometry(float(second), pose), scan(second + 0.5, middle)]
    *_, last = run(records)
    assert error(last.pose, middles[-1])[0] < 0.15


def test_the_compass_is_used_unless_it_is_left_out() -> None:
    pose = TRUTH[0]
    records: list[Record] = [
        odometry(0.0, pose),
        HeadingRecord(0.0, float(pose[2]), 0.1),
        replace(scan(0.0, pose), ranges=np.full(90, np.inf, np.float32)),
    ]
    entropies = []
    for use in (LogSensors(compass=True), LogSensors(compass=False)):
        localizer = MarkovLocalizer(WORLD, COARSE)
        list(localize_log(Log("made", tuple(records), 0), localizer, use))
        entropies.append(localizer.grid.entropy())
    assert entropies[0] < entropies[1] - 1.0


@pytest.mark.parametrize("sensor", ["laser", "sonar"])
def test_a_log_without_the_sensor_has_no_estimates(sensor: str) -> None:
    records: list[Record] = [odometry(float(k), pose) for k, pose in enumerate(TRUTH)]
    assert run(records, LogSensors(sensor=sensor)) == []
