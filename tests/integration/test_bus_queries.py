"""Questions over a real router: answers, refusals, nobody, too late, from many threads."""

import threading
import time
import uuid
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager

import pytest

from pilotage.bus.clock import SystemClock
from pilotage.bus.fabric import BusError, NoAnswerError, NoAnswerInTimeError, RefusedError
from pilotage.bus.node import Node
from pilotage.bus.session import open_fabric
from pilotage_schemas.commands import Done, Drive, Nothing, Stopped
from pilotage_schemas.message import Part
from waiting import eventually


@contextmanager
def running(node: Node) -> Iterator[None]:
    """Run the node's loop in a thread."""
    thread = threading.Thread(target=node.run)
    thread.start()
    try:
        yield
    finally:
        node.stop()
        thread.join(5.0)


@pytest.fixture
def nodes(router_endpoint: str) -> Iterator[tuple[Node, Node]]:
    """A robot and a gateway, each with a session of its own."""
    robot_name = f"q{uuid.uuid4().hex[:12]}"
    with ExitStack() as stack:
        robot, gateway = (
            Node(name, robot_name, stack.enter_context(open_fabric(router_endpoint)), SystemClock())
            for name in ("robot", "gateway")
        )
        yield robot, gateway


def answered(gateway: Node, query: str, request: Part) -> Part:
    """Ask until the queryable is known to the asker's session."""

    def reply() -> Part | None:
        try:
            return gateway.ask(query, request)
        except NoAnswerError:
            return None

    found = eventually(reply)
    assert found is not None
    return found


def test_a_question_is_answered(nodes: tuple[Node, Node]) -> None:
    robot, gateway = nodes
    robot.answer("forward", lambda drive: Done(detail=f"{drive.distance:g} m"))
    with running(robot):
        assert answered(gateway, "forward", Drive(distance=1.5)) == Done(detail="1.5 m")


def test_a_refusal_comes_with_its_reason(nodes: tuple[Node, Node]) -> None:
    robot, gateway = nodes

    def refuse(_: Drive) -> Part:
        raise RefusedError("a wall is in the way")

    robot.answer("forward", refuse)
    with running(robot), pytest.raises(RefusedError, match="a wall is in the way"):
        answered(gateway, "forward", Drive(distance=1.5))


def test_nobody_there_is_told_at_once(nodes: tuple[Node, Node]) -> None:
    _, gateway = nodes
    begun = time.monotonic()
    with pytest.raises(NoAnswerError, match="not running"):
        gateway.ask("stop", Nothing())
    assert time.monotonic() - begun < 1.0


def test_a_service_that_hangs_gives_no_answer_in_time(nodes: tuple[Node, Node]) -> None:
    robot, gateway = nodes
    robot.answer("stop", lambda _: Stopped(after=0.0))
    with running(robot):
        answered(gateway, "stop", Nothing())
    begun = time.monotonic()
    with pytest.raises(NoAnswerInTimeError, match="within 2 s"):
        gateway.ask("stop", Nothing())
    assert 1.5 < time.monotonic() - begun < 4.0


def test_a_command_given_up_is_not_carried_out_later(nodes: tuple[Node, Node]) -> None:
    robot, gateway = nodes
    driven: list[Drive] = []

    def drive(request: Drive) -> Part:
        driven.append(request)
        return Done()

    def given_up() -> bool:
        try:
            gateway.ask("forward", Drive(distance=1.0))
        except NoAnswerInTimeError:
            return True
        except NoAnswerError:
            return False
        return False

    robot.answer("forward", drive)
    eventually(given_up)
    robot.step()
    assert not driven
    assert robot.vitals.report().dropped == 1


def test_an_answer_nobody_waits_for_does_not_stop_the_service(nodes: tuple[Node, Node]) -> None:
    robot, gateway = nodes
    release = threading.Event()

    def slow(_: Nothing) -> Part:
        release.wait(10.0)
        return Stopped(after=0.0)

    robot.answer("stop", slow)
    robot.answer("forward", lambda _: Done())
    with running(robot):
        answered(gateway, "forward", Drive(distance=1.0))
        with pytest.raises(NoAnswerInTimeError):
            gateway.ask("stop", Nothing())
        release.set()
        assert answered(gateway, "forward", Drive(distance=1.0)) == Done()


def test_a_malformed_question_is_refused(nodes: tuple[Node, Node]) -> None:
    robot, gateway = nodes
    robot.answer("forward", lambda _: Done())
    with running(robot):
        answered(gateway, "forward", Drive(distance=1.0))
        key = f"pilotage/@v1/{robot.robot}/@rpc/robot/forward"
        with pytest.raises(RefusedError):
            gateway.fabric.ask(key, b"nonsense", 2.0)


def test_many_threads_may_ask_at_once(nodes: tuple[Node, Node]) -> None:
    robot, gateway = nodes
    robot.answer("forward", lambda drive: Done(detail=f"{drive.distance:g}"))
    with running(robot):
        answered(gateway, "forward", Drive(distance=1.0))
        with ThreadPoolExecutor(8) as pool:
            requests = [Drive(distance=float(number)) for number in range(1, 51)]
            replies = pool.map(lambda request: gateway.ask("forward", request), requests)
        assert [reply for reply in replies] == [  # noqa: C416 - a list to compare
            Done(detail=f"{number}") for number in range(1, 51)
        ]


def test_a_closed_session_can_ask_nobody(nodes: tuple[Node, Node]) -> None:
    _, gateway = nodes
    gateway.fabric.close()
    with pytest.raises(BusError, match="cannot be asked"):
        gateway.ask("stop", Nothing())
