"""B2, a field with exactly similar parts (Liu et al. 2008, figures 3 and 4)."""

from collections.abc import Callable

from pilotage.experiments.active_comparison import Setting
from pilotage.experiments.active_experiment import conduct_comparison
from pilotage.experiments.landmark_field import similar_field
from pilotage.experiments.outcome import Outcome, Request

PARTICLES, STEPS = 3_000, 100


def conduct(request: Request, advance: Callable[[float], None]) -> Outcome:
    """Compare the policies where both halves look the same from the start."""
    setting = Setting(similar_field(), PARTICLES, STEPS)
    return conduct_comparison("similar-rooms", setting, request, advance)
