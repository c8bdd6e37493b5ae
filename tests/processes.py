"""Real processes of Pilotage for tests: started, waited for, killed, never left behind."""

import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import Self

from waiting import eventually


def free_port() -> int:
    """Return a TCP port of this machine that nobody listens at now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def listens(port: int) -> bool:
    """Say whether somebody accepts connections at this port of the machine."""
    with socket.socket() as probe:
        probe.settimeout(0.5)
        return probe.connect_ex(("127.0.0.1", port)) == 0


class RouterProcess:
    """An embedded router in a process of its own that can be killed and started again.

    with RouterProcess(tmp_path) as router:
        open_fabric(router.endpoint)
    """

    def __init__(self, folder: Path) -> None:
        self.port = free_port()
        self.endpoint = f"tcp/127.0.0.1:{self.port}"
        self.deployment = folder / f"router_{self.port}.yaml"
        self.deployment.write_text(f"endpoint: {self.endpoint}\n", encoding="utf-8")
        module = [sys.executable, "-m", "pilotage.bus.router"]
        self.command = [*module, "--deployment", str(self.deployment)]
        self._process: subprocess.Popen[bytes] | None = None

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()

    def start(self) -> None:
        """Start the process and wait until it listens."""
        self._process = subprocess.Popen(self.command)
        eventually(lambda: listens(self.port), within=20.0, what="the router listening")

    def kill(self, number: int = signal.SIGKILL) -> int:
        """Send the signal, wait for the end and return the exit code."""
        if self._process is None:
            return 0
        process, self._process = self._process, None
        process.send_signal(number)
        return process.wait(timeout=10.0)
