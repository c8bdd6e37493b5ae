"""The topological map: places and ways, routes through it, the nearest node."""

import re
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Response
from fastapi.responses import JSONResponse

from pilotage.gateway.json_form import schema_of, to_json
from pilotage.gateway.problems import responses
from pilotage.gateway.routes.shared import (
    ROBOT_PREFIX,
    Robot,
    live_json,
    live_schema,
    newest_of,
    ok,
)
from pilotage.gateway.service import GatewayService
from pilotage_schemas.topics import QUERIES
from pilotage_schemas.topology import (
    NearestNode,
    NodeFound,
    NodeOf,
    Point,
    Route,
    TopologicalMap,
    TopologyFetch,
    TopologyFile,
    TopologyRoute,
)

router = APIRouter(tags=["topology"])
GEOJSON = "application/geo+json"
GEOJSON_SCHEMA: dict[str, Any] = {
    "type": "object",
    "required": ["type", "features"],
    "properties": {"type": {"const": "FeatureCollection"}, "features": {"type": "array"}},
}
METRES = r"-?[0-9]{1,6}(\.[0-9]{1,9})?"
NODE = "[0-9]{1,9}"
PLACE = rf"^({NODE}|{METRES},{METRES}|[A-Za-z0-9_][A-Za-z0-9_.-]{{0,63}}:{NODE})$"
"""A node's id, a point as x,y in m, or a node of a map of the library as NAME:ID."""

BUS = (404, 409, 422, 429, 502, 503, 504)
ROUTE_EXAMPLE = {
    "nodes": [3, 4, 9],
    "edges": [21, 27],
    "cost": 12.6,
    "way": [[2.0, 1.0], [6.0, 1.0], [6.0, 7.6]],
    "floors": [{"name": "office", "floor": "ground floor", "nodes": 3, "edges": 2, "points": 3}],
}
NEAREST_EXAMPLE = {
    "node": 9,
    "name": "door 9",
    "pose": {"x": 6.0, "y": 7.6, "theta": 1.57},
    "distance": 0.8,
}


def _described() -> dict[int | str, dict[str, Any]]:
    described = ok(live_schema(TopologicalMap))
    described[200]["content"][GEOJSON] = {"schema": GEOJSON_SCHEMA}
    return described


@router.get(
    f"{ROBOT_PREFIX}/topology", response_class=Response, responses=_described() | responses(*BUS)
)
async def topology(
    service: Robot,
    form: Annotated[
        Literal["json", "geojson"],
        Query(alias="format", description="geojson: as nav2_route reads it"),
    ] = "json",
) -> Response:
    """Return the topological map in use: nodes with their features, edges with their ways."""
    if form == "json":
        return JSONResponse(live_json(service, newest_of(service, "topology")))
    return Response(await fetched(service, TopologyFetch()), media_type=GEOJSON)


PlaceText = Annotated[str, Query(pattern=PLACE, description="a node's id, or x,y, or NAME:ID")]
Start = Annotated[PlaceText, Query(alias="from", examples=["3"])]
End = Annotated[PlaceText, Query(alias="to", examples=["6.0,7.6"])]


@router.get(
    f"{ROBOT_PREFIX}/topology/route",
    responses=ok(schema_of(Route), ROUTE_EXAMPLE) | responses(*BUS),
)
async def route(service: Robot, start: Start, end: End) -> JSONResponse:
    """Return the cheapest way, by lifts if it must: its nodes, edges, polyline and cost in m."""
    wish = TopologyRoute(start=_place(start), end=_place(end))
    return JSONResponse(to_json(await service.commander.carry_out(QUERIES["topology_route"], wish)))


Metres = Annotated[float, Query(ge=-1e6, le=1e6, allow_inf_nan=False, description="m")]


@router.get(
    f"{ROBOT_PREFIX}/topology/nearest",
    responses=ok(schema_of(NodeFound), NEAREST_EXAMPLE) | responses(*BUS),
)
async def nearest(service: Robot, x: Metres, y: Metres) -> JSONResponse:
    """Return the node nearest to a point of the map."""
    wish = NearestNode(x=x, y=y)
    return JSONResponse(to_json(await service.commander.carry_out(QUERIES["nearest_node"], wish)))


async def fetched(service: GatewayService, wish: TopologyFetch) -> bytes:
    """Return a topological map as GeoJSON; ProblemError."""
    reply = await service.commander.carry_out(QUERIES["topology_fetch"], wish)
    assert isinstance(reply, TopologyFile)  # noqa: S101 - the registry's type for this query
    return reply.content.tobytes()


def _place(text: str) -> int | Point | NodeOf:
    """Return the place that a text of the form PLACE means."""
    if re.fullmatch(NODE, text):
        return int(text)
    name, colon, node = text.rpartition(":")
    if colon:
        return NodeOf(name=name, node=int(node))
    x, y = text.split(",")
    return Point(x=float(x), y=float(y))
