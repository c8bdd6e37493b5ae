"""A node on the fake fabric, its clock turned by hand."""

import logging
import threading

import pytest

from pilotage.bus.clock import HandClock, SystemClock
from pilotage.bus.fabric import BusError, NoAnswerError, RefusedError, Sample
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import MAX_WARNED, Node
from pilotage_schemas.codec import decode
from pilotage_schemas.commands import Done, Drive, Nothing, Stopped
from pilotage_schemas.health import Health, Heartbeat
from pilotage_schemas.message import Message, Part
from pilotage_schemas.sensors import LaserScan, Odometry
from sample_messages import bumper, odometry, scan
from waiting import eventually


class Bench:
    """Two nodes and whatever flies between them."""

    def __init__(self) -> None:
        self.fabric = FakeFabric()
        self.clock = HandClock()
        self.robot = Node("robot", "demo", self.fabric, self.clock)
        self.mapper = Node("mapper", "demo", self.fabric, self.clock)
        self.fabric.pump = self.step

    def step(self) -> None:
        self.robot.step()
        self.mapper.step()

    def advance(self, seconds: float) -> None:
        self.clock.advance(seconds)
        self.step()

    def put(self, topic: str, payload: bytes) -> None:
        key = f"pilotage/@v1/demo/{topic}"
        self.fabric.declare_publisher(key, "application/cbor;x", "latest_wins")(payload)

    def listen(self, topic: str, kind: type[Message]) -> list[Message]:
        heard: list[Message] = []

        def hear(sample: Sample) -> None:
            heard.append(decode(kind, sample.payload))

        self.fabric.declare_subscriber(f"pilotage/@v1/demo/{topic}", "latest_wins", hear)
        return heard


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_message_reaches_the_handler_in_the_next_step(bench: Bench) -> None:
    got: list[Odometry] = []
    bench.mapper.subscribe("odometry", got.append)
    bench.robot.publisher("odometry").publish(odometry(bench.clock.now_ns(), x=1.5))
    assert not got
    bench.step()
    assert [message.pose.x for message in got] == [1.5]


def test_messages_of_all_topics_are_handled_in_order_of_arrival(bench: Bench) -> None:
    got: list[str] = []
    bench.mapper.subscribe("scan", lambda _: got.append("scan"))
    bench.mapper.subscribe("odometry", lambda _: got.append("odometry"))
    now = bench.clock.now_ns()
    for number in range(3):
        bench.robot.publisher("odometry").publish(odometry(now + number))
        bench.robot.publisher("scan").publish(scan(now + number))
    bench.step()
    assert got == ["odometry", "scan"] * 3


def test_a_busy_service_gets_the_newest_of_a_stream(bench: Bench) -> None:
    got: list[Odometry] = []
    bench.mapper.subscribe("odometry", got.append, depth=2)
    for number in range(10):
        bench.robot.publisher("odometry").publish(odometry(bench.clock.now_ns(), x=number))
    bench.step()
    assert [message.pose.x for message in got] == [8.0, 9.0]


def test_a_busy_service_gets_every_event(bench: Bench) -> None:
    got: list[Message] = []
    bench.mapper.subscribe("bumper", got.append)
    for number in range(100):
        bench.robot.publisher("bumper").publish(bumper(number))
    bench.step()
    assert [message.stamp_ns for message in got] == list(range(100))


def test_the_bytes_of_a_message_can_be_had_with_it(bench: Bench) -> None:
    got: list[Sample] = []
    bench.mapper.subscribe_samples("odometry", lambda _message, sample: got.append(sample))
    bench.robot.publisher("odometry").publish(odometry(bench.clock.now_ns(), x=2.0))
    bench.step()
    assert decode(Odometry, got[0].payload).pose.x == 2.0
    assert got[0].key == "pilotage/@v1/demo/odometry"


