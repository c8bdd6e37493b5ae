"""Runs the planner: `python -m pilotage.planner --deployment FILE`."""

from pilotage.bus.runner import run_service
from pilotage.planner.config import PlannerSettings
from pilotage.planner.service import PlannerService

if __name__ == "__main__":
    raise SystemExit(run_service("planner", PlannerSettings, PlannerService))
