"""The mapper with dead reckoning in place of its methods: `python -m toys.mapper`."""

from dead_reckoning_mapping import DeadReckoningMapping
from pilotage.bus.deployment import Deployment
from pilotage.bus.node import Node
from pilotage.bus.runner import run_service
from pilotage.mapper.config import MapperSettings
from pilotage.mapper.service import MapperService


def build(settings: MapperSettings, node: Node, deployment: Deployment) -> MapperService:
    """Return the service."""
    return MapperService(settings, node, deployment, lambda _sensor: DeadReckoningMapping())


if __name__ == "__main__":
    raise SystemExit(run_service("mapper", MapperSettings, build))
