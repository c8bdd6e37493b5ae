"""Ctrl-C: the first asks, the second forces. SIGTERM and a closed terminal are the same."""

import os
import signal
from collections.abc import Callable
from contextlib import AbstractContextManager
from types import FrameType
from typing import Self

NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class StopSignals(AbstractContextManager["StopSignals"]):
    """Within its context the first signal sets `asked` and calls `on_ask`, the second `force`.

    `asked_by` is the name of the first, empty before it.
    `force()` runs in the signal handler, and the process ends right after it.
    """

    def __init__(self, force: Callable[[], None]) -> None:
        self.asked_by = ""
        self.on_ask: Callable[[], None] = lambda: None
        self._force = force
        self._former = {number: signal.getsignal(number) for number in NUMBERS}

    @property
    def asked(self) -> bool:
        """Whether a signal has come."""
        return bool(self.asked_by)

    def __enter__(self) -> Self:
        for number in NUMBERS:
            signal.signal(number, self._receive)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._former.items():
            signal.signal(number, handler)

    def _receive(self, number: int, _frame: FrameType | None) -> None:
        if self.asked:
            self._force()
            os._exit(128 + number)
        self.asked_by = signal.Signals(number).name
        self.on_ask()