def test_a_malformed_message_is_dropped_counted_and_logged_once_a_minute(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    got: list[Message] = []
    bench.mapper.subscribe("odometry", got.append)
    with caplog.at_level(logging.WARNING):
        for _ in range(5):
            bench.put("odometry", b"nonsense")
            bench.step()
    assert not got
    assert bench.mapper.vitals.report().dropped == 5
    assert len(caplog.records) == 1
    assert "odometry: dropped: " in caplog.text
    bench.clock.advance(61.0)
    with caplog.at_level(logging.WARNING):
        bench.put("odometry", b"nonsense")
        bench.step()
    assert len(caplog.records) == 2


def test_a_malformed_message_keeps_nothing_else_from_arriving(bench: Bench) -> None:
    got: list[Message] = []
    bench.mapper.subscribe("odometry", got.append)
    bench.put("odometry", b"nonsense")
    bench.robot.publisher("odometry").publish(odometry(bench.clock.now_ns()))
    bench.put("odometry", b"")
    bench.step()
    assert len(got) == 1


def test_endlessly_many_sources_of_nonsense_do_not_fill_the_memory(bench: Bench) -> None:
    for number in range(MAX_WARNED + 10):
        bench.mapper.warn(f"source {number}", "nonsense")
    assert len(bench.mapper._warned) <= MAX_WARNED


def test_only_the_owner_may_publish_a_topic(bench: Bench) -> None:
    with pytest.raises(ValueError, match="map belongs to mapper, not to robot"):
        bench.robot.publisher("map")


def test_the_mapper_may_publish_the_pose_too_because_it_owns_it_while_mapping(bench: Bench) -> None:
    assert bench.mapper.publisher("pose").traffic.topic.owner == "localizer"


def test_nothing_is_published_while_the_topic_is_another_services(bench: Bench) -> None:
    out = bench.robot.publisher("odometry")
    out.rest(is_resting=True)
    with pytest.raises(ValueError, match="odometry is another service's at present"):
        out.publish(odometry(1))
    (line,) = [t for t in bench.robot.vitals.report().topics if t.topic == "odometry"]
    assert line.limit is None
    out.rest(is_resting=False)
    out.publish(odometry(1))
    (line,) = [t for t in bench.robot.vitals.report().topics if t.topic == "odometry"]
    assert line.limit == 0.5


def test_a_topic_that_is_not_registered_does_not_exist(bench: Bench) -> None:
    with pytest.raises(KeyError):
        bench.robot.publisher("lidar_data")
    with pytest.raises(KeyError):
        bench.robot.subscribe("lidar_data", lambda _: None)


def test_a_publisher_is_declared_once(bench: Bench) -> None:
    assert bench.robot.publisher("odometry") is bench.robot.publisher("odometry")


def test_only_the_owner_may_answer_a_query(bench: Bench) -> None:
    with pytest.raises(ValueError, match="stop belongs to robot, not to mapper"):
        bench.mapper.answer("stop", lambda _: Stopped(after=0.0))


def test_a_question_is_answered_by_its_service(bench: Bench) -> None:
    bench.robot.answer("forward", lambda drive: Done(detail=f"{drive.distance:g}"))
    assert bench.mapper.ask("forward", Drive(distance=2.0)) == Done(detail="2")


def test_a_refusal_is_raised_where_the_question_was_asked(bench: Bench) -> None:
    def refuse(_: Part) -> Part:
        raise RefusedError("a wall is in the way")

    bench.robot.answer("forward", refuse)
    with pytest.raises(RefusedError, match="a wall is in the way"):
        bench.mapper.ask("forward", Drive(distance=2.0))


def test_a_question_to_nobody_has_no_answer(bench: Bench) -> None:
    with pytest.raises(NoAnswerError):
        bench.mapper.ask("stop", Nothing())


def test_a_question_of_another_type_is_not_sent(bench: Bench) -> None:
    with pytest.raises(TypeError, match="stop takes Nothing"):
        bench.mapper.ask("stop", Drive(distance=1.0))


def test_an_answer_of_another_type_is_an_error_of_the_bus(bench: Bench) -> None:
    bench.robot.answer("stop", lambda _: Drive(distance=1.0))
    with pytest.raises(BusError, match="stop was answered with something else"):
        bench.mapper.ask("stop", Nothing())


def test_a_malformed_question_is_counted(bench: Bench) -> None:
    bench.robot.answer("stop", lambda _: Stopped(after=0.0))
    with pytest.raises(RefusedError):
        bench.fabric.ask("pilotage/@v1/demo/@rpc/robot/stop", b"nonsense", 1.0)
    assert bench.robot.vitals.report().dropped == 1


def test_a_timer_is_called_once_per_period(bench: Bench) -> None:
    calls: list[float] = []
    bench.robot.every(0.5, lambda: calls.append(bench.clock.monotonic()))
    for _ in range(16):
        bench.advance(0.125)
    assert len(calls) == 4


def test_a_timer_that_was_held_up_does_not_catch_up_in_a_burst(bench: Bench) -> None:
    calls: list[float] = []
    bench.robot.every(0.5, lambda: calls.append(bench.clock.monotonic()))
    bench.advance(10.0)
    for _ in range(4):
        bench.advance(0.1)
    assert len(calls) == 1


def test_a_step_says_how_long_nothing_is_due(bench: Bench) -> None:
    bench.robot.every(0.2, lambda: None)
    bench.clock.advance(0.05)
    assert bench.robot.step() == pytest.approx(0.15)


def test_timers_run_between_messages_that_keep_coming(bench: Bench) -> None:
    calls: list[str] = []

    def slow(_: LaserScan) -> None:
        bench.clock.advance(1.0)
        calls.append("scan")

    bench.mapper.subscribe("scan", slow)
    bench.mapper.every(1.5, lambda: calls.append("timer"))
    for number in range(4):
        bench.robot.publisher("scan").publish(scan(bench.clock.now_ns() + number))
    bench.mapper.step()
    assert calls == ["scan", "scan", "timer", "scan", "timer", "scan"]


def test_a_node_is_idle_once_all_that_had_come_is_handled(bench: Bench) -> None:
    calls: list[str] = []
    bench.mapper.subscribe("scan", lambda _: calls.append("scan"))
    bench.mapper.when_idle(lambda: calls.append("idle"))
    for number in range(3):
        bench.robot.publisher("scan").publish(scan(bench.clock.now_ns() + number))
    bench.mapper.step()
    assert calls == ["scan", "scan", "scan", "idle"]


def test_presence_is_watched_by_name(bench: Bench) -> None:
    seen: list[tuple[str, bool]] = []
    bench.mapper.watch_presence(lambda service, present: seen.append((service, present)))
    bench.robot.ready()
    bench.fabric.withdraw("pilotage/@v1/demo/@alive/robot")
    bench.mapper.step()
    assert seen == [("robot", True), ("robot", False)]


def test_a_service_is_present_only_when_it_is_ready(bench: Bench) -> None:
    seen: list[str] = []
    bench.fabric.watch_presence("*", lambda key, _present: seen.append(key))
    assert not seen
    bench.robot.ready()
    assert seen == ["pilotage/@v1/demo/@alive/robot"]


def heard_beats(bench: Bench) -> list[Heartbeat]:
    return bench.listen("heartbeat/robot", Heartbeat)  # type: ignore[return-value]  # of that kind


def test_the_heart_beats_four_times_a_second(bench: Bench) -> None:
    beats = heard_beats(bench)
    bench.robot.ready()
    for _ in range(8):
        bench.advance(0.125)
    assert len(beats) == 1 + 4
    assert {beat.state for beat in beats} == {"ready"}
    assert {beat.within for beat in beats} == {1.0}


def test_long_work_is_announced_by_the_heart(bench: Bench) -> None:
    bench.robot.ready()
    beats = heard_beats(bench)
    with bench.robot.busy(5.0):
        assert [(beat.state, beat.within) for beat in beats] == [("busy", 5.0)]
    assert (beats[-1].state, beats[-1].within) == ("ready", 1.0)


def test_long_work_that_fails_ends_being_busy(bench: Bench) -> None:
    bench.robot.ready()
    beats = heard_beats(bench)
    with pytest.raises(ZeroDivisionError), bench.robot.busy(5.0):
        raise ZeroDivisionError
    assert beats[-1].state == "ready"


def test_busy_while_starting_returns_to_starting(bench: Bench) -> None:
    beats = heard_beats(bench)
    with bench.robot.busy(5.0):
        pass
    assert beats[-1].state == "starting"


def test_health_is_told_once_a_second(bench: Bench) -> None:
    heard = bench.listen("health/robot", Health)
    bench.robot.ready()
    for _ in range(25):
        bench.advance(0.1)
    assert len(heard) == 2


def test_health_counts_rates_ages_and_losses(bench: Bench) -> None:
    bench.mapper.subscribe("odometry", lambda _: None)
    bench.mapper.vitals.report()
    for number in range(10):
        bench.robot.publisher("odometry").publish(odometry(bench.clock.now_ns() + number))
    bench.put("odometry", b"nonsense")
    bench.step()
    bench.clock.advance(2.0)
    health = bench.mapper.vitals.report()
    [line] = [topic for topic in health.topics if topic.topic == "odometry"]
    assert (line.direction, line.count, line.dropped, line.limit) == ("in", 11, 1, 0.5)
    assert line.rate_hz == pytest.approx(5.5)
    assert line.age == pytest.approx(2.0, abs=1e-6)
    assert health.last_error.startswith("odometry: dropped: ")
    assert 1.0 < health.rss_mb < 10_000.0


@pytest.mark.parametrize("stamp_ns", [0, 2**63 - 1])
def test_a_stamp_from_another_time_does_not_stop_the_account(bench: Bench, stamp_ns: int) -> None:
    bench.clock.advance(2e9)
    bench.mapper.subscribe("bumper", lambda _: None)
    bench.robot.publisher("bumper").publish(bumper(stamp_ns))
    bench.step()
    [line] = [line for line in bench.mapper.vitals.report().topics if line.topic == "bumper"]
    assert line.count == 1
    assert line.age in (0.0, 1e9)


def test_before_the_first_sample_there_is_no_age(bench: Bench) -> None:
    bench.mapper.subscribe("odometry", lambda _: None)
    ages = {line.topic: line.age for line in bench.mapper.vitals.report().topics}
    assert ages["odometry"] is None


def test_a_failing_handler_is_loud(bench: Bench) -> None:
    def fail(_: Odometry) -> None:
        raise ZeroDivisionError

    bench.mapper.subscribe("odometry", fail)
    bench.robot.publisher("odometry").publish(odometry(bench.clock.now_ns()))
    with pytest.raises(ZeroDivisionError):
        bench.mapper.step()


def running(node: Node) -> threading.Thread:
    thread = threading.Thread(target=node.run)
    thread.start()
    return thread


def test_a_running_node_handles_what_comes_and_stops_when_asked() -> None:
    fabric = FakeFabric()
    robot = Node("robot", "demo", fabric, SystemClock())
    mapper = Node("mapper", "demo", fabric, SystemClock())
    got: list[Odometry] = []
    mapper.subscribe("odometry", got.append)
    thread = running(mapper)
    robot.publisher("odometry").publish(odometry(robot.clock.now_ns()))
    eventually(lambda: got)
    assert not mapper.is_stopping
    mapper.stop()
    thread.join(5.0)
    assert not thread.is_alive()
    assert mapper.is_stopping


def test_a_flood_does_not_keep_a_node_from_stopping() -> None:
    fabric = FakeFabric()
    robot = Node("robot", "demo", fabric, SystemClock())

    def publish(_: Odometry | None = None) -> None:
        robot.publisher("odometry").publish(odometry(robot.clock.now_ns()))

    robot.subscribe("odometry", publish)
    publish()
    thread = running(robot)
    eventually(lambda: robot.vitals.report().topics[-1].count > 100)
    robot.stop()
    thread.join(5.0)
    assert not thread.is_alive()
