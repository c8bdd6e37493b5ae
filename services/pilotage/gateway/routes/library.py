"""The map library of the mapper: list, upload, download, activate, delete."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Request, Response
from fastapi.responses import JSONResponse

from pilotage.gateway.json_form import schema_of, to_json
from pilotage.gateway.map_archive import LARGEST, ArchiveError, packed, unpacked
from pilotage.gateway.problems import ProblemError, responses
from pilotage.gateway.routes.shared import Gateway, body_of, ok, operator_only
from pilotage.gateway.service import GatewayService
from pilotage_schemas.commands import (
    Done,
    MapDelete,
    MapFetch,
    MapFile,
    MapList,
    MapLoad,
    MapLoaded,
    MapSaved,
    MapStore,
    Nothing,
    StoredMap,
)
from pilotage_schemas.topics import QUERIES

router = APIRouter(tags=["map library"])
PREFIX = "/api/v1/maps"
ZIP = "application/zip"
BUS = (422, 429, 502, 503, 504)
"""What can go wrong with anything that is asked of the mapper about a map of some name."""

EXAMPLE = {
    "name": "office",
    "map_id": "5f3c0a9be2d41c77",
    "rows": 800,
    "cols": 1200,
    "resolution": 0.05,
    "saved_ns": 1795370400000000000,
    "files": ["map.yaml", "map.pgm", "trajectory.tum", "pose_graph.g2o", "session.npz"],
    "can_go_on": True,
}
LOADED_EXAMPLE = {"map_id": "5f3c0a9be2d41c77", "rows": 800, "cols": 1200}
SAVED_EXAMPLE = {"name": "office", "map_id": "5f3c0a9be2d41c77", "path": "maps/office"}
BINARY: dict[str, Any] = {"type": "string", "format": "binary"}
Name = Annotated[str, Path(description="the map's name", max_length=64)]


def _bytes(media_type: str) -> dict[int | str, dict[str, Any]]:
    return {200: {"description": "OK", "content": {media_type: {"schema": BINARY}}}}


@router.get(
    PREFIX, responses=ok(schema_of(MapList), {"maps": [EXAMPLE]}) | responses(429, 502, 503, 504)
)
async def maps(service: Gateway) -> JSONResponse:
    """List the maps of the library."""
    return JSONResponse(to_json(await _list(service)))


@router.get(
    f"{PREFIX}/{{name}}", responses=ok(schema_of(StoredMap), EXAMPLE) | responses(404, *BUS)
)
async def facts(service: Gateway, name: Name) -> JSONResponse:
    """Return what is known of a map."""
    return JSONResponse(to_json(await _known(service, name)))


@router.put(
    f"{PREFIX}/{{name}}",
    dependencies=[Depends(operator_only)],
    openapi_extra={"requestBody": {"required": True, "content": {ZIP: {"schema": BINARY}}}},
    responses=ok(schema_of(MapSaved), SAVED_EXAMPLE) | responses(403, 409, 413, *BUS),
)
async def upload(request: Request, service: Gateway, name: Name) -> JSONResponse:
    """Take a ZIP archive with map.yaml and its image into the library, in place of an older map."""
    try:
        files = unpacked(await body_of(request, LARGEST))
    except ArchiveError as error:
        raise ProblemError(422, str(error)) from error
    store = MapStore(name=name, files=files)
    return JSONResponse(to_json(await service.commander.carry_out(QUERIES["map_store"], store)))


@router.get(
    f"{PREFIX}/{{name}}/archive",
    response_class=Response,
    responses=_bytes(ZIP) | responses(404, 409, *BUS),
)
async def download(service: Gateway, name: Name) -> Response:
    """Return all files of a map as a ZIP archive."""
    known = await _known(service, name)
    files = {file: await _fetch(service, name, file) for file in known.files}
    headers = {"content-disposition": f'attachment; filename="{known.name}.zip"'}
    return Response(packed(files), media_type=ZIP, headers=headers)


@router.get(
    f"{PREFIX}/{{name}}/files/{{file}}",
    response_class=Response,
    responses=_bytes("application/octet-stream") | responses(404, 409, *BUS),
)
async def download_file(
    service: Gateway, name: Name, file: Annotated[str, Path(max_length=64)]
) -> Response:
    """Return one file of a map."""
    known = await _known(service, name)
    if file not in known.files:
        raise ProblemError(404, f"{known.name} has no such file; it has {', '.join(known.files)}")
    content = await _fetch(service, name, file)
    return Response(content, media_type="application/octet-stream")


@router.post(
    f"{PREFIX}/{{name}}/activate",
    dependencies=[Depends(operator_only)],
    responses=ok(schema_of(MapLoaded), LOADED_EXAMPLE) | responses(403, 404, 409, *BUS),
)
async def activate(service: Gateway, name: Name) -> JSONResponse:
    """Use a map from now on."""
    await _known(service, name)
    load = MapLoad(map=name)
    return JSONResponse(to_json(await service.commander.carry_out(QUERIES["map_load"], load)))


@router.delete(
    f"{PREFIX}/{{name}}",
    dependencies=[Depends(operator_only)],
    responses=ok(schema_of(Done), {"detail": "deleted office"}) | responses(403, 404, 409, *BUS),
)
async def delete(service: Gateway, name: Name) -> JSONResponse:
    """Delete a map; a map in use stays in use."""
    await _known(service, name)
    wish = MapDelete(name=name)
    return JSONResponse(to_json(await service.commander.carry_out(QUERIES["map_delete"], wish)))


async def _list(service: GatewayService) -> MapList:
    reply = await service.commander.carry_out(QUERIES["map_list"], Nothing())
    assert isinstance(reply, MapList)  # noqa: S101 - the registry's type for this query
    return reply


async def _known(service: GatewayService, name: str) -> StoredMap:
    """Return a map of the library; ProblemError 404 if there is none of this name."""
    listed = (await _list(service)).maps
    found = next((one for one in listed if one.name == name), None)
    if found is None:
        names = ", ".join(one.name for one in listed) or "none yet"
        raise ProblemError(404, f"the library has no such map; it has {names}")
    return found


async def _fetch(service: GatewayService, name: str, file: str) -> bytes:
    wish = MapFetch(name=name, file=file)
    reply = await service.commander.carry_out(QUERIES["map_fetch"], wish)
    assert isinstance(reply, MapFile)  # noqa: S101 - the registry's type for this query
    return reply.content.tobytes()
