"""A mapping run: whatever order measurements come in, the method gets them by their stamps."""

import math

import numpy as np
import pytest

from dead_reckoning_mapping import DeadReckoningMapping
from pilotage.core import se2
from pilotage.core.logs import HeadingRecord, OdometryRecord, ScanRecord
from pilotage.core.odometry_watch import OdometrySample
from pilotage.mapper.mapping_session import MOST_WAITING, PATIENCE_NS, LateError, MappingSession

MS = 1_000_000
BEGIN = 1_000_000 * MS


def sample(ms: int, x: float = 0.0, seq: int | None = None, theta: float = 0.0) -> OdometrySample:
    return OdometrySample(ms if seq is None else seq, BEGIN + ms * MS, np.array([x, 0.0, theta]))


def scan(ms: int) -> ScanRecord:
    ranges = np.full(90, 2.0, np.float32)
    return ScanRecord(
        stamp=(BEGIN + ms * MS) / 1e9,
        ranges=ranges,
        angle_min=-math.pi,
        angle_increment=math.tau / 90,
        range_max=8.0,
        odom_pose=None,
        laser_mount=(0.1, 0.0, 0.0),
    )


class Run:
    """A session over dead reckoning, fed by hand."""

    def __init__(self) -> None:
        self.method = DeadReckoningMapping()
        self.session = MappingSession(self.method)

    def odometry(self, *samples: OdometrySample) -> str | None:
        said = [self.session.take_odometry(one) for one in samples]
        return said[-1]

    def scan(self, ms: int, source: str = "scan laser") -> None:
        self.session.take(source, BEGIN + ms * MS, scan(ms))

    def order(self) -> list[tuple[str, int]]:
        """What the method got: the kind and the stamp in ms."""
        return [
            (type(one).__name__.removesuffix("Record"), round(one.stamp * 1e3 - BEGIN / MS))
            for one in self.method.records
        ]

    def drive(self, from_ms: int, to_ms: int, speed: float = 0.5) -> None:
        """Odometry every 50 ms and a scan every 100 ms that comes 30 ms late."""
        for ms in range(from_ms, to_ms, 50):
            self.odometry(sample(ms, x=speed * ms / 1e3))
            if ms % 100 == 50:
                self.scan(ms - 30)


@pytest.fixture
def run() -> Run:
    return Run()


def test_a_scan_that_comes_after_later_odometry_is_taken_in_its_place(run: Run) -> None:
    run.odometry(sample(0), sample(50), sample(100))
    run.scan(70)
    run.odometry(sample(150), sample(200))
    assert run.order() == [("Odometry", 0), ("Odometry", 50), ("Scan", 70), ("Odometry", 100)]


def test_a_scan_is_told_where_odometry_was_just_then(run: Run) -> None:
    run.odometry(sample(0, x=0.0), sample(100, x=0.4))
    run.scan(25)
    run.odometry(sample(200, x=0.8))
    (seen,) = [one for one in run.method.records if isinstance(one, ScanRecord)]
    assert seen.odom_pose == pytest.approx((0.1, 0.0, 0.0))
    assert seen.laser_mount == (0.1, 0.0, 0.0)


def test_a_scan_from_before_the_first_odometry_is_left_out(run: Run) -> None:
    run.scan(0)
    run.odometry(sample(50), sample(200))
    assert run.order() == [("Odometry", 50)]


def test_a_scan_that_comes_too_late_is_refused(run: Run) -> None:
    run.odometry(*(sample(ms) for ms in range(0, 500, 50)))
    with pytest.raises(LateError, match=r"measured 0\.250 s before what is in the map"):
        run.scan(100)


def test_two_scans_with_the_same_stamp_are_one(run: Run) -> None:
    run.odometry(sample(0))
    run.scan(20)
    with pytest.raises(LateError, match="no later than the one before"):
        run.scan(20)
    run.scan(20, source="scan laser_behind")
    run.odometry(sample(150))
    assert run.order() == [("Odometry", 0), ("Scan", 20), ("Scan", 20)]


def test_odometry_that_is_repeated_is_left_out(run: Run) -> None:
    run.odometry(sample(0), sample(50), sample(50), sample(200))
    assert run.order() == [("Odometry", 0), ("Odometry", 50)]


def test_without_odometry_no_more_than_a_bounded_number_waits(run: Run) -> None:
    for ms in range(2 * MOST_WAITING):
        run.scan(ms)
    assert len(run.session._waiting) == MOST_WAITING


def test_headings_are_put_in_their_places_too(run: Run) -> None:
    run.odometry(sample(0))
    run.session.take("heading", BEGIN + 30 * MS, HeadingRecord((BEGIN + 30 * MS) / 1e9, 0.1, 0.02))
    run.odometry(sample(50), sample(200))
    assert run.order() == [("Odometry", 0), ("Heading", 30), ("Odometry", 50)]


def test_at_the_end_the_method_gets_what_waited(run: Run) -> None:
    run.odometry(sample(0), sample(50))
    run.scan(40)
    run.session.finish()
    assert run.order() == [("Odometry", 0), ("Scan", 40), ("Odometry", 50)]
    assert run.session.steps == 1


