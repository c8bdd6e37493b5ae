"""Laws of upright edges: light moves none, a mirror turns them round, a lens scales them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pilotage.robot.pinhole import PinholeCamera
from pilotage.robot.vertical_edges import vertical_edges

Picture = NDArray[np.uint8]
CAMERA = PinholeCamera(250.0)


@st.composite
def pictures(draw: st.DrawFn) -> Picture:
    """Upright bands at least eight pixels wide, of shades from 80 to 160, at least 15 apart."""
    widths = draw(st.lists(st.integers(8, 60), min_size=2, max_size=8))
    shades = [draw(st.integers(80, 160))]
    for _ in widths[1:]:
        step = draw(st.integers(15, 40)) * draw(st.sampled_from([-1, 1]))
        shades.append(shades[-1] + step if 80 <= shades[-1] + step <= 160 else shades[-1] - step)
    row = np.repeat(np.clip(shades, 60, 180), widths).astype(np.uint8)
    return np.tile(row, (draw(st.integers(20, 90)), 1))


@given(pictures())
@settings(deadline=None, max_examples=60)
def test_every_border_of_broad_bands_is_an_edge_and_nothing_else(picture: Picture) -> None:
    steps = np.flatnonzero(np.diff(picture[0].astype(int)))
    inner = steps[(steps > 3) & (steps < picture.shape[1] - 5)]
    middle = (picture.shape[1] - 1) / 2.0
    found = vertical_edges(picture, CAMERA)
    expected = np.arctan((middle - inner - 0.5) / CAMERA.focal)
    assert found.bearings == pytest.approx(expected, abs=0.15 / CAMERA.focal)


@given(pictures())
@settings(deadline=None, max_examples=40)
def test_in_a_mirror_left_is_right_and_rising_is_falling(picture: Picture) -> None:
    here = vertical_edges(picture, CAMERA)
    there = vertical_edges(np.ascontiguousarray(picture[:, ::-1]), CAMERA)
    assert there.bearings == pytest.approx(-here.bearings[::-1], abs=1e-4)
    assert there.strengths == pytest.approx(-here.strengths[::-1])


@given(pictures(), st.floats(0.3, 1.4), st.floats(-10.0, 20.0))
@settings(deadline=None, max_examples=40)
def test_exposure_moves_no_edge(picture: Picture, gain: float, offset: float) -> None:
    exposed = np.clip(gain * picture + offset, 0.0, 255.0).astype(np.uint8)
    here, there = vertical_edges(picture, CAMERA), vertical_edges(exposed, CAMERA)
    assert there.bearings == pytest.approx(here.bearings, abs=0.3 / CAMERA.focal)


@given(pictures(), st.floats(100.0, 2000.0))
@settings(deadline=None, max_examples=40)
def test_a_longer_lens_makes_bearings_smaller_in_proportion(picture: Picture, focal: float) -> None:
    here, there = vertical_edges(picture, CAMERA), vertical_edges(picture, PinholeCamera(focal))
    scale = CAMERA.focal / focal
    assert np.tan(there.bearings) == pytest.approx(scale * np.tan(here.bearings), abs=1e-9)


@given(st.integers(3, 60), st.integers(3, 60), st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=60)
def test_any_picture_has_finite_bearings_in_order(height: int, width: int, seed: int) -> None:
    picture = np.random.default_rng(seed).integers(0, 256, (height, width), dtype=np.uint8)
    found = vertical_edges(picture, CAMERA)
    assert np.isfinite(found.bearings).all()
    assert (np.diff(found.bearings) <= 0.0).all()
    assert len(found.bearings) == len(found.strengths)
