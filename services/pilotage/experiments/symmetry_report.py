"""What walks through a symmetric place show, in figures for `report.json`; pure."""

from pilotage.experiments.ranger_localizer import CELL
from pilotage.experiments.ranger_robot import TURN
from pilotage.experiments.symmetric_walk import Shown, Symmetry, Walk, errors, spread_of_masses

EQUAL = 0.05
"""Masses this close to each other, as a share, count as equal (the issue's limit)."""


def symmetry_report(walks: list[Walk], symmetry: Symmetry, settled_m: int) -> dict[str, object]:
    """Return both conditions measured, one value per shown place, all runs one after another.

    Args:
        walks: one per run.
        symmetry: of the place.
        settled_m: the claims hold from this metre on.
    """
    without = [shown for walk in walks for shown in walk.without_compass[settled_m - 1 :]]
    compass = [shown for walk in walks for shown in walk.with_compass[settled_m - 1 :]]
    return {
        "claims_hold_from_m": settled_m,
        "without_compass": _measured(without, symmetry) | _all_modes(walks, "without_compass"),
        "with_compass": _measured(compass, Symmetry(1, symmetry.middle))
        | _all_modes(walks, "with_compass"),
    }


def _measured(shown: list[Shown], symmetry: Symmetry) -> dict[str, object]:
    """Return how many modes there are, how alike, and how far from the truth and its images."""
    counts = [len(place.modes) for place in shown]
    spreads = [spread_of_masses(place.modes[: symmetry.fold]) for place in shown]
    off = [errors(place.modes[: symmetry.fold], symmetry.images(place.truth)) for place in shown]
    return {
        "expected_modes": symmetry.fold,
        "always_as_expected": all(count == symmetry.fold for count in counts),
        "mass_spread": max(spreads),
        "equal_within_5_percent": max(spreads) <= EQUAL,
        "within_a_cell_and_a_bin": all(distance <= CELL and turn <= TURN for distance, turn in off),
        "mass_elsewhere": max(1.0 - sum(mode.mass for mode in place.modes) for place in shown),
        "error_m": max(distance for distance, _ in off),
        "error_rad": max(turn for _, turn in off),
        "errors_m": [distance for distance, _ in off],
        "errors_rad": [turn for _, turn in off],
        "mass_spreads": spreads,
    }


def _all_modes(walks: list[Walk], condition: str) -> dict[str, object]:
    """Return the number of modes and their masses at every shown place, from the first metre."""
    shown = [place for walk in walks for place in getattr(walk, condition)]
    return {
        "modes": [len(place.modes) for place in shown],
        "masses": [[mode.mass for mode in place.modes] for place in shown],
    }
