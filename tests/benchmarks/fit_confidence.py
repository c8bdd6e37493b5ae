"""Find the weights of confidence.py: how often was the best place right, given its signs?

    PYTHONPATH=tests .venv/bin/python tests/benchmarks/fit_confidence.py [RUNS] [MAP ...]

Simulated tracks of 60 scans through the maps of ../shared/datasets/maps (or PILOTAGE_DATA), clean,
hard, badly drawn, extreme, kidnapped, and through a building other than the mapped one, whose scans
count half. Logistic regression; printed are the weights, and the calibration error on each map when
the weights come from all others.
"""

import sys

import numpy as np
from numpy.typing import NDArray

from benchmarks.building_trials import names_of_maps, world_of
from pilotage.experiments.clutter import CONDITIONS
from pilotage.experiments.trials import run_trial, simulated_track
from pilotage.localizer.confidence import features
from pilotage.localizer.markov_localizer import MarkovLocalizer, MarkovParams

WHOLE: tuple[int, ...] = (60,)
KIDNAPPED: tuple[int, ...] = (30, 30)
CASES = [("clean", WHOLE), ("hard", WHOLE), ("rough", WHOLE), ("extreme", WHOLE)]
CASES += [("hard", KIDNAPPED)]
ELSEWHERE = ("clean", "hard")
RIDGE = 1e-2

COUNTS_ELSEWHERE = 0.5

Signed = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
"""Features (n, k), whether the estimate was right (n,), and how much each counts (n,)."""


def signs_on(name: str, other: str, runs: int) -> Signed:
    """Return the signs of all scans on a map and in a building that is not on it."""
    world, elsewhere = world_of(name), world_of(other)
    localizer = MarkovLocalizer(world, MarkovParams())
    rows, right, counts = [], [], []
    for seed in range(runs):
        tracks = [
            (simulated_track(world, CONDITIONS[case], lengths, 7919 * seed + 3), True)
            for case, lengths in CASES
        ]
        case = ELSEWHERE[seed % len(ELSEWHERE)]
        tracks.append((simulated_track(elsewhere, CONDITIONS[case], WHOLE, 7919 * seed + 5), False))
        for track, is_mapped in tracks:
            outcome = run_trial(localizer, track)
            for signs, was_right in zip(outcome.signs, outcome.right, strict=True):
                if signs is not None:
                    rows.append(features(signs))
                    right.append(was_right and is_mapped)
                    counts.append(1.0 if is_mapped else COUNTS_ELSEWHERE)
    return np.array(rows), np.array(right, float), np.array(counts)


def regression(signed: list[Signed]) -> NDArray[np.float64]:
    """Return bias and weights (k + 1,): Newton's method on the log-likelihood, with a ridge."""
    x = np.concatenate([np.column_stack([np.ones(len(f)), f]) for f, _, _ in signed])
    y, counts = (np.concatenate([part[index] for part in signed]) for index in (1, 2))
    weights = np.zeros(x.shape[1])
    for _ in range(40):
        p = 1.0 / (1.0 + np.exp(-x @ weights))
        curvature = (x * (counts * p * (1.0 - p))[:, None]).T @ x + RIDGE * np.eye(len(weights))
        weights += np.linalg.solve(curvature, x.T @ (counts * (y - p)) - RIDGE * weights)
    return weights


def calibration_error(signed: Signed, weights: NDArray[np.float64]) -> float:
    """Return the expected calibration error over ten bins."""
    rows, right, _ = signed
    said = 1.0 / (1.0 + np.exp(-weights[0] - rows @ weights[1:]))
    bins = np.minimum((10.0 * said).astype(int), 9)
    chosen = [bins == index for index in range(10)]
    return float(sum(abs((said[c] - right[c]).sum()) for c in chosen) / len(said))


def main() -> None:
    """Print the weights from all maps, and how they do on maps that they were not found on."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 4
    names = sys.argv[2:] or names_of_maps()
    neighbours = names[1:] + names[:1]
    signed = [signs_on(name, other, runs) for name, other in zip(names, neighbours, strict=True)]
    for index, name in enumerate(names):
        others = regression(signed[:index] + signed[index + 1 :])
        print(f"{name}: calibration error {calibration_error(signed[index], others):.3f}")
    print("bias and weights:", np.round(regression(signed), 3).tolist())


if __name__ == "__main__":
    main()
