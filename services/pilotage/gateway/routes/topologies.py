"""The library of topological maps: list, upload, download, activate, delete."""

from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Depends, Path, Request, Response
from fastapi.responses import JSONResponse

from pilotage.gateway.json_form import schema_of, to_json
from pilotage.gateway.map_archive import LARGEST
from pilotage.gateway.problems import ProblemError, responses
from pilotage.gateway.routes.shared import Gateway, body_of, ok, operator_only
from pilotage.gateway.routes.topology import GEOJSON, GEOJSON_SCHEMA, fetched
from pilotage.gateway.service import GatewayService
from pilotage_schemas.commands import Done, Nothing
from pilotage_schemas.topics import QUERIES
from pilotage_schemas.topology import (
    TopologyDelete,
    TopologyFetch,
    TopologyList,
    TopologyLoad,
    TopologyLoaded,
    TopologySaved,
    TopologyStore,
)

router = APIRouter(tags=["topology library"])
PREFIX = "/api/v1/topologies"
BUS = (422, 429, 502, 503, 504)
"""What can go wrong with anything that is asked about a map of some name."""

EXAMPLE = {
    "name": "office",
    "map_id": "5f3c0a9be2d41c77",
    "floor": "ground floor",
    "nodes": 42,
    "edges": 51,
    "saved_ns": 1795370400000000000,
}
LOADED_EXAMPLE = {"map_id": "5f3c0a9be2d41c77", "nodes": 42, "edges": 51}
SAVED_EXAMPLE = {
    "name": "office",
    "map_id": "5f3c0a9be2d41c77",
    "path": "topologies/office.geojson",
}
FILE: dict[str, Any] = {GEOJSON: {"schema": GEOJSON_SCHEMA}}
DOWNLOADED: dict[int | str, dict[str, Any]] = {200: {"description": "OK", "content": FILE}}
Name = Annotated[str, Path(description="the topological map's name", max_length=64)]


@router.get(
    PREFIX,
    responses=ok(schema_of(TopologyList), {"topologies": [EXAMPLE]})
    | responses(409, 429, 502, 503, 504),
)
async def topologies(service: Gateway) -> JSONResponse:
    """List the topological maps of the library, with the occupancy maps that they are of."""
    return JSONResponse(to_json(await _list(service)))


@router.get(
    f"{PREFIX}/{{name}}",
    response_class=Response,
    responses=DOWNLOADED | responses(404, 409, *BUS),
)
async def download(service: Gateway, name: Name) -> Response:
    """Return a topological map as GeoJSON, as nav2_route reads it."""
    known = await _known(service, name)
    headers = {"content-disposition": f'attachment; filename="{known}.geojson"'}
    content = await fetched(service, TopologyFetch(name=known))
    return Response(content, media_type=GEOJSON, headers=headers)


@router.put(
    f"{PREFIX}/{{name}}",
    dependencies=[Depends(operator_only)],
    # Whether it is a map is told by the library, with the place of the first fault.
    openapi_extra={"requestBody": {"required": True, "content": {GEOJSON: {"schema": {}}}}},
    responses=ok(schema_of(TopologySaved), SAVED_EXAMPLE) | responses(403, 409, 413, *BUS),
)
async def upload(request: Request, service: Gateway, name: Name) -> JSONResponse:
    """Take a GeoJSON file into the library, in place of an older map of this name."""
    content = np.frombuffer(await body_of(request, LARGEST), np.int8)
    store = TopologyStore(name=name, content=content)
    reply = await service.commander.carry_out(QUERIES["topology_store"], store)
    return JSONResponse(to_json(reply))


@router.post(
    f"{PREFIX}/{{name}}/activate",
    dependencies=[Depends(operator_only)],
    responses=ok(schema_of(TopologyLoaded), LOADED_EXAMPLE) | responses(403, 404, 409, *BUS),
)
async def activate(service: Gateway, name: Name) -> JSONResponse:
    """Use a topological map of the occupancy map in use."""
    load = TopologyLoad(name=await _known(service, name))
    return JSONResponse(to_json(await service.commander.carry_out(QUERIES["topology_load"], load)))


@router.delete(
    f"{PREFIX}/{{name}}",
    dependencies=[Depends(operator_only)],
    responses=ok(schema_of(Done), {"detail": "deleted office"}) | responses(403, 404, 409, *BUS),
)
async def delete(service: Gateway, name: Name) -> JSONResponse:
    """Delete a topological map; one in use stays in use."""
    wish = TopologyDelete(name=await _known(service, name))
    reply = await service.commander.carry_out(QUERIES["topology_delete"], wish)
    return JSONResponse(to_json(reply))


async def _list(service: GatewayService) -> TopologyList:
    reply = await service.commander.carry_out(QUERIES["topology_list"], Nothing())
    assert isinstance(reply, TopologyList)  # noqa: S101 - the registry's type for this query
    return reply


async def _known(service: GatewayService, name: str) -> str:
    """Return the name of a map of the library; ProblemError 404 if there is none."""
    names = [one.name for one in (await _list(service)).topologies]
    if name not in names:
        known = ", ".join(names) or "none yet"
        raise ProblemError(404, f"the library has no such topological map; it has {known}")
    return name
