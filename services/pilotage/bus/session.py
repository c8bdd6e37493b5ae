"""The fabric over Zenoh: every service is a client of one router.

Each default that listens on the network, scouts, shares memory or waits is replaced (peers
with listeners would bypass the router's access rules, and implicit shared memory drops samples
when a receiver is descheduled: zenoh issue 2628).
"""

import json
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import zenoh
import zenoh.ext

from pilotage.bus.fabric import (
    BusError,
    NoAnswerError,
    NoAnswerInTimeError,
    Question,
    RefusedError,
    Sample,
)
from pilotage_schemas.topics import Delivery

LEASE_MS = 1000
"""A partner that hangs is declared gone after this long; keep-alives go out four times as often."""

CONNECT_TIMEOUT_MS = 15_000
RETRY_MS = {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 2}
CACHED_SAMPLES = 32
MISS_HEARTBEAT_MS = 500


def client_config(endpoint: str, user: str | None, password: str | None) -> zenoh.Config:
    """Return the configuration of a client of the router at `endpoint`."""
    settings: dict[str, object] = common_settings() | {
        "mode": "client",
        "listen/endpoints": [],
        "connect/endpoints": [endpoint],
        "connect/timeout_ms": CONNECT_TIMEOUT_MS,
        "connect/retry": RETRY_MS,
    }
    if user is not None:
        settings["transport/auth/usrpwd"] = {"user": user, "password": password}
    return config_from(settings)


def common_settings() -> dict[str, object]:
    """Return what routers and clients have in common."""
    return {
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,
        "transport/shared_memory/enabled": False,
        "transport/link/tx/lease": LEASE_MS,
        "timestamping/enabled": True,
    }


def config_from(settings: dict[str, object]) -> zenoh.Config:
    """Return a Zenoh configuration; an unknown key or value raises BusError."""
    config = zenoh.Config()
    for key, value in settings.items():
        try:
            config.insert_json5(key, json.dumps(value))
        except zenoh.ZError as error:
            raise BusError(f"bus setting {key}: {error}") from error
    return config


@contextmanager
def open_fabric(
    endpoint: str, user: str | None = None, password: str | None = None
) -> Iterator["ZenohFabric"]:
    """Connect to the router at `endpoint`, waiting up to 15 s for it, and close at the end."""
    try:
        session = zenoh.open(client_config(endpoint, user, password))
    except zenoh.ZError as error:
        raise BusError(
            f"no router answers at {endpoint} (not running, or it refuses this user): {error}"
        ) from error
    fabric = ZenohFabric(session)
    try:
        yield fabric
    finally:
        fabric.close()


class ZenohFabric:
    """Carries bytes over a Zenoh session; everything declared lives until `close`."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self._declared: list[object] = []

    def declare_publisher(
        self, key: str, encoding: str, delivery: Delivery, history: int = 1
    ) -> Callable[[bytes], None]:
        """Return the function that publishes a payload under `key`."""
        publisher = (
            self._session.declare_publisher(
                key, encoding=encoding, congestion_control=zenoh.CongestionControl.DROP
            )
            if delivery == "latest_wins"
            else self._advanced_publisher(key, encoding, history)
        )
        self._declared.append(publisher)

        def put(payload: bytes) -> None:
            try:
                publisher.put(payload)
            except zenoh.ZError as error:
                raise BusError(f"{key} cannot be published: {error}") from error

        return put

    def declare_subscriber(
        self, key: str, delivery: Delivery, on_sample: Callable[[Sample], None], history: int = 1
    ) -> None:
        """Call `on_sample` for each payload under `key`, from a thread of Zenoh's."""

        def receive(sample: zenoh.Sample) -> None:
            on_sample(Sample(str(sample.key_expr), sample.payload.to_bytes()))

        if delivery == "latest_wins":
            self._declared.append(self._session.declare_subscriber(key, receive))
        else:
            self._declared.append(self._advanced_subscriber(key, receive, history))

    def declare_queryable(self, key: str, on_question: Callable[[Question], None]) -> None:
        """Call `on_question` for each query of `key`, from a thread of Zenoh's."""

        def receive(query: zenoh.Query) -> None:
            payload = query.payload.to_bytes() if query.payload is not None else b""
            on_question(Question(payload, _replier(query, key), _refuser(query)))

        self._declared.append(self._session.declare_queryable(key, receive))

    def ask(self, key: str, payload: bytes, timeout_s: float) -> bytes:
        """Return the answer to a query; NoAnswerError or RefusedError otherwise."""
        try:
            replies = self._session.get(key, payload=payload, timeout=timeout_s)
        except zenoh.ZError as error:
            raise BusError(f"{key} cannot be asked: {error}") from error
        for reply in replies:
            if reply.ok is not None:
                return reply.ok.payload.to_bytes()
            if reply.err is not None:
                reason = reply.err.payload.to_bytes()
                if reason == b"Timeout":
                    raise NoAnswerInTimeError(f"no answer within {timeout_s:g} s")
                raise RefusedError(reason)
        raise NoAnswerError("the service is not running")

    def declare_presence(self, key: str) -> None:
        """Announce `key` as present until this fabric closes or its process dies."""
        self._declared.append(self._session.liveliness().declare_token(key))

    def watch_presence(self, key: str, on_change: Callable[[str, bool], None]) -> None:
        """Call `on_change(key, present)` for what is present now and for each change."""

        def receive(sample: zenoh.Sample) -> None:
            on_change(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)

        liveliness = self._session.liveliness()
        self._declared.append(liveliness.declare_subscriber(key, receive, history=True))

    def is_connected(self) -> bool:
        """Say whether the router can be reached now."""
        return len(self._session.info.routers_zid()) > 0

    def close(self) -> None:
        """Withdraw everything and leave."""
        self._session.close()  # type: ignore[no-untyped-call]  # zenoh's stub lacks it
        self._declared.clear()

    def _advanced_publisher(
        self, key: str, encoding: str, history: int
    ) -> zenoh.ext.AdvancedPublisher:
        return zenoh.ext.declare_advanced_publisher(
            self._session,
            key,
            encoding=encoding,
            congestion_control=zenoh.CongestionControl.BLOCK,
            cache=zenoh.ext.CacheConfig(max_samples=max(CACHED_SAMPLES, history)),
            sample_miss_detection=zenoh.ext.MissDetectionConfig(
                heartbeat=MISS_HEARTBEAT_MS / 1000, sporadic_heartbeat=None
            ),
            publisher_detection=True,
        )

    def _advanced_subscriber(
        self, key: str, receive: Callable[[zenoh.Sample], None], history: int
    ) -> "zenoh.ext.AdvancedSubscriber[None]":
        return zenoh.ext.declare_advanced_subscriber(
            self._session,
            key,
            receive,
            history=zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=history),
            recovery=zenoh.ext.RecoveryConfig(heartbeat=True, periodic_queries=None),
            subscriber_detection=True,
        )


def _replier(query: zenoh.Query, key: str) -> Callable[[bytes], None]:
    def reply(payload: bytes) -> None:
        with _asker_may_be_gone(query):
            query.reply(key, payload)

    return reply


def _refuser(query: zenoh.Query) -> Callable[[bytes], None]:
    def refuse(payload: bytes) -> None:
        with _asker_may_be_gone(query):
            query.reply_err(payload)

    return refuse


@contextmanager
def _asker_may_be_gone(query: zenoh.Query) -> Iterator[None]:
    try:
        yield
        query.drop()  # type: ignore[no-untyped-call]  # zenoh's stub lacks it
    except zenoh.ZError as error:
        logging.getLogger("pilotage.bus").warning("an answer could not be sent: %s", error)
