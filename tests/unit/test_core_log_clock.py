"""Logs whose clock was set back."""

import pytest

from pilotage.core.logs import HeadingRecord, OdometryRecord, Record
from pilotage.core.logs.log_clock import with_one_clock


def odometry(*stamps: float) -> list[Record]:
    return [OdometryRecord(stamp, (stamp, 0.0, 0.0)) for stamp in stamps]


def stamps_of(records: list[Record]) -> list[float]:
    return [record.stamp for record in records]


def test_a_log_in_order_stays_as_it_is() -> None:
    records = odometry(1.0, 2.0, 3.0)
    assert with_one_clock(records) == records


def test_a_little_disorder_is_left_to_sorting() -> None:
    records = odometry(1.0, 3.0, 2.0, 4.0)
    assert with_one_clock(records) == records


def test_a_clock_that_was_set_back_goes_on() -> None:
    told = stamps_of(with_one_clock(odometry(100.0, 101.0, 1.0, 2.0, 3.5)))
    assert told == pytest.approx([100.0, 101.0, 101.0, 102.0, 103.5])


def test_it_may_be_set_back_twice() -> None:
    told = stamps_of(with_one_clock(odometry(100.0, 50.0, 51.0, 10.0, 12.0)))
    assert told == pytest.approx([100.0, 100.0, 101.0, 101.0, 103.0])


def test_other_records_are_set_with_it() -> None:
    records = [*odometry(100.0), *odometry(1.0), HeadingRecord(1.5, 0.0, 0.1)]
    assert stamps_of(with_one_clock(records)) == pytest.approx([100.0, 100.0, 100.5])


def test_one_kind_of_record_after_the_other_is_no_clock_set_back() -> None:
    headings: list[Record] = [HeadingRecord(stamp, 0.0, 0.1) for stamp in (1.0, 2.0)]
    records = [*odometry(1.0, 50.0, 100.0), *headings]
    assert with_one_clock(records) == records


def test_nothing_is_nothing() -> None:
    assert with_one_clock([]) == []
