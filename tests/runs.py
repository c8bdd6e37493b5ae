"""Whole runs of Pilotage for tests: started, watched by their lines and their topic, ended."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Self

from pilotage.bus.clock import SystemClock
from pilotage.bus.node import Node
from pilotage.bus.session import open_fabric
from pilotage_schemas.health import Deployment, Process
from waiting import eventually

REPOSITORY = Path(__file__).resolve().parent.parent
SOURCES = [str(REPOSITORY / folder) for folder in ("services", "schemas", "tests")]


class Run:
    """A launcher in a process of its own and what it prints; nothing of it outlives the test.

    `module` is run with `arguments`; state goes to `folder`.
    """

    def __init__(self, module: str, arguments: Sequence[str], folder: Path) -> None:
        self.lines: list[str] = []
        self._command = [sys.executable, "-m", module, *arguments]
        self._environment = os.environ | {
            "PILOTAGE_STATE": str(folder / "state"),
            "PYTHONPATH": os.pathsep.join(SOURCES),
            "PYTHONUNBUFFERED": "1",
        }

    def __enter__(self) -> Self:
        self._process = subprocess.Popen(
            self._command,
            env=self._environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        return self

    def __exit__(self, *_: object) -> None:
        left = self.descendants()
        self._process.kill()
        self._process.wait(10.0)
        for pid in left:
            end(pid)
        self._reader.join(10.0)

    @property
    def pid(self) -> int:
        """The launcher's process id."""
        return self._process.pid

    @property
    def text(self) -> str:
        """Everything printed so far."""
        return "\n".join(self.lines)

    def send(self, number: int) -> None:
        """Send the launcher a signal."""
        self._process.send_signal(number)

    def ended(self, within: float = 15.0) -> int:
        """Wait for the launcher's end and return its exit code."""
        code = self._process.wait(within)
        self._reader.join(within)
        return code

    def descendants(self) -> list[int]:
        """Return the process ids of the launcher's children."""
        return [pid for pid, parent in parents().items() if parent == self.pid]

    def says(self, words: str, within: float = 20.0) -> None:
        """Wait until a line holds these words."""
        eventually(lambda: words in self.text or self._gone(), within, f"'{words}'")
        assert words in self.text, self.text

    def _gone(self) -> bool:
        return self._process.poll() is not None and not self._reader.is_alive()

    def _read(self) -> None:
        if self._process.stdout is not None:
            with self._process.stdout as output:
                self.lines.extend(line.rstrip() for line in output)


class Watch:
    """Follows the topic `deployment` of a run, as the page does."""

    def __init__(self, endpoint: str, robot: str = "demo") -> None:
        self.seen: list[tuple[float, Deployment]] = []
        self._endpoint, self._robot = endpoint, robot
        self._stack = ExitStack()

    def __enter__(self) -> Self:
        fabric = self._stack.enter_context(open_fabric(self._endpoint))
        self.node = Node("spectator", self._robot, fabric, SystemClock())
        self.node.subscribe("deployment", lambda m: self.seen.append((time.monotonic(), m)))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def processes(self) -> dict[str, Process]:
        """Return the newest state of every process."""
        self.node.step()
        return {one.name: one for one in self.seen[-1][1].processes} if self.seen else {}

    def pid(self, name: str) -> int:
        """Return the process id of a running process."""
        one = self.until(name, "ready")
        assert one.pid is not None
        return one.pid

    def until(self, name: str, *states: str, restarts: int = 0, within: float = 20.0) -> Process:
        """Wait until a process is in one of the states, restarted at least so often."""

        def found() -> Process | None:
            one = self.processes().get(name)
            matches = one is not None and one.state in states and one.restarts >= restarts
            return one if matches else None

        return eventually(found, within, f"{name} {'/'.join(states)}")  # type: ignore[return-value]  # eventually returns what is true

    def delay_of(self, name: str, since: float, *, ready: bool) -> float:
        """Return the seconds from `since` to the first message with `name` ready, or not."""
        self.node.step()
        for when, message in self.seen:
            for one in message.processes:
                if when >= since and one.name == name and (one.state == "ready") == ready:
                    return when - since
        raise AssertionError(f"{name} was never seen {'ready' if ready else 'otherwise'}")


def parents() -> dict[int, int]:
    """Return the parent of every process of this machine that is not a zombie."""
    found: dict[int, int] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if fields[0] != "Z":
            found[int(stat.parent.name)] = int(fields[1])
    return found


def lives(pid: int) -> bool:
    """Say whether a process exists and has not ended."""
    return pid in parents()


def end(pid: int) -> None:
    """End a process of a test that may have ended already."""
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return


def figure(text: str) -> None:
    """Show a measured figure to whoever runs the tests with -s."""
    sys.stdout.write(f"\n{text}\n")
