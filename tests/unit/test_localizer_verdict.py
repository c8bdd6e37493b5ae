"""What a belief is called, and when: nothing is `localized` before it has been earned."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pilotage.localizer.modes import Mode
from pilotage.localizer.verdict import Doubts, Verdict, VerdictParams

PARAMS = VerdictParams(
    enter_mass=0.9,
    stay_mass=0.7,
    enter_matched=0.6,
    stay_matched=0.4,
    earned_by=3,
    jump=0.6,
    jump_turn=0.35,
    rival_mass=0.1,
    named_mass=0.5,
)
"""Of its own: what is tested here holds whatever the defaults are."""

HERE = np.array([1.0, 2.0, 0.3])


def mode(mass: float, x: float = 1.0, theta: float = 0.3) -> Mode:
    return Mode(mass, np.array([x, 2.0, theta]), np.eye(3) * 0.01)


def localized() -> Verdict:
    verdict = Verdict(PARAMS)
    for _ in range(PARAMS.earned_by):
        verdict.judge([mode(0.95)], 0.9, HERE)
    assert verdict.state == "localized"
    return verdict


def test_nothing_is_known_at_first() -> None:
    verdict = Verdict(PARAMS)
    assert (verdict.state, verdict.confidence) == ("unknown", 0.0)


def test_localized_is_earned_by_scans_in_a_row() -> None:
    verdict = Verdict(PARAMS)
    states = [verdict.judge([mode(0.95)], 0.9, HERE) for _ in range(4)]
    assert states == ["unknown", "unknown", "localized", "localized"]


def test_a_scan_between_that_disagrees_begins_the_count_anew() -> None:
    verdict = Verdict(PARAMS)
    matched = [0.9, 0.9, 0.5, 0.9, 0.9, 0.9]
    states = [verdict.judge([mode(0.95)], share, HERE) for share in matched]
    assert states == ["unknown"] * 5 + ["localized"]


def test_the_first_scan_agrees_with_nothing_yet() -> None:
    verdict = Verdict(PARAMS)
    verdict.judge([mode(0.99)], 1.0, None)
    states = [verdict.judge([mode(0.99)], 1.0, HERE) for _ in range(3)]
    assert states == ["unknown", "unknown", "localized"]


@pytest.mark.parametrize(("mass", "matched"), [(0.89, 1.0), (1.0, 0.59)])
def test_little_mass_or_a_poor_match_never_becomes_localized(mass: float, matched: float) -> None:
    verdict = Verdict(PARAMS)
    assert {verdict.judge([mode(mass)], matched, HERE) for _ in range(9)} == {"unknown"}


def test_localized_stays_on_weaker_evidence_than_it_began() -> None:
    verdict = localized()
    assert verdict.judge([mode(0.75)], 0.45, HERE) == "localized"


@pytest.mark.parametrize(("mass", "matched"), [(0.69, 1.0), (1.0, 0.39)])
def test_localized_ends_on_too_weak_evidence(mass: float, matched: float) -> None:
    verdict = localized()
    assert verdict.judge([mode(mass)], matched, HERE) == "lost"


@pytest.mark.parametrize("jumped", [mode(1.0, x=1.7), mode(1.0, theta=0.7)], ids=["far", "turned"])
def test_a_place_that_jumps_is_lost_at_once_and_must_be_earned_again(jumped: Mode) -> None:
    verdict = localized()
    assert verdict.judge([jumped], 1.0, HERE) == "lost"
    again = [verdict.judge([jumped], 1.0, jumped.pose) for _ in range(3)]
    assert again == ["lost", "lost", "localized"]


def test_a_turn_through_the_wrap_is_no_jump() -> None:
    verdict = Verdict(PARAMS)
    before = np.array([1.0, 2.0, 3.1])
    states = [verdict.judge([mode(0.95, theta=-3.1)], 0.9, before) for _ in range(3)]
    assert states[-1] == "localized"


def test_several_places_of_mass_are_ambiguous() -> None:
    verdict = Verdict(PARAMS)
    four = [mode(0.25, x) for x in (1.0, 4.0, 7.0, 9.0)]
    assert verdict.judge(four, 1.0, HERE) == "ambiguous"


def test_places_that_hold_little_together_are_not_named() -> None:
    verdict = Verdict(PARAMS)
    assert verdict.judge([mode(0.2), mode(0.2, 4.0)], 1.0, HERE) == "unknown"


def test_a_localized_robot_may_become_ambiguous() -> None:
    verdict = localized()
    assert verdict.judge([mode(0.5), mode(0.45, 4.0)], 1.0, HERE) == "ambiguous"


def test_no_state_left_is_lost_if_it_was_known_before() -> None:
    assert Verdict(PARAMS).judge([], 0.0, None) == "unknown"
    assert localized().judge([], 0.0, HERE) == "lost"


def test_what_began_anew_was_never_lost() -> None:
    verdict = localized()
    verdict.reset()
    assert verdict.state == "unknown"
    assert verdict.judge([mode(0.3)], 0.2, HERE) == "unknown"


def test_a_surprising_scan_ends_localized_whatever_the_belief_still_says() -> None:
    verdict = localized()
    assert verdict.judge([mode(1.0)], 1.0, HERE, doubts=Doubts(surprise=True)) == "lost"
    assert verdict.confidence < 0.5


def test_confidence_grows_as_a_place_is_earned() -> None:
    verdict = Verdict(PARAMS)
    said = []
    for _ in range(4):
        verdict.judge([mode(0.95)], 0.9, HERE)
        said.append(verdict.confidence)
    assert said == sorted(said)
    assert said[0] < 0.6
    assert said[-1] == pytest.approx(0.95)


def test_where_no_beams_can_tell_the_mass_alone_decides() -> None:
    verdict = Verdict(PARAMS)
    assert [verdict.judge([mode(0.95)], None, HERE) for _ in range(3)][-1] == "localized"


def test_a_resumed_localized_robot_is_confirmed_by_one_scan() -> None:
    verdict = Verdict(PARAMS)
    verdict.resume(was_localized=True)
    assert verdict.state == "unknown"
    assert verdict.judge([mode(0.95)], 0.9, HERE) == "localized"


def test_a_resumed_robot_that_is_not_where_it_was_must_earn_its_place() -> None:
    verdict = Verdict(PARAMS)
    verdict.resume(was_localized=True)
    jumped = mode(0.95, x=5.0)
    states = [verdict.judge([jumped], 0.9, HERE)]
    states += [verdict.judge([jumped], 0.9, jumped.pose) for _ in range(3)]
    assert states == ["unknown", "unknown", "unknown", "localized"]


def test_a_resumed_robot_that_was_not_localized_earns_it_like_any_other() -> None:
    verdict = Verdict(PARAMS)
    verdict.resume(was_localized=False)
    assert [verdict.judge([mode(0.95)], 0.9, HERE) for _ in range(2)] == ["unknown"] * 2


JUDGED = st.tuples(
    st.lists(st.floats(0.0, 1.0), max_size=4),
    st.floats(0.0, 1.0),
    st.sampled_from([None, HERE, np.array([4.0, 2.0, 0.3])]),
)


@given(st.lists(JUDGED, max_size=12), st.integers(1, 5))
def test_whatever_comes_localized_is_never_said_before_it_is_earned(
    scans: list[tuple[list[float], float, np.ndarray | None]], earned_by: int
) -> None:
    verdict = Verdict(VerdictParams(earned_by=earned_by))
    agreeing = 0
    for masses, matched, expected in scans:
        modes = [mode(mass, x=1.0 + 3.0 * i) for i, mass in enumerate(sorted(masses)[::-1])]
        state = verdict.judge(modes, matched, expected)
        agrees = bool(modes) and expected is not None and float(expected[0]) == 1.0
        agreeing = agreeing + 1 if agrees else 0
        assert state != "localized" or agreeing >= earned_by
        assert 0.0 <= verdict.confidence <= 1.0


def test_a_place_that_fits_as_well_keeps_the_best_from_being_localized() -> None:
    verdict = Verdict()
    for _ in range(10):
        state = verdict.judge([mode(0.99), mode(0.005)], 1.0, HERE, Doubts(rivals=1))
    assert state == "ambiguous"
    assert verdict.confidence < 0.5


def test_when_the_last_rival_is_gone_the_place_is_earned_anew() -> None:
    verdict = Verdict()
    verdict.judge([mode(0.99)], 1.0, HERE, Doubts(rivals=1))
    states = [verdict.judge([mode(0.99)], 1.0, HERE) for _ in range(verdict.params.earned_by)]
    assert states[-1] == "localized"
    assert "localized" not in states[:-1]
