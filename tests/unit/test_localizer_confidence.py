"""The confidence: a probability that rises with each thing that speaks for a place."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pilotage.localizer.confidence import MOST_AHEAD, Signs, confidence_of, features
from pilotage.localizer.verdict import VerdictParams

SURE = Signs(ahead=8.0, support=0.35, fit=0.35, through=0.0, scans=10.0, mass=0.95)
DOUBTFUL = Signs(ahead=1.0, support=0.1, fit=0.0, through=0.1, scans=3.0, mass=0.4)

SIGNS = st.builds(
    Signs,
    ahead=st.floats(-30.0, 30.0),
    support=st.floats(-2.0, 0.8),
    fit=st.floats(-2.0, 0.8),
    through=st.floats(0.0, 1.0),
    scans=st.floats(0.0, 1e6),
    mass=st.floats(0.0, 1.0),
)


@given(SIGNS)
def test_confidence_is_a_probability(signs: Signs) -> None:
    assert 0.0 <= confidence_of(signs) <= 1.0


@given(SIGNS, st.floats(0.0, 10.0))
def test_more_evidence_ahead_never_makes_less_sure(signs: Signs, more: float) -> None:
    ahead = replace(signs, ahead=signs.ahead + more)
    assert confidence_of(ahead) >= confidence_of(signs)


@pytest.mark.parametrize(("name", "more"), [("ahead", 2.0), ("mass", 0.3), ("fit", 0.2)])
def test_each_sign_speaks_for_the_place(name: str, more: float) -> None:
    value = getattr(DOUBTFUL, name)
    assert confidence_of(replace(DOUBTFUL, **{name: value + more})) > confidence_of(DOUBTFUL)


def test_going_through_walls_speaks_against_it() -> None:
    assert confidence_of(replace(SURE, through=0.5)) < confidence_of(SURE)


def test_a_place_of_which_all_speaks_well_is_localized_and_a_doubtful_one_is_not() -> None:
    assert confidence_of(SURE) >= VerdictParams().enter
    assert confidence_of(DOUBTFUL) < VerdictParams().stay


def test_two_places_that_are_alike_cannot_be_believed_at_all() -> None:
    assert confidence_of(replace(SURE, ahead=0.0, mass=0.5)) < VerdictParams().enter


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_evidence_counts_no_further_than_its_limit(sign: float) -> None:
    far, farther = (replace(SURE, ahead=sign * (MOST_AHEAD + d)) for d in (0.0, 50.0))
    assert confidence_of(far) == confidence_of(farther)


def test_features_come_in_the_order_of_the_signs() -> None:
    assert features(SURE) == pytest.approx((8.0, 0.35, 0.35, 0.0, 2.302585, 0.95))
    assert features(replace(SURE, scans=0.0))[4] == 0.0
