"""D-II, people and a collision that odometry does not see (Zhuang et al. 2005, figures 4c and 4d).

Each ride is repeated with the same luck without the correction at nodes, and both with the filter
of the localizer in place of the paper's, which doubts odometry and looks around by itself.
"""

from collections.abc import Callable

from pilotage.experiments.hybrid_localization import OWN_FILTER, HybridParams
from pilotage.experiments.hybrid_plots import dynamic_figure, error_figure
from pilotage.experiments.hybrid_report import FOUND, collision_figures, ride_figures
from pilotage.experiments.hybrid_trial import (
    CYCLES,
    PEOPLE,
    PUSH,
    SPIN,
    WAY,
    Conditions,
    ride_runs,
    usual_place,
)
from pilotage.experiments.outcome import Outcome, Request

OWN = HybridParams(filter=OWN_FILTER)
ARMS = {
    "with_nodes": Conditions(PEOPLE, collides=True),
    "without_nodes": Conditions(PEOPLE, collides=True, corrects=False),
    "own_filter_with_nodes": Conditions(PEOPLE, collides=True, params=OWN),
    "own_filter_without_nodes": Conditions(PEOPLE, collides=True, corrects=False, params=OWN),
}


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Ride among people, be pushed on the way to the second node, and go on."""
    place = usual_place()
    rides = {
        name: ride_runs(place, conditions, request, lambda share: advance(share / len(ARMS)))
        for name, conditions in ARMS.items()
    }
    figures = {name: ride_figures(each) | collision_figures(each) for name, each in rides.items()}
    report = {
        "cycles": CYCLES,
        "way_of_a_cycle_m": WAY,
        "people": PEOPLE,
        "collision_m": PUSH,
        "collision_rad": SPIN,
        "recovered_means": f"within {FOUND[0]:g} m and 5 degrees from the next node on, pairs back",
        "paper_mean": 3.2,
    }
    others = {name: each for name, each in figures.items() if name != "with_nodes"}
    return Outcome(
        report | figures["with_nodes"] | others,
        {
            "hybrid-dynamic": dynamic_figure(place, rides["with_nodes"], rides["without_nodes"]),
            "hybrid-dynamic-errors": error_figure(
                {name.replace("_", " "): each for name, each in rides.items()}
            ),
        },
    )
