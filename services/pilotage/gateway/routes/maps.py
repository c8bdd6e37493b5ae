"""The map in use, as facts, as a picture and as map_server's files."""

from collections.abc import Callable
from typing import Any
from urllib.parse import quote

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse

from pilotage.gateway import map_image
from pilotage.gateway.json_form import schema_of
from pilotage.gateway.problems import responses
from pilotage.gateway.routes.shared import ROBOT_PREFIX, Robot, newest_of, ok
from pilotage.gateway.service import GatewayService
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.mapping import OccupancyGrid

router = APIRouter(tags=["map"])

META_SCHEMA: dict[str, Any] = {
    "type": "object",
    "required": ["map_id", "name", "resolution", "origin", "rows", "cols", "stamp_ns"],
    "properties": {
        "map_id": {"type": "string", "description": "names the content; the ETag of its files"},
        "name": {"type": "string"},
        "resolution": {"type": "number", "description": "side of a cell in m"},
        "origin": schema_of(Pose2)
        | {"description": "outer corner of cell (0, 0), which is the image's bottom left"},
        "rows": {"type": "integer"},
        "cols": {"type": "integer"},
        "stamp_ns": {"type": "integer"},
    },
}
META_EXAMPLE = {
    "map_id": "5f3c0a9be2d41c77",
    "name": "office",
    "resolution": 0.05,
    "origin": {"x": 0.0, "y": 0.0, "theta": 0.0},
    "rows": 800,
    "cols": 1200,
    "stamp_ns": 1795370400000000000,
}
NOT_MODIFIED: dict[int | str, dict[str, Any]] = {304: {"description": "Not Modified"}}


BINARY: dict[str, Any] = {"type": "string", "format": "binary"}
YAML_SCHEMA: dict[str, Any] = {
    "type": "object",
    "required": ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"],
    "properties": {
        "image": {"const": "map.pgm"},
        "mode": {"const": "trinary"},
        "resolution": {"type": "number"},
        "origin": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
        "negate": {"const": 0},
        "occupied_thresh": {"type": "number"},
        "free_thresh": {"type": "number"},
    },
}
PNG, PGM, YAML = "image/png", "image/x-portable-graymap", "application/yaml"


def _file(media_type: str, schema: dict[str, Any]) -> dict[int | str, dict[str, Any]]:
    content = {media_type: {"schema": schema}}
    says = "the map's id; of a map in the making with its number of changes"
    headers = {"ETag": {"schema": {"type": "string"}, "description": says}}
    found = {200: {"description": "OK", "content": content, "headers": headers}}
    return found | NOT_MODIFIED | responses(404)


@router.get(f"{ROBOT_PREFIX}/map", responses=ok(META_SCHEMA, META_EXAMPLE) | responses(404))
async def map_facts(service: Robot) -> JSONResponse:
    """Return the map's id, size and place, without its cells."""
    grid = _grid(service)
    rows, cols = grid.cells.shape
    facts = {
        "map_id": grid.map_id,
        "name": grid.name,
        "resolution": grid.resolution,
        "origin": grid.origin.model_dump(),
        "rows": rows,
        "cols": cols,
        "stamp_ns": grid.stamp_ns,
    }
    return JSONResponse(facts)


@router.get(f"{ROBOT_PREFIX}/map.png", response_class=Response, responses=_file(PNG, BINARY))
async def map_png(request: Request, service: Robot) -> Response:
    """Return the map as a PNG: 0 occupied, 254 free, 205 unknown."""
    return await _rendered(request, service, map_image.png, PNG)


@router.get(
    f"{ROBOT_PREFIX}/map.pgm",
    response_class=Response,
    responses=_file(PGM, BINARY),
)
async def map_pgm(request: Request, service: Robot) -> Response:
    """Return the map as the PGM that map.yaml names."""
    return await _rendered(request, service, map_image.pgm, PGM)


@router.get(f"{ROBOT_PREFIX}/map.yaml", response_class=Response, responses=_file(YAML, YAML_SCHEMA))
async def map_yaml(request: Request, service: Robot) -> Response:
    """Return map_server's description of map.pgm."""
    return await _rendered(request, service, map_image.yaml, YAML)


def _grid(service: GatewayService) -> OccupancyGrid:
    message = newest_of(service, "map").message
    assert isinstance(message, OccupancyGrid)  # noqa: S101 - the registry's type for this topic
    return message


async def _rendered(
    request: Request,
    service: GatewayService,
    render: Callable[[OccupancyGrid], bytes],
    media_type: str,
) -> Response:
    """Return the file, or that the caller has it already."""
    grid = _grid(service)
    revision = service.state.map.revision
    tag = f'"{quote(grid.map_id)}.{revision}"' if revision else f'"{quote(grid.map_id)}"'
    headers = {"etag": tag, "cache-control": "private, no-cache"}
    if _has(request.headers.get("if-none-match", ""), tag):
        return Response(status_code=304, headers=headers)
    content = await service.map_files.get(grid, render)
    return Response(content, media_type=media_type, headers=headers)


def _has(if_none_match: str, tag: str) -> bool:
    offered = [part.strip().removeprefix("W/") for part in if_none_match.split(",")]
    return tag in offered or "*" in offered
