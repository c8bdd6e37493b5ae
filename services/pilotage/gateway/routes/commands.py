"""Commands: one route per query of the registry, so that each is documented with its types."""

from collections.abc import Awaitable, Callable
from typing import Any

from fastapi import APIRouter, Depends, Request
from fastapi.responses import JSONResponse

from pilotage.gateway.json_form import BadRequestError, from_json, schema_of, to_json
from pilotage.gateway.problems import ProblemError, responses
from pilotage.gateway.routes.shared import ROBOT_PREFIX, Robot, body_of, ok, operator_only
from pilotage_schemas.topics import QUERIES, Query

router = APIRouter(tags=["commands"], dependencies=[Depends(operator_only)])

MAX_BODY = 64 * 1024
"""Bytes of a command; the largest has a few hundred."""

POSE = {"x": 12.5, "y": 3.0, "theta": 1.57}
COVARIANCE = [[0.25, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 0.07]]
EXAMPLES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "forward": ({"distance": 1.0, "speed": 0.3}, {"detail": ""}),
    "backward": ({"distance": 0.5}, {"detail": ""}),
    "turn": ({"angle": 1.57, "rate": 0.6}, {"detail": ""}),
    "velocity": ({"twist": {"vx": 0.3, "vy": 0.0, "omega": 0.2}}, {"detail": ""}),
    "stop": ({}, {"after": 0.08}),
    "wander": ({"enabled": True}, {"detail": ""}),
    "kidnap": ({"pose": POSE}, {"pose": POSE}),
    "set_pose": ({"pose": POSE, "covariance": COVARIANCE}, {"detail": ""}),
    "relocalize": ({}, {"detail": ""}),
    "set_algorithm": ({"algorithm": "m2", "recovery_weight": 1.0}, {"detail": ""}),
    "set_method": ({"method": "mcl"}, {"detail": "localizing by mcl"}),
    "set_map": (
        {"map": "maps/ground_floor.yaml"},
        {"map_id": "9b1e5d0c77aa4f32", "rows": 640, "cols": 900},
    ),
    "map_start": ({"sensor": "laser", "go_on": False}, {"detail": "mapping by laser"}),
    "map_stop": ({}, {"map_id": "5f3c0a9be2d41c77", "rows": 800, "cols": 1200}),
    "map_reset": ({}, {"detail": "mapping anew"}),
    "map_save": (
        {"name": "office"},
        {"name": "office", "map_id": "5f3c0a9be2d41c77", "path": "maps/office"},
    ),
    "map_load": (
        {"map": "office"},
        {"map_id": "5f3c0a9be2d41c77", "rows": 800, "cols": 1200},
    ),
    "load_map": (
        {"path": "maps/office.yaml"},
        {"map_id": "5f3c0a9be2d41c77", "rows": 800, "cols": 1200},
    ),
    "go_to": (
        {"pose": POSE, "position_tolerance": 0.1, "heading_tolerance": 0.0873},
        {"detail": "going to (12.50, 3.00), 8.4 m"},
    ),
    "localize_actively": ({"always": False}, {"detail": "resolving the doubt"}),
    "cancel": ({}, {"detail": "going to (12.50, 3.00) was given up"}),
    "look": ({"pan": 0.5}, {"detail": ""}),
    "topology_build": (
        {"source": "map", "spacing": "variable", "metres": 3.0},
        {"map_id": "5f3c0a9be2d41c77", "nodes": 42, "edges": 51},
    ),
    "topology_save": (
        {"name": "office", "floor": "ground floor"},
        {"name": "office", "map_id": "5f3c0a9be2d41c77", "path": "topologies/office.geojson"},
    ),
    "topology_load": (
        {"name": "office"},
        {"map_id": "5f3c0a9be2d41c77", "nodes": 42, "edges": 51},
    ),
    "topology_link": (
        {
            "start": {"name": "ground", "node": 7},
            "end": {"name": "upstairs", "node": 3},
            "cost": 20.0,
        },
        {"detail": "joined"},
    ),
    "restart": ({"service": "localizer"}, {"detail": ""}),
}
"""Request and reply of each command, shown in the API's description."""


def _command(query: Query) -> Callable[[Request, Robot], Awaitable[JSONResponse]]:
    async def command(request: Request, service: Robot) -> JSONResponse:
        try:
            wanted = from_json(query.request, await body_of(request, MAX_BODY))
        except BadRequestError as error:
            raise ProblemError(422, str(error)) from error
        return JSONResponse(to_json(await service.commander.carry_out(query, wanted)))

    return command


def _described_body(query: Query) -> dict[str, Any]:
    request, _ = EXAMPLES[query.name]
    schema = schema_of(query.request, is_reply=False)
    content = {"application/json": {"schema": schema, "example": request}}
    return {"requestBody": {"required": bool(schema.get("required")), "content": content}}


COMMANDS = {name: query for name, query in QUERIES.items() if query.is_command}

for known in COMMANDS.values():
    router.add_api_route(
        f"{ROBOT_PREFIX}/commands/{known.name}",
        _command(known),
        methods=["POST"],
        name=f"command_{known.name}",
        summary=known.summary.capitalize(),
        description=f"Carried out by {known.service}, which answers within {known.timeout_s:g} s.",
        openapi_extra=_described_body(known),
        responses=ok(schema_of(known.reply), EXAMPLES[known.name][1])
        | responses(404, 409, 413, 422, 429, 502, 503, 504),
    )


@router.post(f"{ROBOT_PREFIX}/commands/{{name}}", include_in_schema=False)
async def unknown_command(service: Robot, name: str) -> None:
    """Say which commands there are."""
    known = ", ".join(COMMANDS)
    raise ProblemError(404, f"{service.robot} knows no command {name!r}; there are {known}")
