"""Writes what an experiment showed: `report.json`, and each plot as PNG and SVG."""

import json
from pathlib import Path

from pilotage.experiments.outcome import Outcome, Request

DPI = 120


def write_report(
    folder: Path, about: dict[str, object], request: Request, outcome: Outcome
) -> None:
    """Write into an existing folder; OSError if that cannot be.

    Args:
        folder: where.
        about: what the experiment is; comes first in the report.
        request: what was asked.
        outcome: what came of it.
    """
    for name, figure in outcome.plots.items():
        figure.savefig(folder / f"{name}.png", dpi=DPI)
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
    report = about | {"runs": request.runs, "seed": request.seed} | dict(outcome.report)
    report["plots"] = sorted(outcome.plots)
    text = json.dumps(report, indent=2, allow_nan=False)
    (folder / "report.json").write_text(text + "\n", "utf-8")
