"""C-II, a hall with turns (Li 2008, 5.1.2): correction, silence while turning, less noise."""

from collections.abc import Callable

from pilotage.experiments.outcome import Outcome, Request
from pilotage.experiments.sonar_halls import complex_hall
from pilotage.experiments.sonar_report import conduct_in


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Go the winding way as often as asked."""
    return conduct_in(complex_hall(), "sonar-complex", request, advance)
