"""The page, and what supervisors ask: is it alive, is it ready, how is it."""

from pathlib import Path
from typing import Any

from fastapi import APIRouter
from fastapi.responses import FileResponse, JSONResponse, PlainTextResponse
from fastapi.staticfiles import StaticFiles

from pilotage.gateway.metrics import CONTENT_TYPE, exposition
from pilotage.gateway.problems import ProblemError, responses
from pilotage.gateway.routes.shared import Gateway, ok

WEB = Path(__file__).resolve().parent.parent / "web"
NEEDED = ("map", "pose")
"""Topics without which there is nothing to show."""

STATUS_SCHEMA = {
    "type": "object",
    "required": ["status"],
    "properties": {"status": {"const": "ok"}},
}

router = APIRouter(tags=["gateway"])


class PageFiles(StaticFiles):
    """Files of the page; browsers ask each time whether they have changed."""

    def file_response(self, *args: Any, **kwargs: Any) -> Any:  # noqa: ANN401 - starlette's signature
        """Answer with the file, or that it is unchanged."""
        response = super().file_response(*args, **kwargs)
        response.headers["cache-control"] = "no-cache"
        return response


@router.get("/", include_in_schema=False)
async def page() -> FileResponse:
    """Serve the page."""
    file = WEB / "index.html"
    if not file.is_file():
        raise ProblemError(404, "this installation has no page")
    return FileResponse(file, headers={"cache-control": "no-cache"})


@router.get("/healthz", responses=ok(STATUS_SCHEMA, {"status": "ok"}), summary="Is it alive?")
async def healthz() -> JSONResponse:
    """Answer as long as the gateway lives."""
    return JSONResponse({"status": "ok"})


@router.get(
    "/readyz",
    responses=ok(STATUS_SCHEMA, {"status": "ok"}) | responses(503),
    summary="Is there something to show?",
)
async def readyz(service: Gateway) -> JSONResponse:
    """Answer 200 once a map and a pose have come."""
    missing = [topic for topic in NEEDED if service.state.newest(topic) is None]
    if missing:
        raise ProblemError(503, f"waiting for {' and '.join(missing)}")
    return JSONResponse({"status": "ok"})


@router.get(
    "/metrics",
    response_class=PlainTextResponse,
    responses={200: {"content": {CONTENT_TYPE: {}, "text/plain": {}}}},
    summary="Counters for Prometheus",
)
async def metrics(service: Gateway) -> PlainTextResponse:
    """Return the account of every service in Prometheus' text format."""
    return PlainTextResponse(exposition(service), media_type=CONTENT_TYPE)
