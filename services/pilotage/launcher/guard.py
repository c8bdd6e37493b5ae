"""Ends what outlives the launcher: run as a script of its own, `python -I -S guard.py`.

The kernel tells children of their parent's death (PR_SET_PDEATHSIG, which each service asks for),
but one that hangs does not listen. The guard holds a handle (pidfd) of each child, learns of the
launcher's end by the end of its standard input, and kills what is still there after the grace (it
does not ask again: a service takes a second request as an order to drop everything). It imports
nothing of Pilotage, so that it is small and starts at once.
"""

import contextlib
import os
import select
import signal
import sys
import time

GRACE_S = 2.0
"""What is asked to end may take this long to do so."""


def main() -> None:
    """Read one pid per line until the launcher closes the pipe or dies; then clear up."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    handles: set[int] = set()
    for line in sys.stdin:
        handles = {handle for handle in handles if not _has_ended(handle)}
        with contextlib.suppress(OSError):
            handles.add(os.pidfd_open(int(line)))
    clear_up(handles, GRACE_S)


def clear_up(handles: set[int], grace: float) -> None:
    """Let the processes end by themselves for up to `grace` s, then kill the rest."""
    for handle in handles:
        _send(handle, signal.SIGCONT)
    deadline = time.monotonic() + grace
    while handles and (left := deadline - time.monotonic()) > 0:
        ended, _, _ = select.select(list(handles), [], [], left)
        handles = handles - set(ended)
    for handle in handles:
        _send(handle, signal.SIGKILL)


def _has_ended(handle: int) -> bool:
    if not select.select([handle], [], [], 0)[0]:
        return False
    os.close(handle)
    return True


def _send(handle: int, number: signal.Signals) -> None:
    with contextlib.suppress(ProcessLookupError):
        signal.pidfd_send_signal(handle, number)


if __name__ == "__main__":
    main()
