"""Runs the localizer: `python -m pilotage.localizer --deployment FILE`."""

from pilotage.bus.runner import run_service
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.service import LocalizerService

if __name__ == "__main__":
    raise SystemExit(run_service("localizer", LocalizerSettings, LocalizerService))
