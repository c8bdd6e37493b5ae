"""The newest measurement of each of the robot's topics."""

from collections.abc import Awaitable, Callable

from fastapi import APIRouter
from fastapi.responses import JSONResponse

from pilotage.gateway.problems import ProblemError, responses
from pilotage.gateway.routes.shared import (
    ROBOT_PREFIX,
    Robot,
    live_json,
    live_schema,
    newest_of,
    ok,
)
from pilotage_schemas.topics import TOPICS

router = APIRouter(tags=["sensors"])
SENSORS = [topic for topic in TOPICS.values() if topic.owner == "robot"]


def _newest(topic: str) -> Callable[[Robot], Awaitable[JSONResponse]]:
    async def newest(service: Robot) -> JSONResponse:
        return JSONResponse(live_json(service, newest_of(service, topic)))

    return newest


for sensor in SENSORS:
    router.add_api_route(
        f"{ROBOT_PREFIX}/sensors/{sensor.name}",
        _newest(sensor.name),
        methods=["GET"],
        name=f"sensor_{sensor.name}",
        summary=f"Newest {sensor.message.__name__}: {sensor.summary}",
        responses=ok(live_schema(sensor.message)) | responses(404),
    )


@router.get(f"{ROBOT_PREFIX}/sensors/{{name}}", include_in_schema=False)
async def unknown_sensor(service: Robot, name: str) -> None:
    """Say which sensors there are."""
    known = ", ".join(topic.name for topic in SENSORS)
    raise ProblemError(404, f"{service.robot} has no topic {name!r}; there are {known}")
