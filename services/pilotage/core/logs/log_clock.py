"""The clock of a log that was set back while it was written: it goes on from where it was."""

from collections.abc import Iterable
from dataclasses import replace

from pilotage.core.logs.records import Record

SET_BACK = 5.0
"""s; records of one kind stand in a log in their order, but for less than this."""


def with_one_clock(records: Iterable[Record]) -> list[Record]:
    """Return records, in the order of the file, on one clock that was never set back.

    Were they only sorted, what was measured after the clock was set back would come among what was
    measured before. A log that holds one kind of record after the other is left as it is.
    """
    shift = 0.0
    last: dict[type, float] = {}
    told: list[Record] = []
    for record in records:
        before = last.get(type(record))
        if before is not None and record.stamp + shift < before - SET_BACK:
            shift = max(last.values()) - record.stamp
        shifted = replace(record, stamp=record.stamp + shift) if shift else record
        last[type(record)] = shifted.stamp
        told.append(shifted)
    return told
