"""One client of the live stream: what it is sent, and the little it may say."""

import asyncio
import json

import cbor2
from starlette.websockets import WebSocket, WebSocketDisconnect

from pilotage.gateway.live_state import envelope
from pilotage.gateway.service import GatewayService
from pilotage.gateway.stream import Outbox

INVALID_DATA, SERVICE_RESTART, TRY_AGAIN_LATER = 1007, 1012, 1013
"""Close codes of RFC 6455 and its registry: nonsense came; the gateway goes; too slow."""

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
    sending = asyncio.create_task(_send(websocket, outbox))
    try:
        code = await _first_of(sending, asyncio.create_task(_listen(websocket, service, outbox)))
        await websocket.close(code)
    except WebSocketDisconnect:
        pass  # the client went first


async def _first_of(*tasks: asyncio.Task[int]) -> int:
    """Return the result of the task that ends first; the others are cancelled."""
    done, pending = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    for task in pending:
        task.cancel()
    await asyncio.gather(*pending, return_exceptions=True)
    return done.pop().result()


async def _send(websocket: WebSocket, outbox: Outbox) -> int:
    """Send from the outbox, as fast as the client takes it; return the code to close with."""
    while (data := await outbox.take()) is not None:
        try:
            async with asyncio.timeout(STUCK_S):
                await websocket.send_bytes(data)
        except TimeoutError as error:
            raise WebSocketDisconnect(TRY_AGAIN_LATER) from error
    return SERVICE_RESTART


async def _listen(websocket: WebSocket, service: GatewayService, outbox: Outbox) -> int:
    """Do what the client asks for until it talks nonsense; return the code to close with."""
    while True:
        message = await websocket.receive()
        if message["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(message.get("code", 1000))
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
