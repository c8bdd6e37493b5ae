"""Live messages to many clients, each at its own pace: the newest of every topic wins.

A slow client misses messages in between but never holds up others, and holds at most one
message per topic and service in memory.
"""

import asyncio
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager

Key = tuple[str, str]
"""Topic and service."""

Item = tuple[Key, Callable[[], bytes]]
"""What is sent in place of what waits under the same key, made when it is sent."""


MOST_STEPS = 32
"""So many patches of a map wait for a slow client at most; then it gets the whole map."""


class Outbox:
    """What waits to be sent to one client."""

    def __init__(self, topics: Collection[str] | None = None) -> None:
        self._topics = topics
        self._pending: dict[Key, Callable[[], bytes]] = {}
        self._wake = asyncio.Event()
        self._is_paused = False
        self._is_closed = False

    def put(self, key: Key, make: Callable[[], bytes]) -> None:
        """Let `make()` be sent in place of what still waits under `key`."""
        if self._is_paused or (self._topics is not None and key[0] not in self._topics):
            return
        self._pending[key] = make
        self._wake.set()

    def put_step(self, key: Key, make: Callable[[], bytes], whole: Item) -> None:
        """Let `make()` be sent after all steps of its topic that still wait.

        A client that is so slow that `MOST_STEPS` wait gets `whole` in place of them all.
        """
        if self._is_paused or (self._topics is not None and key[0] not in self._topics):
            return
        waiting = [other for other in self._pending if other[0] == key[0]]
        if len(waiting) < MOST_STEPS:
            self.put(key, make)
            return
        for other in waiting:
            del self._pending[other]
        self.put(*whole)

    def put_own(self, name: str, data: bytes) -> None:
        """Send an answer of the gateway itself, paused or not, whatever was asked for."""
        self._pending[name, "gateway"] = lambda: data
        self._wake.set()

    @property
    def has_more(self) -> bool:
        """Whether something waits."""
        return bool(self._pending)

    async def take(self) -> bytes | None:
        """Return the next message to send, waiting for it; None when closed."""
        while not self._pending and not self._is_closed:
            self._wake.clear()
            await self._wake.wait()
        if self._is_closed:
            return None
        return self._pending.pop(next(iter(self._pending)))()

    def pause(self) -> None:
        """Take nothing in until `resume`."""
        self._is_paused = True
        self._pending.clear()

    def resume(self, picture: Iterable[Item]) -> None:
        """Send the whole picture and then what changes."""
        self._is_paused = False
        for key, make in picture:
            self.put(key, make)

    def close(self) -> None:
        """Let `take` return None."""
        self._is_closed = True
        self._wake.set()


class TooManyStreamsError(RuntimeError):
    """No further stream is admitted: the limit is reached, or the gateway is closing."""


class Hub:
    """All open streams: what is published reaches every outbox, and all can be ended."""

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._outboxes: set[Outbox] = set()
        self._enders: list[Callable[[], None]] = []
        self._is_closed = False

    @property
    def count(self) -> int:
        """How many streams are open."""
        return len(self._enders)

    @property
    def is_full(self) -> bool:
        """Whether no further stream is admitted."""
        return self._is_closed or self.count >= self._limit

    @contextmanager
    def admitted(self, end: Callable[[], None]) -> Iterator[None]:
        """Count a stream while it lasts; `end()` is called when all are to end."""
        if self.is_full:
            raise TooManyStreamsError(f"at most {self._limit} streams can be open at once")
        self._enders.append(end)
        try:
            yield
        finally:
            self._enders.remove(end)

    @contextmanager
    def feeding(self, outbox: Outbox) -> Iterator[None]:
        """Admit a stream and let its outbox have all that is published while it lasts."""
        with self.admitted(outbox.close):
            self._outboxes.add(outbox)
            try:
                yield
            finally:
                self._outboxes.discard(outbox)

    def publish(self, key: Key, make: Callable[[], bytes]) -> None:
        """Offer a message to every outbox; it is made only if somebody takes it."""
        for outbox in self._outboxes:
            outbox.put(key, make)

    def publish_step(self, key: Key, make: Callable[[], bytes], whole: Item) -> None:
        """Offer to every outbox a message that means nothing without those before it."""
        for outbox in self._outboxes:
            outbox.put_step(key, make, whole)

    def close(self) -> None:
        """End every stream and admit no more."""
        self._is_closed = True
        for end in list(self._enders):
            end()
