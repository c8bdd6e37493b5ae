"""The benchmark of lines, on a few scans and with a clock that ticks at each look."""

import itertools

import numpy as np
import pytest

from pilotage.bench import line_cases
from pilotage.bench.entry import Stopwatch
from pilotage.bench.line_cases import BEAMS, corridor_scans
from pilotage.robot.simulator.floor_plans import office_floor


def test_the_entry_says_how_many_walls_a_scan_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(line_cases, "SCANS", 4)
    ticks = itertools.count(0.0, 0.001)
    (entry,) = line_cases.line_cases(Stopwatch(lambda: next(ticks)))
    assert (entry.size.kind, entry.size.beams) == ("lines", 361)
    assert entry.size.count > 2
    assert entry.cpu_ms == pytest.approx(0.25)
    assert entry.reference_cpu_ms == pytest.approx(0.25)


def test_the_laser_goes_along_the_corridor_and_errs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(line_cases, "SCANS", 3)
    scans = corridor_scans(office_floor())
    assert [len(scan) for scan in scans] == [BEAMS] * 3
    assert not np.allclose(scans[0], scans[1])
    assert np.isfinite(scans[0]).mean() > 0.5
