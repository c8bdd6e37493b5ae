"""`pilotage trial`: how far a robot drives on a map until it is localized, policy by policy."""

import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np
from rich.console import Console
from rich.progress import Progress

from pilotage.bus.deployment import ConfigError
from pilotage.core.map_files import MapFileError, load_map
from pilotage.experiments.report import DPI
from pilotage.experiments.trial_entrants import POLICIES
from pilotage.experiments.trial_plots import track_figure
from pilotage.experiments.trial_report import report_of
from pilotage.experiments.trial_run import TrialRun, conduct_trial
from pilotage.experiments.trial_starts import SIGHTS, Starts, find_starts
from pilotage.experiments.trial_world import TrialWorld
from pilotage.localizer.methods import MethodSetup, make_method

METHOD, METHOD_SEED = "markov", 0


@dataclass(frozen=True)
class TrialOptions:
    """What the command line says; `sight` [m] None is the longest with enough starts."""

    map: Path
    policy: str
    runs: int
    seed: int
    out: Path
    sight: float | None = None


def trial(options: TrialOptions) -> None:
    """Write DIR/report.json and DIR/tracks.png; ConfigError or OSError if that cannot be."""
    if options.policy not in POLICIES:
        raise ConfigError(f"there is no policy '{options.policy}'; there are {', '.join(POLICIES)}")
    options.out.mkdir(parents=True, exist_ok=True)
    with TemporaryFile(dir=options.out):  # an OSError now rather than after all the work
        pass
    started, started_cpu = time.perf_counter(), time.process_time()
    try:
        world = _world(options.map)
        starts, runs = _conducted(world, options)
    except MapFileError as error:  # which names the file
        raise ConfigError(str(error)) from error
    except ValueError as error:
        raise ConfigError(f"{options.map}: {error}") from error
    about = {
        "map": options.map.name,
        "policy": options.policy,
        "seed": options.seed,
        "wall_s": time.perf_counter() - started,
        "cpu_s": time.process_time() - started_cpu,
    }
    text = json.dumps(about | report_of(starts, runs), indent=2, allow_nan=False)
    (options.out / "report.json").write_text(text + "\n", "utf-8")
    title = f"{options.map.stem}, {options.policy}, sight {starts.range_max:g} m"
    track_figure(world.world, runs, title).savefig(options.out / "tracks.png", dpi=DPI)


def _world(file: Path) -> TrialWorld:
    world = load_map(file)
    localizer = make_method(METHOD, world, MethodSetup(), np.random.default_rng(METHOD_SEED))
    return TrialWorld.of(world, localizer)


def _conducted(world: TrialWorld, options: TrialOptions) -> tuple[Starts, list[TrialRun]]:
    """Return where the runs began and what came of each."""
    sights = SIGHTS if options.sight is None else (options.sight,)
    with _progress("looking for starts", None) as advance:
        starts = find_starts(world, options.runs, options.seed, sights, advance)
    seen = world.seen_by(replace(world.robot.laser, range_max=starts.range_max))
    make_policy = POLICIES[options.policy](seen)
    runs = []
    with _progress(f"driving: {options.policy}", options.runs) as advance:
        for index, start in enumerate(starts.poses):
            # The same noise for every policy, whatever chance the policy itself makes use of.
            noise, chance = (np.random.default_rng([options.seed, s, index]) for s in (2, 3))
            policy = make_policy(chance)
            runs.append(conduct_trial(seen, policy, start, noise, time.process_time))
            advance(1.0)
    return starts, runs


@contextmanager
def _progress(name: str, total: int | None) -> Iterator[Callable[[float], None]]:
    """Show a bar on a terminal, nothing elsewhere."""
    with Progress(console=Console(file=sys.stderr), disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(name, total=total)
        yield lambda done: bar.advance(task, done)
