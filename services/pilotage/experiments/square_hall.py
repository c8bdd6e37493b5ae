"""A1, the square hall (Wu & Bell 2003, figure 4): four modes without a compass, one with it."""

from collections.abc import Callable

import numpy as np

from pilotage.experiments.outcome import Outcome, Request
from pilotage.experiments.plots import mode_figure, walk_figure
from pilotage.experiments.ranger_localizer import RangerModel, survey
from pilotage.experiments.ranger_robot import on_a_bin, random_goals
from pilotage.experiments.repeated_walks import repeated_walks
from pilotage.experiments.symmetric_walk import Route, Symmetry
from pilotage.experiments.symmetry_report import symmetry_report
from pilotage.robot.simulator.floor_plans import HALL_SIZE, square_hall

METRES = 30
"""The way [m]."""

CLEAR = 1.5
"""The robot keeps this far [m] from the walls."""

FOUR_FOLD = Symmetry(4, (HALL_SIZE / 2.0, HALL_SIZE / 2.0))


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Walk through the hall as often as asked, each time from another place."""
    model = RangerModel()
    place = survey(square_hall(), model)
    walks = repeated_walks(place, model, _route, request, advance)
    report = {"states": place.states.admissible_states, "way_m": METRES}
    return Outcome(
        report | symmetry_report(walks, FOUR_FOLD, settled_m=1),
        {
            "square-hall": walk_figure(place, walks[0], "Featureless square hall"),
            "square-hall-modes": mode_figure(walks[0], FOUR_FOLD),
        },
    )


def _route(rng: np.random.Generator) -> Route:
    """Return a way from anywhere to anywhere, and on."""
    low, high = (CLEAR, CLEAR), (HALL_SIZE - CLEAR, HALL_SIZE - CLEAR)
    x, y = rng.uniform(low, high)
    start = on_a_bin(x, y, float(rng.uniform(-np.pi, np.pi)))
    return Route(start, random_goals(low, high, rng), METRES)
