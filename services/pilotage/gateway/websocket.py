"""One client of the live stream: what it is sent, and the little it may say."""

import asyncio
import contextlib
import json

import cbor2
from starlette.websockets import WebSocket, WebSocketDisconnect

from pilotage.gateway.live_state import envelope
from pilotage.gateway.service import GatewayService
from pilotage.gateway.stream import Outbox

GONE, INVALID_DATA, SERVICE_RESTART = 1006, 1007, 1012
"""Close codes of RFC 6455 and its registry; the first is never sent: nobody would read it."""

STUCK_S = 30.0
"""A client that takes nothing for this long loses its place; it may come again."""

MAX_NUMBER = 2**53
"""JavaScript's whole numbers end here."""


class BadMessageError(ValueError):
    """The client said something that has no meaning here."""


async def serve_client(websocket: WebSocket, service: GatewayService, outbox: Outbox) -> None:
    """Send the full picture and then what changes, until either side goes."""
    await websocket.accept()
    outbox.put_own("hello", service.hello())
    outbox.resume(service.picture())
    async with asyncio.TaskGroup() as tasks:
        sending = tasks.create_task(_send(websocket, outbox))
        listening = tasks.create_task(_listen(websocket, service, outbox))
        await asyncio.wait((sending, listening), return_when=asyncio.FIRST_COMPLETED)
        sending.cancel()
        listening.cancel()
    codes = {task.result() for task in (sending, listening) if not task.cancelled()}
    if GONE not in codes:
        with contextlib.suppress(WebSocketDisconnect):
            await websocket.close(codes.pop())


async def _send(websocket: WebSocket, outbox: Outbox) -> int:
    """Send from the outbox, as fast as the client takes it; return the code to close with."""
    while (data := await outbox.take()) is not None:
        try:
            async with asyncio.timeout(STUCK_S):
                await websocket.send_bytes(data)
        except (TimeoutError, WebSocketDisconnect):
            return GONE
    return SERVICE_RESTART


async def _listen(websocket: WebSocket, service: GatewayService, outbox: Outbox) -> int:
    """Do what the client asks for until it talks nonsense; return the code to close with."""
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            return GONE
        try:
            _obey(message.get("text"), service, outbox)
        except BadMessageError:
            return INVALID_DATA


def _obey(text: str | None, service: GatewayService, outbox: Outbox) -> None:
    match _parsed(text):
        case {"pause": True}:
            outbox.pause()
        case {"pause": False}:
            outbox.resume(service.picture())
        case {"ping": int(number)} if 0 <= number <= MAX_NUMBER:
            now_ns = service.node.clock.now_ns()
            outbox.put_own("pong", envelope("pong", cbor2.dumps(number), received_ns=now_ns))
        case _:
            raise BadMessageError(text)


def _parsed(text: str | None) -> object:
    try:
        return json.loads(text or "")
    except (ValueError, RecursionError) as error:
        raise BadMessageError(text) from error
