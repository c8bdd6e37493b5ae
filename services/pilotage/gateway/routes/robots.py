"""The robots, and what each believes and does."""

from dataclasses import asdict
from typing import Any

from fastapi import APIRouter
from fastapi.responses import JSONResponse

from pilotage.gateway.json_form import to_json
from pilotage.gateway.problems import responses
from pilotage.gateway.routes.shared import (
    ROBOT_PREFIX,
    Gateway,
    Robot,
    live_json,
    live_schema,
    newest_of,
    ok,
)
from pilotage.gateway.service import GatewayService
from pilotage_schemas.health import Deployment
from pilotage_schemas.localization import Belief, PoseEstimate
from pilotage_schemas.sensors import RobotDescription, RobotStatus

router = APIRouter(tags=["robots"])

SUMMARY_SCHEMA: dict[str, Any] = {
    "type": "object",
    "required": ["id", "connected", "name", "source", "mode", "state", "commands"],
    "properties": {
        "id": {"type": "string"},
        "connected": {"type": "boolean", "description": "the gateway reaches the bus"},
        "name": {"type": ["string", "null"]},
        "source": {"type": ["string", "null"], "enum": ["live", "simulation", "replay", None]},
        "mode": {"type": ["string", "null"]},
        "state": {"type": ["string", "null"], "description": "of its pose"},
        "commands": {"type": "array", "items": {"type": "string"}},
    },
}
SUMMARY_EXAMPLE = {
    "id": "demo",
    "connected": True,
    "name": "simulator",
    "source": "simulation",
    "mode": "wandering",
    "state": "localized",
    "commands": ["forward", "backward", "turn", "velocity", "stop", "wander", "kidnap"],
}
TRAJECTORY_SCHEMA: dict[str, Any] = {
    "type": "object",
    "required": ["frame_id", "poses", "breaks"],
    "properties": {
        "frame_id": {"const": "map"},
        "poses": {
            "type": "array",
            "description": "stamp in s, x and y in m, theta in rad; oldest first",
            "items": {
                "type": "array",
                "items": {"type": "number"},
                "minItems": 4,
                "maxItems": 4,
            },
        },
        "breaks": {
            "type": "array",
            "description": "indices of poses that are not joined to the one before",
            "items": {"type": "integer", "minimum": 1},
        },
    },
}
TRAJECTORY_EXAMPLE = {
    "frame_id": "map",
    "poses": [[1795370400.0, 1.0, 2.0, 0.0], [1795370400.1, 1.03, 2.0, 0.0]],
    "breaks": [],
}
HEALTH_SCHEMA: dict[str, Any] = {
    "type": "object",
    "required": ["connected", "since_ns", "services", "latency"],
    "properties": {
        "connected": {"type": "boolean", "description": "the gateway reaches the bus"},
        "since_ns": {"type": "integer"},
        "services": {"type": "object", "description": "the newest Health of each service"},
        "latency": {"type": "object", "description": "age at arrival per topic, in ms"},
    },
}


@router.get("/api/v1/robots", responses=ok({"type": "array", "items": SUMMARY_SCHEMA}))
async def robots(service: Gateway) -> JSONResponse:
    """List the robots that this gateway serves."""
    return JSONResponse([_summary(service)])


@router.get(ROBOT_PREFIX, responses=ok(SUMMARY_SCHEMA, SUMMARY_EXAMPLE) | responses(404))
async def robot(service: Robot) -> JSONResponse:
    """Return a robot's name, what it does and what it can do."""
    return JSONResponse(_summary(service))


@router.get(f"{ROBOT_PREFIX}/pose", responses=ok(live_schema(PoseEstimate)) | responses(404))
async def pose(service: Robot) -> JSONResponse:
    """Return the newest pose of base_link in `map`, its state and its confidence."""
    return JSONResponse(live_json(service, newest_of(service, "pose")))


@router.get(f"{ROBOT_PREFIX}/belief", responses=ok(live_schema(Belief)) | responses(404))
async def belief(service: Robot) -> JSONResponse:
    """Return where the robot could be: weighted samples and the places they gather at."""
    return JSONResponse(live_json(service, newest_of(service, "belief")))


@router.get(
    f"{ROBOT_PREFIX}/trajectory",
    responses=ok(TRAJECTORY_SCHEMA, TRAJECTORY_EXAMPLE) | responses(404),
)
async def trajectory(service: Robot) -> JSONResponse:
    """Return the localized poses of the last 60 s."""
    path = service.state.trajectory
    return JSONResponse({"frame_id": "map", "poses": path.poses(), "breaks": path.breaks()})


@router.get(f"{ROBOT_PREFIX}/deployment", responses=ok(live_schema(Deployment)) | responses(404))
async def deployment(service: Robot) -> JSONResponse:
    """Return the processes of the deployment as the launcher sees them."""
    return JSONResponse(live_json(service, newest_of(service, "deployment")))


@router.get(f"{ROBOT_PREFIX}/health", responses=ok(HEALTH_SCHEMA) | responses(404))
async def health(service: Robot) -> JSONResponse:
    """Return every service's account of itself and the latency of every topic."""
    sources = service.state.sources("health")
    return JSONResponse(
        {
            "connected": service.is_linked,
            "since_ns": service.linked_since_ns,
            "services": {name: live_json(service, received) for name, received in sources.items()},
            "latency": {t: asdict(found) for t, found in service.state.latency.all().items()},
        }
    )


def _summary(service: GatewayService) -> dict[str, Any]:
    def field(topic: str, kind: type, name: str) -> object:
        received = service.state.newest(topic)
        if received is None or not isinstance(received.message, kind):
            return None
        return to_json(received.message)[name]

    return {
        "id": service.robot,
        "connected": service.is_linked,
        "name": field("description", RobotDescription, "name"),
        "source": field("status", RobotStatus, "source"),
        "mode": field("status", RobotStatus, "mode"),
        "state": field("pose", PoseEstimate, "state"),
        "commands": field("description", RobotDescription, "commands") or [],
    }
