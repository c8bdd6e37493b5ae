"""What happened, for people: the newest few hundred events, numbered."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

KEPT = 300
REPEAT_S = 5.0
"""The same again within this time is no news."""

Severity = Literal["info", "warning", "fault"]
Kind = Literal["localization", "service", "link", "command", "refusal", "kidnap", "map", "place"]


@dataclass(frozen=True)
class Event:
    """One event; `id` grows and is unique across restarts of the gateway: Unix time in us."""

    id: int
    stamp_ns: int
    kind: Kind
    severity: Severity
    text: str


class EventLog:
    """A ring of events and those who wait for the next."""

    def __init__(self) -> None:
        self._events: deque[Event] = deque(maxlen=KEPT)
        self._listeners: set[Callable[[], None]] = set()

    def append(self, stamp_ns: int, kind: Kind, severity: Severity, text: str) -> Event:
        """Add an event and tell the listeners; return the old one when it says the same."""
        last = self._events[-1] if self._events else None
        if last is not None and last.text == text and stamp_ns - last.stamp_ns < REPEAT_S * 1e9:
            return last
        number = max(stamp_ns // 1000, last.id + 1 if last else 0)
        event = Event(number, stamp_ns, kind, severity, text)
        self._events.append(event)
        for listener in list(self._listeners):
            listener()
        return event

    def after(self, event_id: int) -> list[Event]:
        """Return the kept events with a greater id, oldest first."""
        return [event for event in self._events if event.id > event_id]

    def listen(self, listener: Callable[[], None]) -> None:
        """Call `listener` at each new event, until `unlisten`."""
        self._listeners.add(listener)

    def unlisten(self, listener: Callable[[], None]) -> None:
        """Cease to call `listener`."""
        self._listeners.discard(listener)
