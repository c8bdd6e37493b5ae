"""Every experiment by the name that the command line knows it by."""

from collections.abc import Callable
from dataclasses import dataclass

from pilotage.experiments import corridor, kidnap, square_hall
from pilotage.experiments.outcome import Outcome, Request


@dataclass(frozen=True)
class Experiment:
    """An experiment: what it shows, where it comes from, how it is conducted.

    `conduct` is called with what is asked and with a function that it tells of each part done, as
    a share of the whole; `usual_runs` is how often it runs unless told otherwise.
    """

    title: str
    paper: str
    usual_runs: int
    conduct: Callable[[Request, Callable[[float], None]], Outcome]


CATALOGUE = {
    "square-hall": Experiment(
        "a featureless hall: four modes without a compass, one with it",
        "Wu & Bell 2003, figure 4",
        1,
        square_hall.conduct,
    ),
    "corridor": Experiment(
        "a corridor alike from both ends: two modes without a compass, one with it",
        "Wu & Bell 2003, figure 5",
        1,
        corridor.conduct,
    ),
    "kidnap": Experiment(
        "a robot carried off: M1 never recovers, M2 does",
        "Wu & Bell 2003, example 1",
        20,
        kidnap.conduct,
    ),
}
