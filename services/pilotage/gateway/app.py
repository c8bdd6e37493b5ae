"""The gateway as an ASGI application."""

import pilotage
from pilotage.gateway.access import Access
from pilotage.gateway.guard import Guard
from pilotage.gateway.openapi import DescribedApi
from pilotage.gateway.problems import add_problem_handlers
from pilotage.gateway.routes import (
    commands,
    library,
    maps,
    page,
    planning,
    robots,
    sensors,
    streams,
    topologies,
    topology,
)
from pilotage.gateway.service import GatewayService

DESCRIPTION = """Where the robot is, how sure it is of that, and what it can be told to do.

Units are SI and radians; poses are of `base_link` in `map`; x forward, y left, theta
counter-clockwise. Stamps are Unix time in ns. Errors are problem documents (RFC 9457).
`/api/v1/robots/{robot_id}/stream` is a WebSocket with everything live, in CBOR.
"""


def create_app(service: GatewayService, access: Access) -> Guard:
    """Return the application that serves `service` to those whom `access` lets in."""
    app = DescribedApi(
        service.robot,
        access,
        title="Pilotage",
        version=pilotage.__version__,
        description=DESCRIPTION,
        openapi_url="/api/v1/openapi.json",
        # Their pages load code from elsewhere; no request leaves this machine.
        docs_url=None,
        redoc_url=None,
        redirect_slashes=False,
    )
    app.state.service = service
    add_problem_handlers(app)
    described = (page, robots, planning, maps, library, topology, topologies, sensors)
    for module in (*described, commands, streams):
        app.include_router(module.router)
    app.mount("/static", page.PageFiles(directory=page.WEB, check_dir=False))
    return Guard(app, access)
