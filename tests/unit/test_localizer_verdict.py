"""Which word an estimate gets: `localized` by confidence alone, the others by what is left."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pilotage.localizer.verdict import Verdict, VerdictParams

PARAMS = VerdictParams(enter=0.9, stay=0.6, earned_by=2, rival_mass=0.1, named_mass=0.5, hope=0.3)
"""Of its own: what is tested here holds whatever the defaults are."""

ONE, TWO = [1.0], [0.5, 0.5]


def localized() -> Verdict:
    verdict = Verdict(PARAMS)
    for _ in range(PARAMS.earned_by):
        verdict.judge(0.95, ONE, surprise=False)
    assert verdict.state == "localized"
    return verdict


def test_nothing_is_known_at_first() -> None:
    assert Verdict(PARAMS).state == "unknown"
    assert Verdict(PARAMS).judge(0.0, [], surprise=False) == "unknown"


@pytest.mark.parametrize(("confidence", "word"), [(0.89, "unknown"), (0.9, "localized")])
def test_localized_begins_where_the_confidence_reaches_its_limit(
    confidence: float, word: str
) -> None:
    verdict = Verdict(PARAMS)
    assert verdict.judge(confidence, ONE, surprise=False) == "unknown", "once is not enough"
    assert verdict.judge(confidence, ONE, surprise=False) == word


def test_localized_is_earned_by_measurements_in_a_row() -> None:
    verdict = Verdict(VerdictParams(enter=0.9, earned_by=3))
    sure = [0.95, 0.95, 0.8, 0.95, 0.95, 0.95]
    words = [verdict.judge(c, ONE, surprise=False) for c in sure]
    assert words == ["unknown"] * 5 + ["localized"]


@pytest.mark.parametrize(("confidence", "word"), [(0.6, "localized"), (0.59, "unknown")])
def test_localized_stays_on_less_than_it_began_with(confidence: float, word: str) -> None:
    assert localized().judge(confidence, ONE, surprise=False) == word


def test_what_is_no_longer_localized_has_to_reach_the_upper_limit_again() -> None:
    verdict = localized()
    words = [verdict.judge(c, ONE, surprise=False) for c in (0.7, 0.5, 0.7, 0.89, 0.91, 0.92)]
    assert words == ["localized"] + ["unknown"] * 4 + ["localized"]


def test_confidence_that_wavers_between_the_limits_does_not_flicker() -> None:
    verdict, never = localized(), Verdict(PARAMS)
    wavering = [0.7, 0.85, 0.65, 0.88, 0.61]
    assert {verdict.judge(c, ONE, surprise=False) for c in wavering} == {"localized"}
    assert {never.judge(c, ONE, surprise=False) for c in wavering} == {"unknown"}


def test_a_surprise_ends_localized_however_sure_it_still_is() -> None:
    verdict = localized()
    assert verdict.judge(1.0, ONE, surprise=True) == "lost"
    words = [verdict.judge(1.0, ONE, surprise=False) for _ in range(2)]
    assert words == ["unknown", "localized"], "it has to be earned again"


def test_a_surprise_means_nothing_to_a_robot_that_was_nowhere() -> None:
    assert Verdict(PARAMS).judge(1.0, ONE, surprise=True) == "unknown"


def test_a_robot_that_was_localized_is_lost_without_hope_and_unknown_with_it() -> None:
    verdict = localized()
    words = [verdict.judge(c, ONE, surprise=False) for c in (0.29, 0.31, 0.29)]
    assert words == ["lost", "unknown", "lost"]


def test_several_likely_places_are_ambiguous() -> None:
    assert Verdict(PARAMS).judge(0.5, TWO, surprise=False) == "ambiguous"
    assert localized().judge(0.5, TWO, surprise=False) == "ambiguous"
    assert Verdict(PARAMS).judge(0.2, [0.25] * 4, surprise=False) == "ambiguous"


def test_after_a_surprise_several_places_are_no_answer_yet() -> None:
    assert localized().judge(0.5, TWO, surprise=True) == "lost"


@pytest.mark.parametrize(
    "masses",
    [[0.95, 0.09], [0.24, 0.24], [0.1] * 4 + [0.05] * 12, []],
    ids=["no rival", "little together", "many crumbs", "nothing"],
)
def test_one_place_or_too_little_mass_is_not_ambiguous(masses: list[float]) -> None:
    assert Verdict(PARAMS).judge(0.5, masses, surprise=False) == "unknown"


def test_confidence_outweighs_rivals() -> None:
    assert localized().judge(0.95, TWO, surprise=False) == "localized"


def test_what_begins_anew_was_never_lost() -> None:
    verdict = localized()
    verdict.begin()
    assert verdict.state == "unknown"
    assert verdict.judge(0.1, ONE, surprise=False) == "unknown"


def test_what_resumes_is_confirmed_by_one_measurement() -> None:
    verdict = Verdict(PARAMS)
    verdict.begin(was_localized=True)
    assert verdict.state == "unknown"
    assert verdict.judge(0.95, ONE, surprise=False) == "localized"


def test_what_resumes_may_be_lost_but_is_not_localized_by_that() -> None:
    verdict = Verdict(PARAMS)
    verdict.begin(was_localized=True)
    assert verdict.judge(0.7, ONE, surprise=False) == "unknown"
    assert verdict.judge(0.95, ONE, surprise=False) == "unknown", "it was not confirmed"
    assert verdict.judge(0.1, ONE, surprise=False) == "lost"


def test_the_limits_of_service_leave_room_between_them() -> None:
    params = VerdictParams()
    assert params.hope < params.stay < params.enter < 1.0


JUDGED = st.tuples(st.floats(0.0, 1.0), st.lists(st.floats(0.0, 1.0), max_size=4), st.booleans())


@given(st.lists(JUDGED, max_size=15))
def test_whatever_comes_localized_and_lost_are_deserved(
    judged: list[tuple[float, list[float], bool]],
) -> None:
    verdict, was_localized, in_a_row = Verdict(PARAMS), False, 0
    for confidence, masses, surprise in judged:
        before = verdict.state
        word = verdict.judge(confidence, masses, surprise=surprise)
        assert verdict.state == word
        in_a_row = in_a_row + 1 if confidence >= PARAMS.enter and not surprise else 0
        if word == "localized":
            assert not surprise
            assert confidence >= PARAMS.stay
            assert before == "localized" or in_a_row >= PARAMS.earned_by
            was_localized = True
        assert word != "lost" or was_localized
        assert word != "ambiguous" or len(masses) > 1
