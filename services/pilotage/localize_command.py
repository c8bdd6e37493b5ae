"""`pilotage localize`: a recorded log and a map in, a table of estimates and a report out."""

import csv
import json
import resource
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import Progress

from pilotage.bus.deployment import ConfigError
from pilotage.core.logs import Log, ScanRecord, SonarRecord, read_log
from pilotage.core.map_files import load_map
from pilotage.localizer.ekf_localizer import EkfLocalizer
from pilotage.localizer.log_run import LogEstimate, LogSensors, localize_log
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.method import LocalizationMethod
from pilotage.localizer.methods import MethodSetup, make_method, require_method
from pilotage.localizer.particle_localizer import ParticleLocalizer

SEED = 0
"""Of the particles: two runs over one log say the same."""

START_COVARIANCE = np.diag([0.25, 0.25, np.deg2rad(15.0) ** 2])
"""What a start pose given by hand is taken to be good for: 0.5 m and 15 degrees."""


@dataclass(frozen=True)
class LocalizeOptions:
    """What the command line says: files, the start pose (None is unknown) and the sensors."""

    log: Path
    log_format: str | None
    map: Path
    out: Path
    start: NDArray[np.float64] | None
    sensors: LogSensors
    method: str = "markov"


def parse_start(text: str) -> NDArray[np.float64] | None:
    """Return the pose (3,) in `X,Y,THETA`, or None for `unknown`; ConfigError otherwise."""
    if text == "unknown":
        return None
    try:
        pose = np.array([float(part) for part in text.split(",")])
    except ValueError:
        pose = np.empty(0)
    if pose.shape != (3,) or not np.isfinite(pose).all():
        raise ConfigError(f"--start takes 'unknown' or X,Y,THETA in m and rad, not '{text}'")
    return pose


def localize(options: LocalizeOptions) -> None:
    """Write DIR/estimates.csv and DIR/report.json; ConfigError or OSError if that cannot be."""
    started, started_cpu = time.perf_counter(), time.process_time()
    log, localizer = _inputs(options)
    _tell_of_coarser_cells(localizer)
    _tell_of_missing_start(localizer, options.start)
    total = _scans_of(log, options.sensors)
    _make_folder(options.out)
    updates: list[float] = []
    scans = 0
    with _estimates_file(options.out) as write, _progress(total) as advance:
        for estimate in _timed(localize_log(log, localizer, options.sensors), updates):
            write(estimate)
            advance()
            scans += 1
    report = {
        "method": localizer.name,
        "scans": scans,
        "wall_s": time.perf_counter() - started,
        "cpu_s": time.process_time() - started_cpu,
        "cpu_ms_per_update": _percentiles(updates),
        "peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        "skipped_lines": log.skipped_lines,
        **_size(localizer),
    }
    (options.out / "report.json").write_text(json.dumps(report, indent=2) + "\n", "utf-8")


def _make_folder(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise ConfigError(f"--out takes a folder; {out} is a file") from error
    except OSError as error:
        raise ConfigError(f"--out {out}: cannot be made: {error.strerror}") from error


def _size(localizer: LocalizationMethod) -> dict[str, Any]:
    """Return how finely the method believes; `coarsened` if the map is too large for finer."""
    if isinstance(localizer, ParticleLocalizer):
        return {"particles": len(localizer.filter.poses)}
    if isinstance(localizer, MarkovLocalizer):
        grid = localizer.grid.grid
        resolution = grid.geometry.resolution
        states = int(np.prod(grid.shape))
        return {"states": states, "resolution_m": resolution, "coarsened": grid.is_coarsened}
    if isinstance(localizer, EkfLocalizer):
        return {"map_lines": localizer.map_lines}
    return {}


def _tell_of_missing_start(
    localizer: LocalizationMethod, start: NDArray[np.float64] | None
) -> None:
    if isinstance(localizer, EkfLocalizer) and start is None:
        sys.stderr.write(
            "pilotage: ekf follows a robot but finds none: without --start X,Y,THETA (or, on the "
            "bus, the topology service) its pose stays unknown\n"
        )


def _tell_of_coarser_cells(localizer: LocalizationMethod) -> None:
    if isinstance(localizer, MarkovLocalizer) and localizer.grid.grid.is_coarsened:
        grid = localizer.grid.grid
        sys.stderr.write(
            f"pilotage: the map is too large for cells of {grid.asked_resolution:g} m: "
            f"it is localized on with cells of {grid.geometry.resolution:.3g} m\n"
        )


def _inputs(options: LocalizeOptions) -> tuple[Log, LocalizationMethod]:
    """Return the log and a localizer on the map, at the start pose."""
    try:
        require_method(options.method)
        log = read_log(options.log, options.log_format)
        world, rng = load_map(options.map), np.random.default_rng(SEED)
        localizer = make_method(options.method, world, MethodSetup(), rng)
        if options.start is not None:
            localizer.start_at(options.start, START_COVARIANCE)
    except ValueError as error:
        raise ConfigError(str(error)) from error
    return log, localizer


def _scans_of(log: Log, use: LogSensors) -> int:
    kind = ScanRecord if use.sensor == "laser" else SonarRecord
    count = sum(isinstance(record, kind) for record in log.records)
    if count == 0:
        raise ConfigError(f"the log has no {use.sensor} measurements")
    return count


def _timed(estimates: Iterator[LogEstimate], updates: list[float]) -> Iterator[LogEstimate]:
    """Pass estimates on, adding the processor time of each update in ms to `updates`."""
    before = time.process_time()
    for estimate in estimates:
        if estimate.updated:
            updates.append((time.process_time() - before) * 1e3)
        yield estimate
        before = time.process_time()


def _percentiles(updates: list[float]) -> dict[str, float | None]:
    if not updates:
        return {"p50": None, "p95": None, "first": None}
    return {
        "p50": float(np.percentile(updates, 50)),
        "p95": float(np.percentile(updates, 95)),
        "first": updates[0],
    }


@contextmanager
def _estimates_file(out: Path) -> Iterator[Any]:
    with (out / "estimates.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["stamp", "x", "y", "theta", "state", "confidence"])

        def write(row: LogEstimate) -> None:
            x, y, theta = row.pose
            state, confidence = row.estimate.state, row.estimate.confidence
            numbers = [f"{row.stamp:.6f}", f"{x:.4f}", f"{y:.4f}", f"{theta:.5f}"]
            writer.writerow([*numbers, state, f"{confidence:.4f}"])

        yield write


@contextmanager
def _progress(total: int) -> Iterator[Any]:
    """Show a bar on a terminal, nothing elsewhere."""
    with Progress(console=Console(file=sys.stderr), disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("localizing", total=total)
        yield lambda: bar.advance(task)
