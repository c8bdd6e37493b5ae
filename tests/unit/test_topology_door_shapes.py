"""What a gap is, by the ends of its beams alone."""

import numpy as np
import pytest
from numpy.typing import ArrayLike

from pilotage.topology.seeing.door_gaps import Gap, Jamb, gaps_in
from pilotage.topology.seeing.door_shapes import is_ajar, is_closed, is_open
from pilotage.topology.seeing.door_walls import Crossings

PLACES = np.linspace(0.05, 0.85, 17)
DEPTH, ROOM, LEAF = 0.35, 0.9, 0.25


def gap(depths: ArrayLike, ended: ArrayLike = PLACES) -> Gap:
    """A gap from 0 to 0.9 m along its wall."""
    shape = np.shape(ended)
    jambs = Jamb(0.0, 1e-4), Jamb(0.9, 1e-4)
    return Gap(*jambs, np.asarray(ended, float), np.broadcast_to(depths, shape).astype(float))


def kinds(one: Gap) -> tuple[bool, bool, bool]:
    return is_open(one, DEPTH, ROOM), is_closed(one, LEAF), is_ajar(one)


def test_beams_that_go_far_beyond_go_through_an_open_door() -> None:
    assert kinds(gap(3.0)) == (True, False, False)
    assert is_open(gap(np.inf), DEPTH, ROOM)


def test_beams_that_end_at_one_small_depth_end_on_a_closed_leaf() -> None:
    assert is_closed(gap(0.1), LEAF)
    assert not is_open(gap(0.1), DEPTH, ROOM)


@pytest.mark.parametrize("depth", [0.4, 0.6, 0.8])
def test_a_niche_is_neither_open_nor_closed(depth: float) -> None:
    one = gap(depth)
    assert not is_open(one, DEPTH, ROOM)
    assert not is_closed(one, LEAF)


@pytest.mark.parametrize("degrees", [15.0, 40.0, 70.0])
def test_beams_that_end_on_a_slant_from_a_jamb_end_on_a_leaf_that_is_ajar(degrees: float) -> None:
    along = np.linspace(0.05, 0.85, 17) * np.cos(np.deg2rad(degrees))
    depths = along * np.tan(np.deg2rad(degrees)) + 0.05
    assert is_ajar(gap(depths, along))
    assert is_ajar(gap(depths, 0.9 - along))


def test_a_few_beams_past_the_leaf_and_on_the_jambs_do_not_hide_it() -> None:
    depths = 0.6 * PLACES + 0.05
    depths[-4:] = 3.0
    depths[-5] = np.inf
    assert is_ajar(gap(depths))


def test_a_slant_that_begins_far_from_both_jambs_is_something_else() -> None:
    assert not is_ajar(gap(0.4 * PLACES + 0.4))


def test_a_short_slant_is_no_leaf() -> None:
    ended = np.linspace(0.02, 0.2, 17)
    assert not is_ajar(gap(0.5 * ended, ended))


def test_seen_aslant_an_opening_shows_only_what_leads_in_from_its_farther_jamb() -> None:
    depths = np.linspace(0.05, 0.95, 17)
    assert is_open(gap(depths, np.full(17, 0.9)), DEPTH, ROOM)
    assert not is_open(gap(depths / 3.0, np.full(17, 0.9)), DEPTH, ROOM)


def test_two_beams_say_nothing() -> None:
    assert kinds(gap([3.0, 3.0], [0.3, 0.6])) == (False, False, False)
    assert kinds(gap([], [])) == (False, False, False)


def crossed(places: ArrayLike, depths: ArrayLike) -> Crossings:
    """Beams that meet a wall at right angles."""
    at = np.asarray(places, float)
    return Crossings(at, at, np.asarray(depths, float), np.full(len(at), 0.05))


def wall(*gaps: tuple[float, float], depth: float = 2.0) -> Crossings:
    places = np.arange(-2.0, 2.0, 0.05)
    is_gap = np.zeros(len(places), bool)
    for begin, end in gaps:
        is_gap |= (places > begin) & (places < end)
    return crossed(places, np.where(is_gap, depth, 0.0))


def test_jambs_lie_halfway_between_the_last_beam_on_the_wall_and_the_first_through_it() -> None:
    (found,) = gaps_in(wall((-0.42, 0.46)), 0.04, 3.5)
    assert found.first.place == pytest.approx(-0.425)
    assert found.second.place == pytest.approx(0.475)
    assert np.sqrt(found.first.variance) == pytest.approx(0.05 / np.sqrt(12.0))


def test_how_much_wall_is_seen_on_either_side_is_told() -> None:
    one, other = gaps_in(wall((-0.42, 0.46), (0.98, 1.78)), 0.04, 3.5)
    assert one.sides == pytest.approx((1.55, 0.5), abs=0.06)
    assert other.sides == pytest.approx((0.5, 0.15), abs=0.06)


def test_a_gap_at_the_end_of_a_wall_has_one_jamb_and_is_none() -> None:
    assert gaps_in(wall((1.0, 5.0)), 0.04, 3.5) == []
    assert gaps_in(wall((-5.0, 5.0)), 0.04, 3.5) == []


def test_a_gap_that_is_too_narrow_or_too_wide_is_none() -> None:
    assert gaps_in(wall((0.0, 0.3)), 0.04, 3.5) == []
    assert gaps_in(wall((-1.5, 1.5)), 0.04, 2.0) == []


def test_what_stands_before_the_wall_tells_nothing() -> None:
    met = wall((-0.42, 0.46))
    hidden = (met.places > -0.2) & (met.places < 0.1)
    behind = Crossings(met.places, met.ended, np.where(hidden, -0.8, met.depths), met.steps)
    (found,) = gaps_in(behind, 0.04, 3.5)
    assert found.width == pytest.approx(0.9)


def test_a_single_stray_beam_makes_and_hides_no_gap() -> None:
    met = wall((-0.42, 0.46))
    depths = met.depths.copy()
    depths[np.argmin(np.abs(met.places))] = 0.0
    depths[np.argmin(np.abs(met.places - 1.2))] = 2.0
    (found,) = gaps_in(Crossings(met.places, met.ended, depths, met.steps), 0.04, 3.5)
    assert found.width == pytest.approx(0.9)


def test_no_beams_show_no_gaps() -> None:
    assert gaps_in(crossed([], []), 0.04, 3.5) == []
