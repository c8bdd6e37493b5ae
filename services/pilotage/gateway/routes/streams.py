"""The live streams: everything over a WebSocket, events as server-sent events."""

from collections.abc import AsyncIterator
from typing import Annotated, Any, get_args

from fastapi import APIRouter, Header, WebSocket
from fastapi.responses import StreamingResponse

from pilotage.gateway.event_log import Kind, Severity
from pilotage.gateway.event_stream import EventFollower, parsed_id
from pilotage.gateway.problems import ProblemError, problem_response, responses
from pilotage.gateway.routes.shared import ROBOT_PREFIX, Gateway, Robot
from pilotage.gateway.stream import Hub, Outbox, TooManyStreamsError
from pilotage.gateway.websocket import serve_client

router = APIRouter(tags=["streams"])

EVENT_STREAM = "text/event-stream"
EVENT_SCHEMA: dict[str, Any] = {
    "type": "object",
    "required": ["id", "stamp_ns", "kind", "severity", "text"],
    "properties": {
        "id": {"type": "integer", "description": "grows; a client that returns goes on after it"},
        "stamp_ns": {"type": "integer"},
        "kind": {"enum": list(get_args(Kind))},
        "severity": {"enum": list(get_args(Severity))},
        "text": {"type": "string", "description": "a sentence for people"},
    },
}
ITEM_SCHEMA: dict[str, Any] = {
    "type": "object",
    "properties": {
        "id": {"type": "string"},
        "data": {
            "type": "string",
            "contentMediaType": "application/json",
            "contentSchema": EVENT_SCHEMA,
        },
    },
}
"""One event, in the words of OpenAPI 3.2, section 4.14.4."""

EVENT_EXAMPLE = (
    "id: 1795370400000000\n"
    'data: {"id": 1795370400000000, "stamp_ns": 1795370400000000000, '
    '"kind": "localization", "severity": "info", "text": "Localized"}\n\n'
)
EVENTS_OK: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "OK",
        "content": {EVENT_STREAM: {"itemSchema": ITEM_SCHEMA, "example": EVENT_EXAMPLE}},
    }
}


@router.get(
    f"{ROBOT_PREFIX}/events",
    response_class=StreamingResponse,
    responses=EVENTS_OK | responses(404, 422, 503),
)
async def events(
    service: Robot, last_event_id: Annotated[str | None, Header(max_length=64)] = None
) -> StreamingResponse:
    """Follow what happens: first the newest events, then each as it comes."""
    follower = EventFollower(service.events, parsed_id(last_event_id))
    if service.hub.is_full:
        raise ProblemError(503, "too many streams are open")
    return StreamingResponse(_admitted(service.hub, follower), media_type=EVENT_STREAM)


async def _admitted(hub: Hub, follower: EventFollower) -> AsyncIterator[bytes]:
    with hub.admitted(follower.close):
        async for data in follower:
            yield data


@router.websocket(f"{ROBOT_PREFIX}/stream")
async def stream(
    websocket: WebSocket, service: Gateway, robot_id: str, topics: str | None = None
) -> None:
    """Send every message of the bus as it comes, or only those of `topics` (`pose,belief`)."""
    if robot_id != service.robot:
        refusal = problem_response(404, "there is no robot of that name here", websocket.url.path)
        await websocket.send_denial_response(refusal)
        return
    outbox = Outbox(None if topics is None else frozenset(topics.split(",")))
    try:
        with service.hub.feeding(outbox):
            await serve_client(websocket, service, outbox)
    except TooManyStreamsError as error:
        refusal = problem_response(503, str(error), websocket.url.path)
        await websocket.send_denial_response(refusal)
