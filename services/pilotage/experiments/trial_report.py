"""What trials showed: runs and their summary as plain values for `report.json`."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from pilotage.experiments.trial_run import TrialRun
from pilotage.experiments.trial_starts import Starts

MEANINGS = {
    "localized": "the localizer said so at three scans weighed in a row; the run ends with that",
    "correct": "its pose was then within 0.5 m and 15 degrees of the true one",
    "travel_m": "true way driven until it said so first and stayed with it, or the whole way",
    "steps": "scans weighed until the end",
    "starts.by": "turn: a full turn on the spot leaves the robot unlocalized; look: scans at rest",
}


def report_of(starts: Starts, runs: Sequence[TrialRun]) -> dict[str, Any]:
    """Return starts, summary and runs."""
    return {
        "laser_range_m": starts.range_max,
        "starts": {
            "by": starts.by,
            "draws": starts.draws,
            "not_settled_at_rest": starts.unsettled,
            "turned_on_the_spot": starts.probed,
            "not_settled_by_turning": starts.hard,
        },
        "summary": _summary(runs),
        "meanings": MEANINGS,
        "runs": [_run(run, start.tolist()) for run, start in zip(runs, starts.poses, strict=True)],
    }


def _summary(runs: Sequence[TrialRun]) -> dict[str, Any]:
    decisions = np.concatenate([run.decisions_s for run in runs]) * 1e3
    return {
        "localized_share": float(np.mean([run.localized for run in runs])),
        "correct_share": float(np.mean([run.correct for run in runs])),
        "median_travel_m": float(np.median([run.travel_m for run in runs])),
        "mean_travel_m": float(np.mean([run.travel_m for run in runs])),
        "median_seconds": float(np.median([run.seconds for run in runs])),
        "contacts": sum(run.contacts for run in runs),
        "decision_ms": _percentiles(decisions),
    }


def _run(run: TrialRun, start: list[float]) -> dict[str, Any]:
    return {
        "localized": run.localized,
        "correct": run.correct,
        "travel_m": run.travel_m,
        "steps": run.steps,
        "seconds": run.seconds,
        "contacts": run.contacts,
        "start": start,
        "end": run.track[-1].tolist(),
        "error_m": run.error_m,
        "error_rad": run.error_rad,
        "history": run.history,
        "decision_ms": _percentiles(run.decisions_s * 1e3),
    }


def _percentiles(values: "np.typing.NDArray[np.float64]") -> dict[str, float]:
    p50, p99, most = (float(np.percentile(values, share)) for share in (50, 99, 100))
    return {"p50": p50, "p99": p99, "max": most}
