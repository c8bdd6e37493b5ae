"""What people see of a run: one line per event, the services' own output beside it."""

import contextlib
import sys
import threading
from typing import TextIO

NAME_WIDTH = 10


class Console:
    """Writes whole lines from any thread; a reader that has gone away disturbs nothing."""

    def __init__(self, events: TextIO | None = None, output: TextIO | None = None) -> None:
        self._events = events or sys.stdout
        self._output = output or sys.stderr
        self._lock = threading.Lock()

    def say(self, text: str) -> None:
        """Write a line about the run as a whole."""
        self._write(self._events, text)

    def event(self, name: str, text: str) -> None:
        """Write what happened to a process."""
        self._write(self._events, f"{name:<{NAME_WIDTH}} {text}")

    def output(self, name: str, line: str) -> None:
        """Pass on a line that a process wrote."""
        self._write(self._output, f"{name:<{NAME_WIDTH}} | {line}")

    def _write(self, stream: TextIO, line: str) -> None:
        with self._lock, contextlib.suppress(OSError, ValueError):
            stream.write(f"{line}\n")
            stream.flush()
