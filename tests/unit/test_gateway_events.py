"""What happened, told to people."""

import asyncio
import json

import pytest

from gateway_world import deployment, grid, planning_status, pose_estimate, process
from pilotage.gateway.event_log import KEPT, EventLog
from pilotage.gateway.event_stream import EventFollower, encoded, parsed_id
from pilotage.gateway.watch import Watch

SECOND = 1_000_000_000


class Story:
    """A watch and what it has written."""

    def __init__(self) -> None:
        self.log = EventLog()
        self.watch = Watch(self.log)
        self._now_ns = 100 * SECOND

    def see(self, *messages: object) -> list[str]:
        """Return severity and text of what is written about these messages."""
        newest = max((event.id for event in self.log.after(0)), default=0)
        for message in messages:
            self._now_ns += 10 * SECOND
            self.watch.see(message, self._now_ns)  # type: ignore[arg-type]  # any message
        return [f"{event.severity} {event.text}" for event in self.log.after(newest)]


def test_ids_grow_even_within_a_microsecond() -> None:
    log = EventLog()
    ids = [log.append(5000, "command", "info", text).id for text in "abc"]
    assert ids == [5, 6, 7]


def test_ids_grow_when_the_clock_goes_back() -> None:
    log = EventLog()
    assert log.append(9_000_000, "link", "info", "a").id == 9000
    assert log.append(1_000_000, "link", "info", "b").id == 9001


def test_the_log_is_a_ring() -> None:
    log = EventLog()
    for number in range(KEPT + 10):
        log.append(number * 1000, "command", "info", str(number))
    assert [event.text for event in log.after(0)][:2] == ["10", "11"]
    assert len(log.after(0)) == KEPT


def test_the_same_again_is_no_news_for_a_while() -> None:
    log = EventLog()
    for second in (0, 1, 2, 7):
        log.append(second * SECOND, "refusal", "warning", "velocity: stopped")
    assert [event.stamp_ns for event in log.after(-1)] == [0, 7 * SECOND]


def test_a_change_of_the_pose_state_is_told_once() -> None:
    story = Story()
    assert story.see(pose_estimate(1, state="unknown")) == ["info Searching: it could be anywhere"]
    assert story.see(pose_estimate(2, state="unknown")) == []
    assert story.see(pose_estimate(3), pose_estimate(4, state="lost")) == [
        "info Localized",
        "warning Lost: what it sees does not fit the map",
    ]


def test_a_new_map_is_told_with_its_size() -> None:
    story = Story()
    assert story.see(grid("....\n....")) == ["info Map drawn in use, 2 m x 1 m"]
    assert story.see(grid("....\n....")) == []
    assert len(story.see(grid("..", map_id="other"))) == 1


def test_what_the_planner_begins_and_ends_is_told_once() -> None:
    story = Story()
    assert story.see(planning_status(1)) == []
    going = {"mode": "going", "reason": "going to (3.00, 2.00)"}
    assert story.see(planning_status(2, **going), planning_status(3, **going)) == [
        "info Planner: going to (3.00, 2.00)"
    ]
    waiting = planning_status(4, mode="waiting", reason="no scan for 1 s")
    assert story.see(waiting) == ["warning Planner: no scan for 1 s"]
    failed = planning_status(5, outcome="failed", reason="the goal cannot be reached")
    assert story.see(failed) == ["warning Planner: the goal cannot be reached"]


def test_processes_that_start_well_are_no_news() -> None:
    assert (
        Story().see(deployment(1, process("robot", "ready"), process("mapper", "starting"))) == []
    )


def test_a_crash_is_told_from_end_to_end() -> None:
    story = Story()
    story.see(deployment(1, process("localizer", "ready")))
    down = process("localizer", "down", reason="killed by signal 9", try_number=1)
    assert story.see(deployment(2, down)) == [
        "fault localizer is down: killed by signal 9; it is being restarted, try 1 of 5"
    ]
    assert story.see(deployment(3, down)) == []
    again = process("localizer", "starting", try_number=1, restarts=1)
    ready = process("localizer", "ready", restarts=1)
    assert story.see(deployment(4, again), deployment(5, ready)) == [
        "info localizer is starting, try 1 of 5",
        "info localizer is ready",
    ]


def test_a_hang_says_how_late() -> None:
    story = Story()
    story.see(deployment(1, process("mapper", "ready")))
    late = process("mapper", "late", late_for=1.26)
    assert story.see(deployment(2, late)) == [
        "warning mapper is late: no heartbeat for 1.3 s, limit 1 s"
    ]


@pytest.mark.parametrize(
    ("state", "line"),
    [
        ("given_up", "fault mapper was given up after 5 tries: no map"),
        ("stopped", "info mapper was stopped: no map"),
    ],
)
def test_the_end_of_a_process_says_why(state: str, line: str) -> None:
    assert Story().see(deployment(1, process("mapper", state, try_number=5, reason="no map"))) == [
        line
    ]


def test_a_restart_that_was_too_quick_to_see_is_told() -> None:
    story = Story()
    story.see(deployment(1, process("robot", "ready")))
    assert story.see(deployment(2, process("robot", "ready", restarts=1))) == [
        "info robot is ready"
    ]


def test_an_event_on_the_wire_is_one_block() -> None:
    log = EventLog()
    event = log.append(5000, "refusal", "warning", "two\nlines and \u2028")
    lines = encoded(event).decode().split("\n")
    assert lines[0] == "id: 5"
    assert json.loads(lines[1].removeprefix("data: "))["text"] == "two\nlines and \u2028"
    assert lines[2:] == ["", ""]


@pytest.mark.parametrize(
    ("text", "number"),
    [(None, 0), ("", 0), ("17", 17), ("-1", 0), ("x", 0), ("²", 0), ("9" * 64, int("9" * 20))],
)
def test_a_client_goes_on_where_it_was(text: str | None, number: int) -> None:
    assert parsed_id(text) == number


def test_a_follower_gets_the_old_the_new_and_the_end() -> None:
    async def follow() -> list[bytes]:
        log = EventLog()
        first = log.append(1000, "link", "info", "first")
        log.append(2000, "link", "info", "second")
        follower = EventFollower(log, first.id)
        blocks = aiter(follower)
        got = [await anext(blocks), await anext(blocks)]
        waiting = asyncio.ensure_future(anext(blocks))
        await asyncio.sleep(0)
        log.append(3000, "link", "info", "third")
        got.append(await waiting)
        follower.close()
        got += [block async for block in blocks]
        assert not log._listeners
        return got

    blocks = asyncio.run(follow())
    assert blocks[0].startswith(b":")
    assert [b"second" in blocks[1], b"third" in blocks[2], len(blocks)] == [True, True, 3]


def test_a_silent_stream_says_that_it_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pilotage.gateway.event_stream.KEEP_ALIVE_S", 0.0)

    async def second_block() -> bytes:
        blocks = aiter(EventFollower(EventLog(), 0))
        await anext(blocks)
        return await anext(blocks)

    assert asyncio.run(second_block()).startswith(b": still")
