"""The confidence: a probability that rises with each thing that speaks for a place."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pilotage.localizer.confidence import (
    BETTER_COUNTS,
    EXACT,
    HISTORY,
    HISTORY_COUNTS,
    MOST_AHEAD,
    MOST_SUPPORT,
    ODDS_COUNT,
    OFFSET,
    RIVALLED,
    SLOPE,
    Signs,
    confidence_of,
    features,
)
from pilotage.localizer.verdict import VerdictParams

SURE = Signs(ahead=8.0, support=0.35, mass=0.95, better=0.2)
DOUBTFUL = Signs(ahead=1.0, support=0.05, mass=0.1, better=0.2)

SIGNS = st.builds(
    Signs,
    ahead=st.floats(-30.0, 30.0),
    support=st.floats(-2.0, 0.8),
    mass=st.floats(0.0, 1.0),
    better=st.floats(-1.0, 1.0),
)
MORE = st.floats(0.0, 10.0)


def said(log_odds: float) -> float:
    """What is said of a place whose limits leave it these log-odds."""
    return 1.0 / (1.0 + math.exp(-SLOPE * log_odds - OFFSET))


@given(SIGNS)
def test_confidence_is_a_probability(signs: Signs) -> None:
    assert 0.0 <= confidence_of(signs) <= 1.0


@given(SIGNS, st.sampled_from(["ahead", "support", "mass", "better"]), MORE)
def test_more_of_any_sign_never_makes_less_sure(signs: Signs, name: str, more: float) -> None:
    better = replace(signs, **{name: getattr(signs, name) + more})
    assert confidence_of(better) >= confidence_of(signs)


@pytest.mark.parametrize(("name", "more"), [("ahead", 2.0), ("mass", 0.3), ("support", 0.2)])
def test_each_sign_speaks_for_the_place(name: str, more: float) -> None:
    doubtful = replace(DOUBTFUL, ahead=3.0, support=0.0)
    better = replace(doubtful, **{name: getattr(doubtful, name) + more})
    assert confidence_of(better) > confidence_of(doubtful)


@given(SIGNS, st.floats(-30.0, 0.0))
def test_a_place_that_is_not_ahead_of_all_others_is_never_certain(
    signs: Signs, ahead: float
) -> None:
    assert confidence_of(replace(signs, ahead=ahead)) <= said(0.0)
    assert said(0.0) < VerdictParams().enter


def test_a_place_of_which_all_speaks_well_is_localized_and_a_doubtful_one_is_not() -> None:
    assert confidence_of(SURE) >= VerdictParams().enter
    assert confidence_of(DOUBTFUL) < VerdictParams().stay


def test_a_place_where_the_belief_is_not_and_the_scans_hardly_fit_is_doubted() -> None:
    """Though it is far ahead of the other places that are followed."""
    poor = Signs(ahead=9.0, support=-0.15, mass=0.0, better=0.2)
    assert confidence_of(poor) < VerdictParams().enter


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_signs_count_no_further_than_their_limits(sign: float) -> None:
    far = replace(SURE, support=sign * MOST_SUPPORT)
    assert features(replace(far, support=sign * 9.0))[1] == features(far)[1]
    assert features(replace(SURE, ahead=sign * 99.0))[0] == sign * MOST_AHEAD


def test_features_come_in_the_order_of_the_signs() -> None:
    assert features(replace(SURE, support=0.2)) == pytest.approx((8.0, 0.2, 0.95))


@given(SIGNS)
def test_the_odds_of_a_place_are_never_more_than_a_power_of_those_against_all_others(
    signs: Signs,
) -> None:
    rough = replace(signs, support=min(signs.support, EXACT[0]))
    assert confidence_of(rough) <= said(ODDS_COUNT * signs.ahead) + 1e-12


@given(SIGNS)
def test_where_the_map_is_exact_odds_count_twice(signs: Signs) -> None:
    exact = replace(signs, support=EXACT[1], ahead=abs(signs.ahead))
    twice = replace(exact, support=EXACT[0], ahead=2.0 * exact.ahead)
    assert confidence_of(exact) == pytest.approx(confidence_of(twice))


@given(SIGNS)
def test_a_place_is_doubted_as_far_as_another_fits_as_well(signs: Signs) -> None:
    signs = replace(signs, support=min(signs.support, EXACT[0]))
    past = HISTORY_COUNTS * max(0.0, signs.ahead - HISTORY)
    limit = max(BETTER_COUNTS * signs.better + past, RIVALLED)
    assert confidence_of(signs) <= said(limit) + 1e-12


def test_where_two_places_fit_alike_only_much_evidence_of_the_past_prefers_one() -> None:
    alike = replace(SURE, better=0.0)
    assert confidence_of(alike) == pytest.approx(said(0.0))
    assert confidence_of(replace(alike, ahead=20.0)) > VerdictParams().enter
