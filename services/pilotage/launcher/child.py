"""A running child process: its end, its state, its last words."""

import contextlib
import os
import signal
import subprocess
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO

REAP_S = 2.0
"""A killed process is gone within this time, unless the kernel holds it in a device."""

FLUSH_S = 0.5
"""The last lines of a process that has ended arrive within this time."""


class Child:
    """A process in a group of its own (so a terminal's Ctrl-C reaches the launcher alone).

    Each line of its output goes to `on_line(text)`, from a thread; a complaint (a line that
    begins with `pilotage NAME:`) is kept for `exit_reason` instead.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        environment: Mapping[str, str],
        on_line: Callable[[str], None],
    ) -> None:
        self._complaint = f"pilotage {name}: "
        self._on_line = on_line
        self._last_line = ""
        self._process = subprocess.Popen(  # noqa: S603 - the command comes from the process table
            command,
            env=dict(environment),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            process_group=0,
        )
        self._pump = threading.Thread(target=self._forward, name=f"output of {name}", daemon=True)
        self._pump.start()

    @property
    def pid(self) -> int:
        """The process id, which is also its group's."""
        return self._process.pid

    def poll(self) -> int | None:
        """Return the exit code, negative for a signal; None while it runs."""
        return self._process.poll()

    def exit_reason(self) -> str:
        """Return how it ended, with its last words, in one line."""
        self._pump.join(FLUSH_S)
        code = self._process.returncode
        how = f"killed by {_signal_name(-code)}" if code < 0 else f"ended with code {code}"
        return f"{how}: {self._last_line}" if self._last_line and code > 0 else how

    def is_stopped(self) -> bool:
        """Say whether it stands still by a signal (SIGSTOP)."""
        try:
            stat = Path(f"/proc/{self.pid}/stat").read_text(encoding="utf-8", errors="replace")
        except OSError:
            return False
        return stat.rpartition(")")[2].split()[0] == "T"

    def ask_to_end(self) -> None:
        """Ask it to end by itself; a stopped one goes on for that."""
        self._process.send_signal(signal.SIGTERM)
        self._process.send_signal(signal.SIGCONT)

    def kill(self) -> None:
        """End it, and what it may have started, at once."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(REAP_S)

    def _forward(self) -> None:
        output: IO[bytes] | None = self._process.stdout
        if output is None:
            return
        with output:
            for raw in output:
                self._take(raw.decode("utf-8", errors="replace").rstrip())

    def _take(self, line: str) -> None:
        if not line.strip():
            return
        self._last_line = line.removeprefix(self._complaint).strip()[:500]
        if not line.startswith(self._complaint):
            self._on_line(line)


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
