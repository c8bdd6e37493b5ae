"""Carries commands out over the bus and says what became of them."""

import asyncio
from concurrent.futures import ThreadPoolExecutor

from pilotage.bus.fabric import BusError, NoAnswerInTimeError, RefusedError
from pilotage.bus.node import Node
from pilotage.gateway.event_log import EventLog, Kind, Severity
from pilotage.gateway.problems import ProblemError
from pilotage_schemas.codec import DecodeError
from pilotage_schemas.commands import Kidnapped
from pilotage_schemas.message import Part
from pilotage_schemas.topics import Query

MAX_WAITING = 16
THREADS_FOR_STOP = 8
"""A robot that does not answer must not keep `stop` from being sent: it has threads left."""

UNLOGGED = frozenset(
    {
        *("velocity", "map_list", "map_fetch", "topology_list", "topology_fetch"),
        *("topology_route", "nearest_node"),
    }
)
"""What changes nothing, or comes many times a second while somebody drives: no news but refused."""


class Commander:
    """Asks the services and writes the answers to the event log.

    Asking blocks, so it happens in threads; they touch nothing but the fabric.
    """

    def __init__(self, node: Node, events: EventLog) -> None:
        self._node = node
        self._events = events
        self._waiting = 0
        self._closed = asyncio.Event()
        self._threads = ThreadPoolExecutor(MAX_WAITING + THREADS_FOR_STOP, "command")

    async def carry_out(self, query: Query, request: Part) -> Part:
        """Return the reply of the service that owns the query, or raise ProblemError."""
        if self._waiting >= MAX_WAITING and query.name != "stop":
            raise ProblemError(429, f"{self._waiting} commands wait for their answers already")
        self._waiting += 1
        try:
            reply = await self._asked(query, request)
        except ProblemError as problem:
            self._log("refusal", "warning", f"{query.name}: {problem.detail}")
            raise
        finally:
            self._waiting -= 1
        self._log_success(query, reply)
        return reply

    def close(self) -> None:
        """Answer those who wait that the gateway stops; no thread is waited for."""
        self._closed.set()
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def _asked(self, query: Query, request: Part) -> Part:
        try:
            return await self._answer(query, request)
        except RefusedError as error:
            raise ProblemError(409, str(error)) from error
        except NoAnswerInTimeError as error:
            raise ProblemError(504, f"{query.service}: {error}") from error
        except BusError as error:
            raise ProblemError(503, f"{query.service}: {error}") from error
        except DecodeError as error:
            detail = f"the answer of {query.service} cannot be read: {error}"
            raise ProblemError(502, detail) from error

    async def _answer(self, query: Query, request: Part) -> Part:
        if self._closed.is_set():
            raise ProblemError(503, "the gateway is stopping")
        loop = asyncio.get_running_loop()
        answer = loop.run_in_executor(self._threads, self._node.ask, query.name, request)
        closing = asyncio.create_task(self._closed.wait())
        await asyncio.wait((answer, closing), return_when=asyncio.FIRST_COMPLETED)
        closing.cancel()
        if not answer.done():
            answer.cancel()
            raise ProblemError(503, "the gateway is stopping; whether it was done is not known")
        return answer.result()

    def _log_success(self, query: Query, reply: Part) -> None:
        if isinstance(reply, Kidnapped):
            place = f"({reply.pose.x:.1f}, {reply.pose.y:.1f})"
            self._log("kidnap", "warning", f"The robot was carried to {place}")
        elif query.name not in UNLOGGED:
            self._log("command", "info", f"{query.name}: done")

    def _log(self, kind: Kind, severity: Severity, text: str) -> None:
        self._events.append(self._node.clock.now_ns(), kind, severity, text)
