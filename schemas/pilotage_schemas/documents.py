"""The contract in the words of others: JSON Schemas and an AsyncAPI 3 document."""

from typing import Any

from pilotage_schemas.commands import Refused
from pilotage_schemas.message import Part
from pilotage_schemas.topics import (
    EVERYONE,
    PREFIX,
    QUERIES,
    TOPICS,
    VERSION,
    Query,
    Topic,
    encoding,
)

Json = dict[str, Any]

ROBOT = {"robot": {"description": "name of the robot, [a-z0-9_]{1,32}"}}


def all_kinds() -> list[type[Part]]:
    """Return every message, request and reply of the registry, by name."""
    kinds = {topic.message for topic in TOPICS.values()}
    asked = {kind for query in QUERIES.values() for kind in (query.request, query.reply)}
    return sorted(kinds | asked | {Refused}, key=lambda kind: kind.__name__)


def json_schema(kind: type[Part]) -> Json:
    """Return the JSON Schema of a message; arrays carry `x-dtype`, `x-axes` and `x-finite`."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"pilotage/v{VERSION}/{kind.__name__}.json",
        "x-encoding": encoding(kind),
        **kind.model_json_schema(),
    }


def asyncapi() -> Json:
    """Return the AsyncAPI document of all topics and queries."""
    channels = {topic.name: _topic_channel(topic) for topic in TOPICS.values()}
    operations = {f"publish_{topic.name}": _publication(topic) for topic in TOPICS.values()}
    for query in QUERIES.values():
        channels[f"query_{query.name}"] = _query_channel(query)
        operations[f"answer_{query.name}"] = _answer(query)
    return {
        "asyncapi": "3.0.0",
        "info": {
            "title": "Pilotage",
            "version": f"{VERSION}.0.0",
            "description": "Messages on the Zenoh bus: CBOR, arrays as in RFC 8746.",
        },
        "defaultContentType": "application/cbor",
        "channels": channels,
        "operations": operations,
        "components": {"messages": {kind.__name__: _message(kind) for kind in all_kinds()}},
    }


def _message(kind: type[Part]) -> Json:
    return {
        "name": kind.__name__,
        "contentType": encoding(kind),
        "payload": {"$ref": f"./{kind.__name__}.json"},
    }


def _topic_channel(topic: Topic) -> Json:
    each = "/{service}" if topic.owner == EVERYONE else ""
    service = {"service": {"description": "the publishing service"}} if each else {}
    return {
        "address": f"{PREFIX}/{{robot}}/{topic.name}{each}",
        "summary": topic.summary,
        "parameters": ROBOT | service,
        "messages": _carried(topic.message),
        "x-delivery": topic.delivery,
        "x-rate-hz": topic.rate_hz,
        "x-stale-after-s": topic.stale_after,
    }


def _query_channel(query: Query) -> Json:
    return {
        "address": f"{PREFIX}/{{robot}}/@rpc/{query.service}/{query.name}",
        "summary": query.summary,
        "parameters": ROBOT,
        "messages": _carried(query.request) | _carried(query.reply),
        "x-timeout-s": query.timeout_s,
    }


def _carried(kind: type[Part]) -> Json:
    return {kind.__name__: {"$ref": f"#/components/messages/{kind.__name__}"}}


def _publication(topic: Topic) -> Json:
    return {
        "action": "send",
        "channel": {"$ref": f"#/channels/{topic.name}"},
        "summary": topic.summary,
        "messages": [_message_of(topic.name, topic.message)],
        "x-owner": "every service" if topic.owner == EVERYONE else topic.owner,
        "x-while-mapping": topic.while_mapping,
    }


def _answer(query: Query) -> Json:
    channel = f"query_{query.name}"
    return {
        "action": "receive",
        "channel": {"$ref": f"#/channels/{channel}"},
        "summary": query.summary,
        "messages": [_message_of(channel, query.request)],
        "reply": {
            "channel": {"$ref": f"#/channels/{channel}"},
            "messages": [_message_of(channel, query.reply)],
        },
        "x-owner": query.service,
    }


def _message_of(channel: str, kind: type[Part]) -> Json:
    return {"$ref": f"#/channels/{channel}/messages/{kind.__name__}"}
