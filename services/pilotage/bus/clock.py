"""Time as an argument: services read it from their node, tests turn it by hand."""

import time
from dataclasses import dataclass
from typing import Protocol


class Clock(Protocol):
    """Two times: of the world (stamps) and of the machine (waiting)."""

    def now_ns(self) -> int:
        """Return Unix time in nanoseconds."""
        ...

    def monotonic(self) -> float:
        """Return seconds that never go backwards."""
        ...


class SystemClock:
    """The machine's own clocks."""

    def now_ns(self) -> int:
        """Return Unix time in nanoseconds."""
        return time.time_ns()

    def monotonic(self) -> float:
        """Return seconds that never go backwards."""
        return time.monotonic()


@dataclass
class HandClock:
    """A clock that stands still until `advance` turns it."""

    seconds: float = 1_000_000.0

    def now_ns(self) -> int:
        """Return the set time in nanoseconds."""
        return round(self.seconds * 1e9)

    def monotonic(self) -> float:
        """Return the set time in seconds."""
        return self.seconds

    def advance(self, seconds: float) -> None:
        """Turn the clock forward."""
        self.seconds += seconds
