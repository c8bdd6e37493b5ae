"""Steps a node in an asyncio loop, in place of the node's own loop."""

import asyncio
import contextlib

from pilotage.bus.node import Node


async def pump(node: Node) -> None:
    """Step `node` whenever something has come or is due, until it is stopped.

    Handlers run in this loop, so they share its state without locks.
    """
    loop = asyncio.get_running_loop()
    arrival = asyncio.Event()

    def wake() -> None:
        loop.call_soon_threadsafe(arrival.set)

    node.on_arrival = wake
    try:
        while not node.is_stopping:
            pause = node.step()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(pause):
                    await arrival.wait()
            arrival.clear()
    finally:
        node.on_arrival = lambda: None
