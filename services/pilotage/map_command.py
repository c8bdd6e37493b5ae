"""`pilotage map`: a recorded log in, a map, the robot's way and a report out."""

import json
import os
import resource
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

from pilotage.bus.deployment import ConfigError
from pilotage.core.logs import Log, Record, ScanRecord, SonarRecord, read_log
from pilotage.core.map_files import save_map_files
from pilotage.mapper.log_run import LogUse, map_records, records_of, sensor_of
from pilotage.mapper.map_products import MAP_FILE, FinishedMap, finish, products
from pilotage.mapper.method import MappingMethod
from pilotage.mapper.methods import MappingSetup, make_method

PICTURE_FILE, REPORT_FILE = "map.png", "report.json"

SEED = 0
"""Of all dice, so that a log gives the same map again."""


@dataclass(frozen=True)
class MapOptions:
    """What the command line says; None leaves the sensor to the log, all beams, the best model."""

    log: Path
    log_format: str | None
    out: Path
    sensor: str | None = None
    beams: int | None = None
    model: str | None = None


def map_log(options: MapOptions) -> None:
    """Write the files of the map into DIR; ConfigError or OSError if that cannot be."""
    started, started_cpu = time.perf_counter(), time.process_time()
    log, records, method = _inputs(options)
    _make_folder(options.out)
    costs = _run(records, method)
    finished = finish(method)
    files = _files(finished, method.name)
    report = {
        "scans": len(costs),
        "wall_s": time.perf_counter() - started,
        "cpu_s": time.process_time() - started_cpu,
        "cpu_ms_per_scan": _percentiles(costs),
        "peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        "log_duration_s": log.duration,
        "log_format": log.format,
        "skipped_lines": log.skipped_lines,
        "sensor": method.name,
        "method": type(method).__name__,
        **_told_of(finished),
    }
    files[REPORT_FILE] = (json.dumps(report, indent=2) + "\n").encode()
    save_map_files(options.out / MAP_FILE, files)


def _inputs(options: MapOptions) -> tuple[Log, list[Record], MappingMethod]:
    """Return the log, what is used of it, and a method to feed with that."""
    try:
        log = read_log(options.log, options.log_format)
        sensor = options.sensor or sensor_of(log)
        if options.beams is not None and sensor != "laser":
            raise ConfigError("--beams thins the laser's scans; the sonar has none to spare")
        method = make_method(sensor, MappingSetup(options.model, np.random.default_rng(SEED)))
        return log, records_of(log, LogUse(sensor, options.beams)), method
    except ValueError as error:
        raise ConfigError(str(error)) from error


def _make_folder(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as error:
        raise ConfigError(f"--out takes a folder; {error.filename} is a file") from error
    except OSError as error:
        raise ConfigError(f"--out {out}: cannot be made: {error.strerror}") from error
    # Now, not after minutes of mapping.
    if not os.access(out, os.W_OK | os.X_OK):
        raise ConfigError(f"--out {out}: nothing can be written there")


def _run(records: list[Record], method: MappingMethod) -> list[float]:
    """Feed the method; return the processor time in ms of each scan and what came before it."""
    total = sum(isinstance(record, ScanRecord | SonarRecord) for record in records)
    costs: list[float] = []
    with _progress(total) as advance:
        before = time.process_time()
        for _ in map_records(records, method):
            now = time.process_time()
            costs.append((now - before) * 1e3)
            advance()
            before = now
    return costs


def _files(finished: FinishedMap, name: str) -> dict[str, bytes]:
    # Imported here: drawing takes half a second to import, which errors need not wait for.
    from pilotage.map_picture import map_picture  # noqa: PLC0415 - see above

    if not (finished.world.cells >= 0).any():
        raise ConfigError("the log shows nothing to map: no cell was seen free or occupied")
    title = f"{name}: {finished.free_area:.0f} m² seen free, {finished.way_length:.0f} m driven"
    picture = map_picture(finished.world, finished.poses, title)
    return {**products(finished), PICTURE_FILE: picture}


def _told_of(finished: FinishedMap) -> dict[str, float]:
    return {
        "keyframes": len(finished.graph.stamps),
        "closures": int(finished.graph.is_closure.sum()),
        "resolution_m": finished.world.geometry.resolution,
        "free_m2": finished.free_area,
        "driven_m": finished.way_length,
    }


def _percentiles(costs: list[float]) -> dict[str, float]:
    return {"p50": float(np.percentile(costs, 50)), "p95": float(np.percentile(costs, 95))}


@contextmanager
def _progress(total: int) -> Iterator[Callable[[], None]]:
    """Show a bar on a terminal, nothing elsewhere."""
    columns = "mapping", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    console = Console(file=sys.stderr)
    with Progress(*columns, console=console, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("mapping", total=total)
        yield lambda: bar.advance(task)
