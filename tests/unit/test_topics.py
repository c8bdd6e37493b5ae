"""The registry: what it promises about itself."""

import re
from dataclasses import replace

import pytest

from pilotage_schemas.sensors import LaserScan
from pilotage_schemas.topics import (
    EVERYONE,
    PATCHES_KEPT,
    QUERIES,
    TOPICS,
    Query,
    Topic,
    encoding,
    presence_key,
    query_key,
    topic_key,
)

SERVICES = {"robot", "mapper", "localizer", "planner", "topology", "gateway", "launcher", EVERYONE}
every_topic = pytest.mark.parametrize("topic", TOPICS.values(), ids=lambda topic: topic.name)
every_query = pytest.mark.parametrize("query", QUERIES.values(), ids=lambda query: query.name)


@every_topic
def test_every_topic_is_named_in_snake_case_and_explained(topic: Topic) -> None:
    assert re.fullmatch(r"[a-z][a-z0-9_]*", topic.name)
    assert topic.summary


@every_topic
def test_every_topic_has_an_owner_that_is_a_service(topic: Topic) -> None:
    assert topic.owner in SERVICES


@every_topic
def test_streams_have_a_rate_and_a_stream_that_stops_is_noticed(topic: Topic) -> None:
    if topic.rate_hz is not None:
        assert topic.delivery == "latest_wins"
        assert topic.stale_after == max(0.5, 10.0 / topic.rate_hz)
    else:
        assert topic.stale_after is None


@every_query
def test_every_query_is_named_in_snake_case_explained_and_bounded(query: Query) -> None:
    assert re.fullmatch(r"[a-z][a-z0-9_]*", query.name)
    assert query.summary
    assert 0.0 < query.timeout_s <= 60.0


@every_query
def test_every_query_is_answered_by_a_service(query: Query) -> None:
    assert query.service in SERVICES - {EVERYONE}


def test_names_are_unique() -> None:
    keys = [topic_key("demo", topic, "mapper") for topic in TOPICS.values()]
    keys += [query_key("demo", query) for query in QUERIES.values()]
    assert len(keys) == len(set(keys))


def test_keys_are_as_designed() -> None:
    assert topic_key("demo", TOPICS["scan"], "robot") == "pilotage/@v1/demo/scan"
    assert topic_key("demo", TOPICS["health"], "mapper") == "pilotage/@v1/demo/health/mapper"
    assert query_key("demo", QUERIES["stop"]) == "pilotage/@v1/demo/@rpc/robot/stop"
    assert presence_key("demo", "mapper") == "pilotage/@v1/demo/@alive/mapper"
    assert encoding(LaserScan) == "application/cbor;LaserScan.v1"


@pytest.mark.parametrize("robot", ["", "Demo", "a b", "a/b", "ä", "**", "a" * 33, "a\n", "@x"])
def test_a_robot_name_that_would_break_keys_is_refused(robot: str) -> None:
    with pytest.raises(ValueError, match="robot name"):
        topic_key(robot, TOPICS["scan"], "robot")
    with pytest.raises(ValueError, match="robot name"):
        query_key(robot, QUERIES["stop"])
    with pytest.raises(ValueError, match="robot name"):
        presence_key(robot, "mapper")


def test_a_slow_stream_is_given_ten_periods() -> None:
    assert replace(TOPICS["scan"], rate_hz=1.0).stale_after == 10.0
    assert replace(TOPICS["scan"], rate_hz=100.0).stale_after == 0.5


def test_the_pose_is_the_mappers_while_it_maps_and_nothing_else_changes_hands() -> None:
    shared = {name: topic.publishers for name, topic in TOPICS.items() if topic.while_mapping}
    assert shared == {"pose": ("localizer", "mapper")}


def test_a_late_joiner_gets_all_patches_of_a_map() -> None:
    assert TOPICS["map_patch"].history == PATCHES_KEPT
    assert all(topic.history == 1 for topic in TOPICS.values() if topic.name != "map_patch")
