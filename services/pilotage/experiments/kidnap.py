"""A3, kidnapping (Wu & Bell 2003, example 1): M1 never recovers, M2 does."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pilotage.experiments.kidnap_plots import course_figure, event_figure
from pilotage.experiments.kidnapping import (
    ALGORITHMS,
    STEPS_AFTER,
    STEPS_BEFORE,
    Kidnapping,
    Seen,
    kidnap,
)
from pilotage.experiments.outcome import Outcome, Request
from pilotage.experiments.ranger_localizer import RangerModel, survey
from pilotage.localizer.modes import MODE_RADIUS, MODE_TURN
from pilotage.robot.simulator.floor_plans import square_hall


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Kidnap the robot in the square hall, as often as asked, each time between other places."""
    model = RangerModel()
    place = survey(square_hall(), model)
    kidnappings: list[Kidnapping] = []
    for run in range(request.runs):
        rng = np.random.default_rng([request.seed, run])
        kidnappings.append(kidnap(place, model, rng))
        advance(1.0 / request.runs)
    report = {
        "states": place.states.admissible_states,
        "steps_before": STEPS_BEFORE,
        "steps_after": STEPS_AFTER,
        "recovered_means": "most probable place within 0.5 m and 15 degrees to the end",
    }
    return Outcome(
        report | {name: recoveries(kidnappings, name) for name in ALGORITHMS},
        {"kidnap": course_figure(kidnappings), "kidnap-hall": event_figure(place, kidnappings[0])},
    )


def recoveries(kidnappings: list[Kidnapping], algorithm: str) -> dict[str, object]:
    """Return in how many runs an algorithm recovered and after how many steps (None: never)."""
    seen = [kidnapping.seen[algorithm] for kidnapping in kidnappings]
    steps = [recovery_step(one) for one in seen]
    found = [step for step in steps if step is not None]
    shares = np.array([one.share[STEPS_BEFORE:] for one in seen])
    return {
        "certain_before": sum(bool(_is_right(one)[STEPS_BEFORE - 1]) for one in seen) / len(seen),
        "recovered": len(found) / len(seen),
        "recovery_steps": steps,
        "recovery_steps_median": float(np.median(found)) if found else None,
        "largest_belief_at_truth_afterwards": float(shares.max()),
        "belief_at_truth_at_the_end": [float(share) for share in shares[:, -1]],
        "belief_died_out": sum(bool(np.isnan(one.error_m[-1])) for one in seen) / len(seen),
        "error_at_the_end_m": [_or_none(float(one.error_m[-1])) for one in seen],
    }


def recovery_step(seen: Seen) -> int | None:
    """Return the first step after the kidnapping, 1 on, from which on the place is right."""
    wrong = np.nonzero(~_is_right(seen)[STEPS_BEFORE:])[0]
    first = int(wrong[-1]) + 1 if len(wrong) else 0
    return first + 1 if first < STEPS_AFTER else None


def _is_right(seen: Seen) -> NDArray[np.bool_]:
    return seen.is_right(MODE_RADIUS, MODE_TURN)


def _or_none(value: float) -> float | None:
    """Return None for the error of a belief that holds nothing any more."""
    return None if np.isnan(value) else value