def test_nobody_knows_the_pose_before_the_first_odometry(run: Run) -> None:
    assert run.session.pose() is None
    assert run.session.covariance() is None
    run.session.finish()


def test_the_pose_does_not_wait_for_late_measurements(run: Run) -> None:
    run.drive(0, 1000)
    pose = run.session.pose()
    assert pose == pytest.approx([0.475, 0.0, 0.0])


def test_the_covariance_grows_with_the_way_since_the_last_scan(run: Run) -> None:
    run.drive(0, 1000)
    before = run.session.covariance()
    assert before is not None
    run.odometry(sample(1500, x=2.5))
    after = run.session.covariance()
    assert after is not None
    assert np.all(np.diag(after) > np.diag(before))
    assert np.sqrt(after[0, 0]) < 0.5


class TestOdometryThatBeginsAnew:
    def test_is_told_and_never_jumps_for_the_method(self, run: Run) -> None:
        run.drive(0, 1000)
        said = run.odometry(sample(1000, x=-7.0, seq=0, theta=2.0))
        assert said is not None
        assert "counting anew" in said
        assert run.session.pose() == pytest.approx([0.475, 0.0, 0.0])
        ahead = np.array([-7.0 + 0.1 * math.cos(2.0), 0.1 * math.sin(2.0), 2.0])
        run.odometry(OdometrySample(1, BEGIN + 1050 * MS, ahead))
        assert run.session.pose() == pytest.approx([0.575, 0.0, 0.0])
        run.session.finish()
        poses = [one.pose for one in run.method.records if isinstance(one, OdometryRecord)]
        assert np.abs(np.diff(np.array(poses)[:-1, 0])).max() < 0.1

    def test_takes_with_it_the_scans_that_waited_for_the_old_one(self, run: Run) -> None:
        run.odometry(sample(0), sample(50))
        run.scan(90)
        run.odometry(sample(100, x=9.0, seq=0), sample(300, x=9.0, seq=1))
        assert "Scan" not in [kind for kind, _ in run.order()]

    def test_may_bring_a_clock_that_was_set_back(self, run: Run) -> None:
        run.drive(5000, 6000)
        run.odometry(sample(100, seq=0))
        run.scan(120)
        run.odometry(sample(150, seq=1), sample(300, seq=2))
        assert run.order()[-2:] == [("Scan", 120), ("Odometry", 150)]


def test_mapping_goes_on_from_where_the_robot_is_found_again(run: Run) -> None:
    run.drive(0, 1000)
    there = np.array([3.0, 1.0, math.pi / 2])
    run.odometry(sample(9000, x=4.0, seq=9000))
    run.session.go_on_at(there)
    assert run.session.pose() == pytest.approx(there)
    run.odometry(sample(9050, x=4.1))
    assert run.session.pose() == pytest.approx(se2.compose(there, [0.1, 0.0, 0.0]))


def test_nobody_can_go_on_without_odometry(run: Run) -> None:
    with pytest.raises(ValueError, match="no odometry yet"):
        run.session.go_on_at(np.zeros(3))


class TestAfterACrash:
    def test_the_session_goes_on_where_it_was(self, run: Run) -> None:
        run.odometry(sample(0, x=2.0))
        run.drive(50, 2000)
        other = Run()
        other.session.resume(run.session.remember())
        assert other.session.steps == run.session.steps
        assert other.session.pose() == pytest.approx(run.session.pose())
        assert other.session.covariance() == pytest.approx(run.session.covariance())
        assert np.array_equal(other.method.map().cells, run.method.map().cells)
        assert other.odometry(sample(4000, x=2.0)) is None
        other.scan(4010)
        other.odometry(sample(4050, x=2.0), sample(4200, x=2.0))
        assert other.session.steps == run.session.steps + 1

    def test_a_robot_that_began_anew_meanwhile_is_noticed(self, run: Run) -> None:
        run.drive(0, 2000)
        other = Run()
        other.session.resume(run.session.remember())
        said = other.odometry(sample(3000, x=0.0, seq=3))
        assert said is not None
        assert other.session.pose() == pytest.approx(run.session.pose())

    def test_what_was_in_the_map_is_not_mapped_twice(self, run: Run) -> None:
        run.drive(0, 2000)
        other = Run()
        other.session.resume(run.session.remember())
        with pytest.raises(LateError):
            other.scan(1000)

    def test_a_session_that_had_seen_nothing_goes_on_too(self, run: Run) -> None:
        other = Run()
        other.session.resume(run.session.remember())
        assert other.session.pose() is None

    @pytest.mark.parametrize(
        "name", ["session.counts", "session.joined_from_odom", "method.origin"]
    )
    def test_a_memory_that_does_not_fit_is_refused(self, run: Run, name: str) -> None:
        run.drive(0, 500)
        memory = run.session.remember()
        del memory[name]
        with pytest.raises(ValueError, match=r"does not fit|no origin"):
            Run().session.resume(memory)


def test_patience_is_shorter_than_a_person_notices() -> None:
    assert PATIENCE_NS <= 200 * MS
