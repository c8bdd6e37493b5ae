"""C-I, a simple hall (Li 2008, 5.1.1): correction quarters the error of the pose."""

from collections.abc import Callable

from pilotage.experiments.outcome import Outcome, Request
from pilotage.experiments.sonar_halls import simple_hall
from pilotage.experiments.sonar_report import conduct_in


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Go there and back several times, straight."""
    return conduct_in(simple_hall(), "sonar-simple", request, advance)
