"""Runs the topology service: python -m pilotage.topology --deployment FILE."""

from pilotage.bus.runner import run_service
from pilotage.topology.config import TopologySettings
from pilotage.topology.service import TopologyService

if __name__ == "__main__":
    raise SystemExit(run_service("topology", TopologySettings, TopologyService))
