"""A walk through a symmetric place as often as asked, each time with chances of its own."""

from collections.abc import Callable
from functools import partial

import numpy as np

from pilotage.experiments.outcome import Request
from pilotage.experiments.ranger_localizer import Place, RangerModel
from pilotage.experiments.symmetric_walk import Route, Walk, walk


def repeated_walks(
    place: Place,
    model: RangerModel,
    route: Callable[[np.random.Generator], Route],
    request: Request,
    advance: Callable[[float], None],
) -> list[Walk]:
    """Return one walk per run.

    Args:
        place: where.
        model: the robot and what the localizers know of it.
        route: draws the route of a run.
        request: how often, and the seed of the chances.
        advance: called after every metre with its share of all walks.
    """
    walks: list[Walk] = []
    for run in range(request.runs):
        rng = np.random.default_rng([request.seed, run])
        way = route(rng)
        share = 1.0 / (request.runs * way.metres)
        walks.append(walk(place, model, way, rng, partial(advance, share)))
    return walks
