"""`pilotage experiment`: one experiment of the papers, its figures and its plots in a folder."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile

from rich.console import Console
from rich.progress import Progress

from pilotage.bus.deployment import ConfigError
from pilotage.experiments.catalogue import CATALOGUE, Experiment
from pilotage.experiments.outcome import Request
from pilotage.experiments.report import write_report


@dataclass(frozen=True)
class ExperimentOptions:
    """What the command line says; `runs` None is as many as the experiment usually takes."""

    name: str
    runs: int | None
    seed: int
    out: Path | None


def list_experiments() -> None:
    """Print a line for each experiment: its name, what it shows, its paper."""
    width = max(map(len, CATALOGUE))
    for name, experiment in CATALOGUE.items():
        sys.stdout.write(f"{name:<{width}}  {experiment.title} ({experiment.paper})\n")


def run_experiment(options: ExperimentOptions) -> None:
    """Conduct an experiment and write its report; ConfigError or OSError if that cannot be."""
    experiment = _experiment(options.name)
    if options.out is None:
        raise ConfigError(f"experiment {options.name} needs --out DIR for its report and plots")
    _make_writable(options.out)
    runs = experiment.usual_runs if options.runs is None else options.runs
    request = Request(runs, options.seed)
    started, started_cpu = time.perf_counter(), time.process_time()
    with _progress(options.name) as advance:
        outcome = experiment.conduct(request, advance)
    about = {
        "experiment": options.name,
        "shows": experiment.title,
        "paper": experiment.paper,
        "wall_s": time.perf_counter() - started,
        "cpu_s": time.process_time() - started_cpu,
    }
    write_report(options.out, about, request, outcome)


def _experiment(name: str) -> Experiment:
    if name not in CATALOGUE:
        known = ", ".join(CATALOGUE)
        raise ConfigError(f"there is no experiment '{name}'; there are {known}")
    return CATALOGUE[name]


def _make_writable(folder: Path) -> None:
    """Make the folder; OSError before any work is done if nothing can be written there."""
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryFile(dir=folder):
        pass


@contextmanager
def _progress(name: str) -> Iterator[Callable[[float], None]]:
    """Show a bar on a terminal, nothing elsewhere."""
    with Progress(console=Console(file=sys.stderr), disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(name, total=1.0)
        yield lambda share: bar.advance(task, share)
