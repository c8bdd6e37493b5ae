"""D-I, a corridor without people (Zhuang et al. 2005, figures 4a and 4b)."""

from collections.abc import Callable

from pilotage.experiments.hybrid_plots import error_figure, static_figure
from pilotage.experiments.hybrid_report import ride_figures
from pilotage.experiments.hybrid_trial import CYCLES, WAY, Conditions, ride_runs, usual_place
from pilotage.experiments.outcome import Outcome, Request


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Ride along the corridor as often as asked, and count what the filter matches."""
    place = usual_place()
    rides = ride_runs(place, Conditions(), request, advance)
    report = {
        "cycles": CYCLES,
        "way_of_a_cycle_m": WAY,
        "pairs_are": "lines of the scan that the filter pairs with lines of the map; corners apart",
        "paper_mean": 4.85,
    }
    return Outcome(
        report | ride_figures(rides),
        {
            "hybrid-static": static_figure(place, rides),
            "hybrid-static-errors": error_figure({"corridor without people": rides}),
        },
    )
