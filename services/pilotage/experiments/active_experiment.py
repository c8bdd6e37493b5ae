"""What the two experiments of Liu et al. 2008 share: run, report, plots."""

from collections.abc import Callable
from dataclasses import asdict

from pilotage.experiments.active_comparison import (
    FIXED_PATH,
    Setting,
    compare,
    comparison_report,
    method_for,
)
from pilotage.experiments.active_plots import error_figure, field_figure
from pilotage.experiments.landmark_field import START
from pilotage.experiments.outcome import Outcome, Request


def conduct_comparison(
    name: str, setting: Setting, request: Request, advance: Callable[[float], None]
) -> Outcome:
    """Return the figures and plots of a comparison; `name` begins the names of its plots."""
    method = method_for(setting.field)
    trials = compare(setting, method, request, advance)
    settings = {
        "particles": setting.particles,
        "steps": setting.steps,
        "start": list(START),
        "fixed_path": [list(corner) for corner in FIXED_PATH],
        "params": asdict(method.params),
    }
    return Outcome(
        settings | comparison_report(trials),
        {
            name: error_figure(setting.field, trials),
            f"{name}-field": field_figure(setting.field, method.field, trials),
        },
    )
