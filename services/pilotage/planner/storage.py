"""What the planner keeps on disk: what it was told to do from now on, and what it was doing.

A file is the checksum of its content and then the content, so that a damaged one is told from a
whole one; it is written beside the old one and then takes its place.
"""

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

FILE = "planner.orders"


@dataclass(frozen=True)
class Orders:
    """`always`: whether every doubt is resolved unasked; `task`: what is being done, in words."""

    always: bool
    task: str = ""


def save_orders(folder: Path | None, orders: Orders, warn: Callable[[str], None]) -> None:
    """Keep the orders in place of the last ones; what cannot be kept is told to `warn`."""
    if folder is None:
        return
    content = json.dumps(asdict(orders)).encode()
    temporary = folder / f"{FILE}.new"
    try:
        temporary.write_bytes(hashlib.sha256(content).digest() + content)
        temporary.replace(folder / FILE)
    except OSError as error:
        warn(f"not kept: {error}")


def load_orders(folder: Path | None, warn: Callable[[str], None]) -> Orders | None:
    """Return what was kept; None if there is nothing, or (told to `warn`) if it is damaged."""
    if folder is None:
        return None
    try:
        whole = (folder / FILE).read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        warn(f"{FILE} is ignored: {error.strerror}")
        return None
    length = hashlib.sha256().digest_size
    if hashlib.sha256(whole[length:]).digest() != whole[:length]:
        warn(f"{FILE} is ignored: it is damaged")
        return None
    try:
        values = json.loads(whole[length:])
        return Orders(always=bool(values["always"]), task=str(values["task"]))
    except (KeyError, TypeError, ValueError):
        warn(f"{FILE} is ignored: another version wrote it")
        return None
