"""Every experiment by the name that the command line knows it by."""

from collections.abc import Callable
from dataclasses import dataclass

from pilotage.experiments import (
    corridor,
    hybrid_dynamic,
    hybrid_static,
    kidnap,
    narrow_opening,
    node_chain_starts,
    robocup,
    similar_rooms,
    sonar_complex,
    sonar_simple,
    square_hall,
)
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
    "sonar-simple": Experiment(
        "sonar maps of a simple hall: commands and compass quarter the error of the pose",
        "Li 2008, tables 5-1 and 5-2",
        20,
        sonar_simple.conduct,
    ),
    "sonar-complex": Experiment(
        "sonar maps of a hall with turns: poses, rotations and noise, by model",
        "Li 2008, tables 5-3 and 5-4",
        20,
        sonar_complex.conduct,
    ),
    "narrow-opening": Experiment(
        "an opening of 0.40 m: the centre line closes it, the improved ATM opens it best",
        "Li 2008, figures 5-8 to 5-10 and table 5-5",
        20,
        narrow_opening.conduct,
    ),
    "robocup": Experiment(
        "active localization by landmarks, many and unlike: beside a fixed path and chance",
        "Liu et al. 2008, figures 1 and 2",
        100,
        robocup.conduct,
    ),
    "similar-rooms": Experiment(
        "active localization where both halves look the same: beside a fixed path and chance",
        "Liu et al. 2008, figures 3 and 4",
        100,
        similar_rooms.conduct,
    ),
    "hybrid-static": Experiment(
        "walls tracked in a corridor with doors, corrected at its nodes: pairs matched a cycle",
        "Zhuang et al. 2005, figures 4a and 4b",
        20,
        hybrid_static.conduct,
    ),
    "hybrid-dynamic": Experiment(
        "the same among people, pushed aside on the way: lost, and found again at the next node",
        "Zhuang et al. 2005, figures 4c and 4d",
        20,
        hybrid_dynamic.conduct,
    ),
    "node-chain": Experiment(
        "unknown start among alike doors: nodes are passed until one candidate is left",
        "Zhuang et al. 2005, section 3.2",
        100,
        node_chain_starts.conduct,
    ),
}
