"""Events as server-sent events (WHATWG HTML, section 9.2)."""

import asyncio
import json
from collections.abc import AsyncIterator
from dataclasses import asdict

from pilotage.gateway.event_log import Event, EventLog

KEEP_ALIVE_S = 10.0
"""Silence after which a comment is sent, so that both ends notice a broken connection."""


class EventFollower:
    """Yields the kept events after `after_id` and then each new one, until closed."""

    def __init__(self, log: EventLog, after_id: int) -> None:
        self._log = log
        self._last_id = after_id
        self._wake = asyncio.Event()
        self._is_closed = False

    async def __aiter__(self) -> AsyncIterator[bytes]:
        """Yield what is to be sent."""
        self._log.listen(self._wake.set)
        try:
            yield b": events\n\n"
            while not self._is_closed:
                self._wake.clear()
                for event in self._log.after(self._last_id):
                    self._last_id = event.id
                    yield encoded(event)
                if not await self._woken():
                    yield b": still here\n\n"
        finally:
            self._log.unlisten(self._wake.set)

    def close(self) -> None:
        """End the iteration."""
        self._is_closed = True
        self._wake.set()

    async def _woken(self) -> bool:
        try:
            async with asyncio.timeout(KEEP_ALIVE_S):
                return await self._wake.wait()
        except TimeoutError:
            return False


def encoded(event: Event) -> bytes:
    """Return one event in the form of an event stream; JSON holds no line breaks."""
    return f"id: {event.id}\ndata: {json.dumps(asdict(event))}\n\n".encode()


def parsed_id(last_event_id: str | None) -> int:
    """Return the id after which a client that reconnects wants to go on; 0: from the first."""
    if last_event_id is None or not last_event_id.isascii() or not last_event_id.isdigit():
        return 0
    return int(last_event_id[:20])
