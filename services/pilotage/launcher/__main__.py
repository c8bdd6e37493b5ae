"""Runs the launcher: `python -m pilotage.launcher --deployment FILE` (as `pilotage up FILE`)."""

import argparse
from pathlib import Path

from pilotage.bus.deployment import ConfigError
from pilotage.bus.runner import complain
from pilotage.launcher.effective import Overrides
from pilotage.launcher.run import launch


def main() -> int:
    """Run the deployment; 2 with one line when it cannot be run."""
    parser = argparse.ArgumentParser("pilotage.launcher")
    parser.add_argument("--deployment", type=Path, required=True, help="YAML file of the run")
    try:
        return launch(parser.parse_args().deployment, Overrides())
    except ConfigError as error:
        return complain("launcher", error, 2)


if __name__ == "__main__":
    raise SystemExit(main())
