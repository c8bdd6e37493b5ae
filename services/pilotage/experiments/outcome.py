"""What an experiment is asked and what it hands back."""

from collections.abc import Mapping
from dataclasses import dataclass

from matplotlib.figure import Figure


@dataclass(frozen=True)
class Request:
    """How often to repeat an experiment, and the seed of its chances."""

    runs: int
    seed: int


@dataclass(frozen=True)
class Outcome:
    """Figures for `report.json` (plain values), and plots by the name of their files."""

    report: Mapping[str, object]
    plots: Mapping[str, Figure]
