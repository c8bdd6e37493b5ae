"""Opens the page for whoever started the run, if there is a screen to open it on."""

import contextlib
import os
import sys
import threading
import webbrowser


def open_page(address: str) -> None:
    """Open the address in the user's browser; where there is none nothing happens."""
    if has_screen():
        # A thread, because some browsers hold their caller until they are closed.
        threading.Thread(target=_open, args=(address,), name="browser", daemon=True).start()


def has_screen() -> bool:
    """Say whether a graphical browser can show: a text browser would take the terminal."""
    if sys.platform == "darwin":
        return True
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def _open(address: str) -> None:
    with contextlib.suppress(webbrowser.Error, OSError):
        webbrowser.open(address)
