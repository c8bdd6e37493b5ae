"""What a bus must be able to do, in bytes and keys: Zenoh does it, and a fake for tests."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from pilotage_schemas.topics import Delivery


class BusError(RuntimeError):
    """The bus could not do what was asked; the text says why, in one line."""


class NoAnswerError(BusError):
    """Nobody answers this query now, or not in time."""


class NoAnswerInTimeError(NoAnswerError):
    """The service is there, but has not answered within the query's time limit."""


class RefusedError(BusError):
    """The service that owns the query refused it; the text is its reason."""


@dataclass(frozen=True)
class Sample:
    """One received payload and the key it came by."""

    key: str
    payload: bytes

    @property
    def source(self) -> str:
        """The last part of the key: the topic, or the service where each publishes its own."""
        return self.key.rsplit("/", 1)[-1]


@dataclass(frozen=True)
class Question:
    """One received query; exactly one of `reply` and `refuse` must be called."""

    payload: bytes
    reply: Callable[[bytes], None]
    refuse: Callable[[bytes], None]


class Fabric(Protocol):
    """Carries bytes between services. Callbacks may come from any thread and must only enqueue."""

    def declare_publisher(
        self, key: str, encoding: str, delivery: Delivery, history: int = 1
    ) -> Callable[[bytes], None]:
        """Return the function that publishes a payload under `key`.

        Of what must not drop, the last `history` payloads at least are kept for late joiners.
        """
        ...

    def declare_subscriber(
        self, key: str, delivery: Delivery, on_sample: Callable[[Sample], None], history: int = 1
    ) -> None:
        """Call `on_sample` for each payload under `key`, which may hold `*`.

        Of what must not drop, the last `history` payloads come first.
        """
        ...

    def declare_queryable(self, key: str, on_question: Callable[[Question], None]) -> None:
        """Call `on_question` for each query of `key`."""
        ...

    def ask(self, key: str, payload: bytes, timeout_s: float) -> bytes:
        """Return the answer; NoAnswerError in its absence; RefusedError carries raw bytes.

        May be called from any thread.
        """
        ...

    def declare_presence(self, key: str) -> None:
        """Announce `key` as present until this fabric closes or its process dies."""
        ...

    def watch_presence(self, key: str, on_change: Callable[[str, bool], None]) -> None:
        """Call `on_change(key, present)` for what is present now and for each change."""
        ...

    def is_connected(self) -> bool:
        """Say whether the router can be reached now."""
        ...

    def close(self) -> None:
        """Withdraw everything that was declared."""
        ...
