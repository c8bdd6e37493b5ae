"""Whether the localizer finds a robot in real buildings, and whether it knows that it does.

    .venv/bin/python tests/benchmarks/building_trials.py OUT [RUNS] [MAP ...]

For the own office and every map of ../shared/datasets/maps: RUNS simulated tracks from an unknown
start per case (see CASES, and experiments/clutter for the conditions). Printed per map and case:
runs that end localized and right, that end honestly ambiguous, scans to the fix (median), fixes
within 10 scans, scans that said `localized` and were wrong, median error, processor time per
scan. OUT gets trials.json, the raw figures, and calibration.png and .svg, the reliability of
`confidence`.
"""

import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np

mpl.use("Agg")

from matplotlib import pyplot as plt

from pilotage.core.grid import OccupancyMap
from pilotage.core.map_files import load_map
from pilotage.experiments.clutter import CONDITIONS
from pilotage.experiments.trials import Outcome, run_trial, simulated_track
from pilotage.localizer.markov_localizer import MarkovLocalizer, MarkovParams
from pilotage.robot.simulator.floor_plans import office_floor

MAPS = Path(__file__).resolve().parents[3] / "shared" / "datasets" / "maps"
CASES: dict[str, tuple[str, tuple[int, ...], float]] = {
    "clean": ("clean", (30,), 1.0),
    "hard": ("hard", (60,), 1.0),
    "hard, kidnapped": ("hard", (30, 30), 1.0),
    "extreme": ("extreme", (80,), 0.4),
}
"""Condition, scans of each part of a track, and share of the runs."""

BINS = 10


def world_of(name: str) -> OccupancyMap:
    """Return a map by its name."""
    return office_floor() if name == "office" else load_map(MAPS / f"{name}.yaml")


def names_of_maps() -> list[str]:
    """Return the maps at hand; those of doors and rooms are none."""
    files = (file.name for file in MAPS.glob("*.yaml"))
    return ["office", *sorted(name.removesuffix(".yaml") for name in files if name.count(".") == 1)]


def trials_on(name: str, runs: int) -> list[dict[str, Any]]:
    """Return the figures of all runs of all cases on a map, one row per case."""
    world = world_of(name)
    localizer = MarkovLocalizer(world, MarkovParams())
    rows = []
    for case, (condition, lengths, share) in CASES.items():
        outcomes, spent = [], 0.0
        for seed in range(round(runs * share)):
            track = simulated_track(world, CONDITIONS[condition], lengths, 1_000_003 * seed + 7)
            begun = time.process_time()
            outcomes.append(run_trial(localizer, track))
            spent += time.process_time() - begun
        rows.append({"map": name, "case": case, **figures(outcomes), "cpu_s": spent})
    return rows


def figures(outcomes: list[Outcome]) -> dict[str, Any]:
    """Return what runs of one case are worth, and their (confidence, right) pairs."""
    fixes = [outcome.scans_to_fix(outcome.kidnapped or 0) for outcome in outcomes]
    sure = [o.way[o.localized & o.right] for o in outcomes]
    return {
        "runs": len(outcomes),
        "right": sum(o.ends_right for o in outcomes),
        "ambiguous": sum(o.ends_ambiguous for o in outcomes),
        "scans_to_fix": [fix if fix is not None else -1 for fix in fixes],
        "scans": sum(len(o.way) for o in outcomes),
        "wrong": [int(o.wrong.sum()) for o in outcomes],
        "localized": float(np.mean([o.localized.mean() for o in outcomes])),
        "error_m": float(np.median(np.concatenate(sure))) if any(map(len, sure)) else None,
        "confidence": np.concatenate([o.confidence for o in outcomes]).round(4).tolist(),
        "was_right": np.concatenate([o.right for o in outcomes]).astype(int).tolist(),
    }


def line(row: dict[str, Any]) -> str:
    """Return a row of the table."""
    fixes = [fix for fix in row["scans_to_fix"] if fix > 0]
    median = np.median([fix if fix > 0 else 1e3 for fix in row["scans_to_fix"]])
    error = "-" if row["error_m"] is None else f"{100 * row['error_m']:.1f}"
    return (
        f"| {row['map']} | {row['case']} | {row['right']}/{row['runs']} | {row['ambiguous']} "
        f"| {median:.0f} | {sum(fix <= 10 for fix in fixes)}/{row['runs']} "
        f"| {100 * sum(row['wrong']) / row['scans']:.2f} | {100 * row['localized']:.0f} | {error} "
        f"| {1e3 * row['cpu_s'] / row['scans']:.0f} |"
    )


def reliability(rows: list[dict[str, Any]]) -> tuple[list[tuple[float, float, int]], float]:
    """Return (mean confidence, share right, scans) of each bin, and the calibration error."""
    said = np.concatenate([row["confidence"] for row in rows])
    right = np.concatenate([row["was_right"] for row in rows])
    bins = np.minimum((said * BINS).astype(int), BINS - 1)
    points = []
    for index in range(BINS):
        chosen = bins == index
        if chosen.any():
            points.append((said[chosen].mean(), right[chosen].mean(), int(chosen.sum())))
    error = sum(count * abs(mean - share) for mean, share, count in points) / len(said)
    return points, float(error)


def draw(points: list[tuple[float, float, int]], error: float, out: Path) -> None:
    """Draw the reliability plot."""
    figure, (top, bottom) = plt.subplots(
        2, 1, figsize=(5, 6), sharex=True, height_ratios=(3, 1), layout="constrained"
    )
    said, share, counts = (np.array(part) for part in zip(*points, strict=True))
    top.plot([0, 1], [0, 1], color="0.7")
    top.plot(said, share, "o-")
    top.set(ylabel="share that was right", title=f"calibration error {error:.3f}")
    bottom.bar(said, counts, width=0.05)
    bottom.set(xlabel="confidence", ylabel="scans", yscale="log")
    for ending in ("png", "svg"):
        figure.savefig(out / f"calibration.{ending}")


def main() -> None:
    """Run the trials named on the command line."""
    out = Path(sys.argv[1])
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 20
    names = sys.argv[3:] or names_of_maps()
    out.mkdir(parents=True, exist_ok=True)
    print("| map | case | right | ambiguous | median scans to fix | within 10 | wrong % |", end="")
    print(" localized % | error cm | CPU ms a scan |\n|" + " --- |" * 10, flush=True)
    rows: list[dict[str, Any]] = []
    with ProcessPoolExecutor(2) as pool:
        for of_map in pool.map(trials_on, names, [runs] * len(names)):
            rows.extend(of_map)
            print("\n".join(line(row) for row in of_map), flush=True)
            (out / "trials.json").write_text(json.dumps(rows))
    points, error = reliability(rows)
    draw(points, error, out)
    print(f"\ncalibration error {error:.4f}:")
    print("\n".join(f"  said {said:.2f} right {share:.2f} ({n})" for said, share, n in points))


if __name__ == "__main__":
    main()
