"""Runs the mapper: `python -m pilotage.mapper --deployment FILE`."""

from pilotage.bus.runner import run_service
from pilotage.mapper.config import MapperSettings
from pilotage.mapper.service import MapperService

if __name__ == "__main__":
    raise SystemExit(run_service("mapper", MapperSettings, MapperService))
