"""What all routes need: the service, the robot in the path, the caller's role."""

from typing import Annotated, Any

from fastapi import Depends, Path, Request
from fastapi.requests import HTTPConnection

from pilotage.gateway.json_form import schema_of, to_json
from pilotage.gateway.live_state import Received
from pilotage.gateway.problems import ProblemError
from pilotage.gateway.service import GatewayService
from pilotage_schemas.message import Part
from pilotage_schemas.topics import TOPICS

ROBOT_PREFIX = "/api/v1/robots/{robot_id}"


def service_of(connection: HTTPConnection) -> GatewayService:
    """Return the service that the application serves."""
    service = connection.app.state.service
    assert isinstance(service, GatewayService)  # noqa: S101 - set by create_app and nobody else
    return service


Gateway = Annotated[GatewayService, Depends(service_of)]


def robot_of(
    service: Gateway, robot_id: Annotated[str, Path(description="the robot's name")]
) -> GatewayService:
    """Return the service of the robot in the path; ProblemError 404 for any other."""
    if robot_id != service.robot:
        raise ProblemError(404, f"there is no robot of that name here; try {service.robot}")
    return service


Robot = Annotated[GatewayService, Depends(robot_of)]


def operator_only(connection: HTTPConnection) -> None:
    """Refuse those who may only look."""
    if connection.scope["state"].get("role") != "operator":
        raise ProblemError(403, "a viewer's token does not allow commands")


async def body_of(request: Request, most: int) -> bytes:
    """Return the body; ProblemError 413 as soon as it has more than `most` bytes."""
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > most:
            raise ProblemError(413, f"at most {most} bytes are taken")
    return bytes(body)


def newest_of(service: GatewayService, topic: str) -> Received:
    """Return the newest message of a topic; ProblemError 404 when none has come yet."""
    received = service.state.newest(topic)
    if received is None:
        owner = TOPICS[topic].owner
        raise ProblemError(404, f"no {topic} has come yet; {owner} should send it")
    return received


def live_json(service: GatewayService, received: Received) -> dict[str, Any]:
    """Return a message as JSON with when it came and how old it is now."""
    age_ms = (service.node.clock.now_ns() - received.message.stamp_ns) / 1e6
    return to_json(received.message) | {"received_ns": received.received_ns, "age_ms": age_ms}


def live_schema(kind: type[Part]) -> dict[str, Any]:
    """Return the JSON Schema of `live_json`."""
    schema = schema_of(kind)
    schema["properties"] |= {
        "received_ns": {"type": "integer", "description": "when it came, Unix time in ns"},
        "age_ms": {"type": "number", "description": "time since measurement, in ms"},
    }
    schema["required"] = [*schema.get("required", []), "received_ns", "age_ms"]
    return schema


def ok(schema: dict[str, Any], example: object = None) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI description of a JSON answer."""
    content: dict[str, Any] = {"schema": schema}
    if example is not None:
        content["example"] = example
    return {200: {"description": "OK", "content": {"application/json": content}}}
