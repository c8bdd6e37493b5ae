"""`pilotage up` with toys in its process table: `python -m toys.up DEPLOYMENT`."""

import sys
from dataclasses import replace
from pathlib import Path

from pilotage.bus.deployment import ConfigError
from pilotage.bus.runner import complain
from pilotage.launcher.effective import Overrides
from pilotage.launcher.process_table import PROCESSES, Entry, named
from pilotage.launcher.run import launch


def toy(name: str) -> Entry:
    """Return the table's line for a toy."""
    return Entry(name, f"toys.{name}", "toys.config:ToySettings", ("router",), named(name))


REAL = tuple(
    replace(entry, module="toys.mapper") if entry.name == "mapper" else entry for entry in PROCESSES
)
"""The real services, but for a mapper that maps by dead reckoning."""

TABLE = (*REAL, toy("ann"), toy("ben"))


def main() -> int:
    """Run the deployment of the command line."""
    try:
        return launch(Path(sys.argv[1]), Overrides(), table=TABLE)
    except ConfigError as error:
        return complain("toys", error, 2)


if __name__ == "__main__":
    raise SystemExit(main())
