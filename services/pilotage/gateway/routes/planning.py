"""What the planner plans: the newest message of each of its topics that people ask for."""

from collections.abc import Awaitable, Callable

from fastapi import APIRouter
from fastapi.responses import JSONResponse

from pilotage.gateway.problems import responses
from pilotage.gateway.routes.shared import (
    ROBOT_PREFIX,
    Robot,
    live_json,
    live_schema,
    newest_of,
    ok,
)
from pilotage_schemas.topics import TOPICS

router = APIRouter(tags=["planning"])

PATHS = {"plan": "plan", "path": "path", "potential": "potential", "planning": "planning_status"}
"""The last part of an address, and the topic that it answers with."""


def _newest(topic: str) -> Callable[[Robot], Awaitable[JSONResponse]]:
    async def newest(service: Robot) -> JSONResponse:
        return JSONResponse(live_json(service, newest_of(service, topic)))

    return newest


for name, topic in ((name, TOPICS[topic]) for name, topic in PATHS.items()):
    router.add_api_route(
        f"{ROBOT_PREFIX}/{name}",
        _newest(topic.name),
        methods=["GET"],
        name=name,
        summary=f"Newest {topic.message.__name__}: {topic.summary}",
        responses=ok(live_schema(topic.message)) | responses(404),
    )
