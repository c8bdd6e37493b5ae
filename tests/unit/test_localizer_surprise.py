"""A localized robot notices at once that it was carried off."""

from dataclasses import replace

import numpy as np

from pilotage.localizer.surprise import WORSE, ScanFit


def test_nothing_surprises_before_anything_is_usual() -> None:
    assert not ScanFit().is_surprising(0.0)


def test_a_scan_that_fits_much_worse_than_usual_is_surprising() -> None:
    fit = ScanFit()
    fit.learn(0.9)
    assert fit.is_surprising(0.99 * WORSE * 0.9)
    assert not fit.is_surprising(1.01 * WORSE * 0.9)


def test_what_is_usual_follows_a_crowd_that_comes_slowly() -> None:
    fit = ScanFit()
    for share in np.linspace(1.0, 0.4, 60):
        assert not fit.is_surprising(float(share))
        fit.learn(float(share))
    assert fit.usual is not None
    assert fit.usual < 0.6


def test_a_lost_robot_knows_no_usual() -> None:
    fit = replace(ScanFit(), usual=0.9)
    fit.forget()
    assert fit.usual is None
