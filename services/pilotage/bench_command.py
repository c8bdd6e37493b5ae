"""`pilotage bench`: the localizer timed beside its plain twin, in a file and a table."""

import json
import resource
import sys
import time
from pathlib import Path
from tempfile import TemporaryFile

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from pilotage.bench.entry import Entry, Stopwatch
from pilotage.bench.suite import ENTRIES, run_suite
from pilotage.bus.deployment import ConfigError


def bench(out: Path) -> None:
    """Write a list of entries as JSON and print them; ConfigError or OSError if that cannot be."""
    _refuse_unwritable(out)
    entries: list[Entry] = []
    terminal = Console(file=sys.stderr)
    with Progress(console=terminal, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task("measuring", total=ENTRIES)
        for entry in run_suite(Stopwatch(time.process_time), _peak_mb):
            entries.append(entry)
            bar.advance(task)
    text = json.dumps([entry.as_json() for entry in entries], indent=2, allow_nan=False)
    out.write_text(text + "\n", "utf-8")
    Console(file=sys.stdout, width=None if sys.stdout.isatty() else 140).print(table_of(entries))


def table_of(entries: list[Entry]) -> Table:
    """Return the entries as a table for people."""
    table = Table()
    table.add_column("case")
    for heading in ("size", "beams", "processor ms", "plain numpy ms", "ratio", "more"):
        table.add_column(heading, justify="right")
    for entry in entries:
        table.add_row(
            entry.name,
            f"{entry.size.count:,} {entry.size.kind}",
            str(entry.size.beams),
            f"{entry.cpu_ms:.{1 if entry.cpu_ms >= 1.0 else 3}f}",
            f"{entry.reference_cpu_ms:,.0f}",
            f"{entry.reference_cpu_ms / max(entry.cpu_ms, 1e-3):.0f}",
            ", ".join(f"{name} {value:,.1f}" for name, value in entry.extra.items()),
        )
    return table


def _refuse_unwritable(out: Path) -> None:
    """Say now, and not after minutes of work, that a file cannot be written."""
    if out.is_dir():
        raise ConfigError(f"{out} is a folder: name a file")
    with TemporaryFile(dir=out.parent):
        pass


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
