"""THE REGISTRY: every topic and every query, with its message, owner, rate and delivery.

A topic exists only if it stands here; keys, encodings, staleness limits, the schemas under
`v1/` and the README's table all come from this file.
"""

import re
from dataclasses import dataclass
from typing import Literal

from pilotage_schemas import commands as c
from pilotage_schemas import health, localization, mapping, planning, sensors
from pilotage_schemas import topology as t
from pilotage_schemas.message import Message, Part

VERSION = 1
PREFIX = f"pilotage/@v{VERSION}"
EVERYONE = "*"
"""Owner of topics that each service publishes under its own name."""

PATCHES_KEPT = 200
"""A late joiner gets as many patches: those since the whole map, which is sent anew before."""

Delivery = Literal["latest_wins", "never_drop"]
ROBOT_NAME = re.compile(r"[a-z0-9_]{1,32}")


@dataclass(frozen=True)
class Topic:
    """A stream: who publishes which message, how often, and how it travels.

    `rate_hz` is the usual rate, None for events; `latest_wins` keeps only the newest samples
    of a slow consumer, `never_drop` recovers lost ones and gives late joiners the last
    `history`. `while_mapping` publishes it in the owner's place while a map is being made;
    `mapping_status` says when, so that it has exactly one publisher at a time.
    """

    name: str
    message: type[Message]
    owner: str
    rate_hz: float | None
    delivery: Delivery
    summary: str
    while_mapping: str | None = None
    history: int = 1

    @property
    def publishers(self) -> tuple[str, ...]:
        """The services that may publish it, the owner first; EVERYONE for any."""
        return tuple(name for name in (self.owner, self.while_mapping) if name is not None)

    @property
    def stale_after(self) -> float | None:
        """Age in seconds beyond which the stream has stopped: max(0.5 s, 10 periods)."""
        return None if self.rate_hz is None else max(0.5, 10.0 / self.rate_hz)


@dataclass(frozen=True)
class Query:
    """A question with a typed answer: `service` owns it and answers within `timeout_s`.

    A command is what people give to a robot; other queries serve the services themselves.
    """

    name: str
    service: str
    request: type[Part]
    reply: type[Part]
    summary: str
    timeout_s: float = 2.0
    is_command: bool = True


def _asked(
    name: str, request: type[Part], reply: type[Part], summary: str, timeout_s: float = 10.0
) -> Query:
    """Return a query of the topology service that is no command."""
    return Query(name, "topology", request, reply, summary, timeout_s, is_command=False)


_TOPICS = (
    Topic("odometry", sensors.Odometry, "robot", 20, "latest_wins", "dead reckoning"),
    Topic("scan", sensors.LaserScan, "robot", 10, "latest_wins", "laser ranges"),
    Topic("sonar", sensors.SonarScan, "robot", 10, "latest_wins", "sonar ring"),
    Topic("heading", sensors.Heading, "robot", 10, "latest_wins", "compass"),
    Topic("landmarks", sensors.LandmarkSightings, "robot", 5, "latest_wins", "seen landmarks"),
    Topic("vertical_edges", sensors.VerticalEdges, "robot", 5, "latest_wins", "camera edges"),
    Topic("bumper", sensors.Bumper, "robot", None, "never_drop", "collisions"),
    Topic("description", sensors.RobotDescription, "robot", None, "never_drop", "how it is built"),
    Topic("status", sensors.RobotStatus, "robot", 2, "latest_wins", "what the robot does"),
    Topic("ground_truth", sensors.GroundTruth, "robot", 20, "latest_wins", "simulation only"),
    Topic("map", mapping.OccupancyGrid, "mapper", None, "never_drop", "the map in use"),
    Topic(
        "map_patch",
        mapping.GridPatch,
        "mapper",
        None,
        "never_drop",
        "cells that changed",
        history=PATCHES_KEPT,
    ),
    Topic("mapping_status", mapping.MappingStatus, "mapper", None, "never_drop", "how it maps"),
    Topic("mapped_path", mapping.MappedPath, "mapper", None, "never_drop", "the way mapped so far"),
    Topic(
        "pose",
        localization.PoseEstimate,
        "localizer",
        10,
        "latest_wins",
        "where it is",
        while_mapping="mapper",
    ),
    Topic("belief", localization.Belief, "localizer", 2, "latest_wins", "where it could be"),
    Topic(
        "velocity_command", planning.VelocityCommand, "planner", None, "latest_wins", "wanted twist"
    ),
    Topic("gaze_command", planning.GazeCommand, "planner", None, "latest_wins", "wanted gaze"),
    Topic("goal", planning.Goal, "planner", None, "never_drop", "where it goes"),
    Topic("path", planning.Path, "planner", None, "never_drop", "how it gets there"),
    Topic("potential", planning.PotentialField, "planner", None, "never_drop", "potential field"),
    Topic("plan", planning.ActivePlan, "planner", None, "never_drop", "the next look"),
    Topic("planning_status", planning.PlanningStatus, "planner", 2, "latest_wins", "what it plans"),
    Topic("topology", t.TopologicalMap, "topology", None, "never_drop", "places and ways"),
    Topic("node_arrival", t.NodeArrival, "topology", None, "never_drop", "a place reached"),
    Topic("relocalization", t.Relocalization, "topology", None, "never_drop", "found again"),
    # Up to 5 Hz, but only while something matches: their silence is no fault.
    Topic("matched_lines", t.MatchedPairs, "localizer", None, "latest_wins", "lines seen again"),
    Topic("matched_features", t.MatchedPairs, "topology", None, "latest_wins", "a node's, too"),
    Topic("heartbeat", health.Heartbeat, EVERYONE, 4, "latest_wins", "the loop is alive"),
    Topic("health", health.Health, EVERYONE, 1, "latest_wins", "a service's account"),
    Topic("deployment", health.Deployment, "launcher", 1, "latest_wins", "all processes"),
)

