"""Run the gateway: `python -m pilotage.gateway --deployment FILE`."""

from pilotage.bus.runner import run_service
from pilotage.gateway.config import GatewaySettings
from pilotage.gateway.server import serve
from pilotage.gateway.service import GatewayService

if __name__ == "__main__":
    raise SystemExit(run_service("gateway", GatewaySettings, GatewayService, serve))
