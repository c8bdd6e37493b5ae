"""Runs the robot service: `python -m pilotage.robot --deployment FILE`."""

from pilotage.bus.runner import run_service
from pilotage.robot.config import RobotSettings
from pilotage.robot.service import RobotService, live

if __name__ == "__main__":
    raise SystemExit(run_service("robot", RobotSettings, RobotService, live))
