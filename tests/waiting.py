"""Waiting for a condition instead of sleeping: `eventually(lambda: robot.stands, within=2.0)`."""

import time
from collections.abc import Callable
from typing import TypeVar

Found = TypeVar("Found")

POLL_S = 0.005


def eventually(
    condition: Callable[[], Found], within: float = 5.0, what: str = "the condition"
) -> Found:
    """Return the first true value of `condition()`; fail when none has come `within` seconds."""
    deadline = time.monotonic() + within
    while True:
        found = condition()
        if found:
            return found
        if time.monotonic() >= deadline:
            raise AssertionError(f"{what} did not come true within {within:g} s (last: {found!r})")
        time.sleep(POLL_S)


def never(condition: Callable[[], object], during: float, what: str = "the condition") -> None:
    """Fail as soon as `condition()` is true within the next `during` seconds."""
    deadline = time.monotonic() + during
    while time.monotonic() < deadline:
        found = condition()
        if found:
            raise AssertionError(f"{what} came true: {found!r}")
        time.sleep(POLL_S)
