"""B1, the RoboCup 2006 four-legged field (Liu et al. 2008, figures 1 and 2)."""

from collections.abc import Callable

from pilotage.experiments.active_comparison import Setting
from pilotage.experiments.active_experiment import conduct_comparison
from pilotage.experiments.landmark_field import robocup_field
from pilotage.experiments.outcome import Outcome, Request

PARTICLES, STEPS = 1_000, 60


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Compare the policies where landmarks are many, unlike, and seen from afar."""
    setting = Setting(robocup_field(), PARTICLES, STEPS)
    return conduct_comparison("robocup", setting, request, advance)