_QUERIES = (
    Query("forward", "robot", c.Drive, c.Done, "drive forward by a distance"),
    Query("backward", "robot", c.Drive, c.Done, "drive backward by a distance"),
    Query("turn", "robot", c.Turn, c.Done, "turn on the spot"),
    Query("velocity", "robot", c.Velocity, c.Done, "drive with a twist for 0.5 s"),
    Query("stop", "robot", c.Nothing, c.Stopped, "stand still at once"),
    Query("wander", "robot", c.Wander, c.Done, "wander by itself, or cease to"),
    Query("kidnap", "robot", c.Kidnap, c.Kidnapped, "carry the simulated robot away"),
    Query("set_pose", "localizer", c.SetPose, c.Done, "begin from a given pose"),
    Query("relocalize", "localizer", c.Nothing, c.Done, "forget everything, begin from nothing"),
    Query("set_algorithm", "localizer", c.SetAlgorithm, c.Done, "choose M1 or M2"),
    Query("set_method", "localizer", c.SetMethod, c.Done, "choose how to localize", 30.0),
    Query("set_map", "localizer", c.SetMap, c.MapLoaded, "localize on another map", 30.0),
    Query("map_start", "mapper", c.MapStart, c.Done, "make a map, or go on with one", 30.0),
    Query("map_stop", "mapper", c.Nothing, c.MapLoaded, "finish the map and use it", 60.0),
    Query("map_reset", "mapper", c.Nothing, c.Done, "begin the map in the making anew", 30.0),
    Query("map_save", "mapper", c.MapSave, c.MapSaved, "keep the map in the library", 30.0),
    Query("map_load", "mapper", c.MapLoad, c.MapLoaded, "use a map of the library or a file", 30.0),
    Query("load_map", "mapper", c.LoadMap, c.MapLoaded, "the same as map_load, by its path", 10.0),
    Query("map_list", "mapper", c.Nothing, c.MapList, "list the library", is_command=False),
    Query("map_delete", "mapper", c.MapDelete, c.Done, "delete a map", 10.0, is_command=False),
    Query("map_fetch", "mapper", c.MapFetch, c.MapFile, "read a file", 10.0, is_command=False),
    Query("map_store", "mapper", c.MapStore, c.MapSaved, "take a map in", 30.0, is_command=False),
    Query("go_to", "planner", c.GoTo, c.Done, "drive to a pose of the map", 10.0),
    Query(
        "localize_actively",
        "planner",
        c.LocalizeActively,
        c.Done,
        "drive so as to find out where",
        10.0,
    ),
    Query("cancel", "planner", c.Nothing, c.Done, "give up going and localizing", 10.0),
    Query("look", "planner", c.Look, c.Done, "point the camera"),
    Query(
        "planner_status",
        "planner",
        c.Nothing,
        planning.PlanningStatus,
        "what the planner does",
        is_command=False,
    ),
    Query("topology_build", "topology", t.TopologyBuild, t.TopologyLoaded, "build it anew", 60.0),
    Query("topology_save", "topology", t.TopologySave, t.TopologySaved, "keep the places", 10.0),
    Query("topology_load", "topology", t.TopologyLoad, t.TopologyLoaded, "use kept places", 30.0),
    Query("topology_link", "topology", t.TopologyLink, c.Done, "join two floors, as a lift", 10.0),
    _asked("topology_route", t.TopologyRoute, t.Route, "the cheapest way"),
    _asked("nearest_node", t.NearestNode, t.NodeFound, "the nearest node"),
    _asked("topology_list", c.Nothing, t.TopologyList, "list the topological maps"),
    _asked("topology_delete", t.TopologyDelete, c.Done, "delete a topological map"),
    _asked("topology_fetch", t.TopologyFetch, t.TopologyFile, "read one as GeoJSON"),
    _asked("topology_store", t.TopologyStore, t.TopologySaved, "take one in as GeoJSON", 30.0),
    Query("restart", "launcher", c.Restart, c.Done, "restart one process"),
)

TOPICS = {topic.name: topic for topic in _TOPICS}
QUERIES = {query.name: query for query in _QUERIES}


def topic_key(robot: str, topic: Topic, service: str) -> str:
    """Return the key that `service` publishes `topic` under (`*` as service: of all services)."""
    key = f"{PREFIX}/{_checked(robot)}/{topic.name}"
    return f"{key}/{service}" if topic.owner == EVERYONE else key


def query_key(robot: str, query: Query) -> str:
    """Return the key that answers `query`."""
    return f"{PREFIX}/{_checked(robot)}/@rpc/{query.service}/{query.name}"


def presence_key(robot: str, service: str) -> str:
    """Return the key of the presence token of `service` (`*`: of all services)."""
    return f"{PREFIX}/{_checked(robot)}/@alive/{service}"


def encoding(kind: type[Part]) -> str:
    """Return the encoding that travels with each payload of this message."""
    return f"application/cbor;{kind.__name__}.v{VERSION}"


def _checked(robot: str) -> str:
    if robot != "*" and not ROBOT_NAME.fullmatch(robot):
        raise ValueError(f"robot name '{robot}' must match [a-z0-9_]{{1,32}}")
    return robot
