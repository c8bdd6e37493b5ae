"""A2, the corridor (Wu & Bell 2003, figure 5): two modes without a compass, one with it."""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from pilotage.experiments.corridor_floor import MIDDLE, corridor_floor
from pilotage.experiments.outcome import Outcome, Request
from pilotage.experiments.plots import mode_figure, walk_figure
from pilotage.experiments.ranger_localizer import RangerModel, survey
from pilotage.experiments.ranger_robot import on_a_bin
from pilotage.experiments.repeated_walks import repeated_walks
from pilotage.experiments.symmetric_walk import Route, Symmetry
from pilotage.experiments.symmetry_report import symmetry_report

METRES = 34
"""The way [m]."""

TWO_FOLD = Symmetry(2, MIDDLE)
GOALS = ((10.0, 6.0), (12.7, 5.8), (12.7, 3.0), (12.7, 5.8), (27.9, 6.2), (27.9, 3.2), (27.9, 6.0))
"""Along the corridor, into a room, on to the end, into the last room, and back to the middle."""


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Walk along the corridor as often as asked, each time from another place in it."""
    model = RangerModel()
    place = survey(corridor_floor(), model)
    walks = repeated_walks(place, model, _route, request, advance)
    report = {"states": place.states.admissible_states, "way_m": METRES}
    return Outcome(
        report | symmetry_report(walks, TWO_FOLD, settled_m=1),
        {
            "corridor": walk_figure(place, walks[0], "Corridor that looks alike from both ends"),
            "corridor-modes": mode_figure(walks[0], TWO_FOLD),
        },
    )


def _route(rng: np.random.Generator) -> Route:
    """Return the way from somewhere in the first metres of the corridor."""
    x, y = rng.uniform((1.0, 5.8), (4.0, 6.2))
    return Route(on_a_bin(x, y, float(rng.uniform(-np.pi, np.pi))), _goals(), METRES)


def _goals() -> Iterator[NDArray[np.float64]]:
    yield from (np.array(goal) for goal in GOALS)
    while True:
        yield np.array(MIDDLE)
