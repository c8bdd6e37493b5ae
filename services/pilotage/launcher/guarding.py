"""The launcher's side of the guard that ends what outlives it."""

import contextlib
import subprocess
import sys
from pathlib import Path
from typing import Self

from pilotage.launcher import guard

END_S = 5.0


class Guarding:
    """The guard process; `watch` tells it of a child. Lives as long as its context."""

    def __enter__(self) -> Self:
        script = str(Path(guard.__file__))
        self._process = subprocess.Popen(  # noqa: S603 - our own script
            [sys.executable, "-I", "-S", script],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            process_group=0,
        )
        return self

    def watch(self, pid: int) -> None:
        """Let the guard know of a child; without a guard the kernel's death signal remains."""
        if self._process.stdin is not None:
            with contextlib.suppress(OSError):
                self._process.stdin.write(f"{pid}\n".encode())
                self._process.stdin.flush()

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(OSError):
            if self._process.stdin is not None:
                self._process.stdin.close()
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
