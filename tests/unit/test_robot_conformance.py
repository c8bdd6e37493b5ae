"""What the conformance check says of good and of bad drivers."""

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

import numpy as np
import pytest

from pilotage.bus.clock import HandClock
from pilotage.core.landmark_map import landmarks_of
from pilotage.core.logs import Log, OdometryRecord
from pilotage.robot.conformance import check_driver
from pilotage.robot.driver import Measurement, RobotDriver
from pilotage.robot.replay import Replay
from pilotage.robot.simulator.picture_params import PictureParams
from pilotage.robot.simulator.simulator import Simulator
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.message import Message
from pilotage_schemas.sensors import (
    Landmark,
    LandmarkSightings,
    RobotDescription,
    SensorMount,
    VerticalEdges,
)
from robot_world import EXACT, ToyRobot, open_scan, simulation_in
from sample_messages import odometry


def findings(driver: RobotDriver) -> list[str]:
    clock = HandClock()
    return list(check_driver(driver, clock, clock.advance))


class SeeingToy(ToyRobot):
    """A toy in a round hall of 3 m, whose messages a test may spoil."""

    def spoil(self, measurement: Measurement) -> Measurement:
        return measurement

    def sense(self, now_ns: int) -> Iterable[Measurement]:
        for measurement in super().sense(now_ns):
            is_scan = measurement.topic == "scan"
            seen = Measurement("scan", open_scan(now_ns, 3.0)) if is_scan else measurement
            yield self.spoil(seen)


def changed(measurement: Measurement, topic: str, **fields: object) -> Measurement:
    if measurement.topic != topic:
        return measurement
    message: Message = measurement.message.model_copy(update=fields)
    return Measurement(topic, message)


def test_nothing_is_said_of_a_good_driver() -> None:
    assert findings(SeeingToy()) == []


def test_the_simulator_is_a_good_driver() -> None:
    assert findings(Simulator(simulation_in())) == []


def test_the_simulator_with_a_camera_is_a_good_driver() -> None:
    landmarks = landmarks_of([{"class": "post", "x": 4.0, "y": 1.75}])
    assert findings(Simulator(simulation_in(landmarks=landmarks))) == []


def test_the_simulator_is_a_good_driver_where_its_camera_takes_pictures_too() -> None:
    pictures = replace(EXACT, picture=PictureParams())
    assert findings(Simulator(simulation_in(params=pictures))) == []


def test_a_log_is_not_driven() -> None:
    records = tuple(OdometryRecord(0.05 * i, (0.0, 0.0, 0.0)) for i in range(100))
    assert findings(Replay(Log("carmen", records, 0), "run.log")) == []


class StuckClock(SeeingToy):
    def spoil(self, measurement: Measurement) -> Measurement:
        return changed(measurement, "odometry", stamp_ns=1_000_000_000_000_000)


class Milliseconds(SeeingToy):
    def spoil(self, measurement: Measurement) -> Measurement:
        return changed(measurement, "scan", stamp_ns=measurement.message.stamp_ns // 1_000_000)


class Degrees(SeeingToy):
    def spoil(self, measurement: Measurement) -> Measurement:
        return changed(measurement, "scan", angle_increment=3.0)


class TooFar(SeeingToy):
    def spoil(self, measurement: Measurement) -> Measurement:
        return changed(measurement, "scan", range_max=2.0)


class Unmounted(SeeingToy):
    def spoil(self, measurement: Measurement) -> Measurement:
        return changed(measurement, "scan", frame_id="lidar")


class Blind(SeeingToy):
    def spoil(self, measurement: Measurement) -> Measurement:
        return changed(measurement, "scan", ranges=np.full(91, np.inf, np.float32))


class WrongTopic(SeeingToy):
    def spoil(self, measurement: Measurement) -> Measurement:
        return Measurement("pose", measurement.message)


class WrongMessage(SeeingToy):
    def spoil(self, measurement: Measurement) -> Measurement:
        return Measurement("heading", odometry(measurement.message.stamp_ns))


class Runaway(SeeingToy):
    def stop(self) -> None:
        self.stops += 1


class Lame(SeeingToy):
    def drive(self, twist: Twist2) -> None:
        pass


class Slow(SeeingToy):
    def __init__(self) -> None:
        super().__init__()
        self.looks = 0

    def sense(self, now_ns: int) -> Iterable[Measurement]:
        self.looks += 1
        return [] if self.looks % 10 else list(super().sense(now_ns))


class Fickle(SeeingToy):
    def describe(self) -> RobotDescription:
        self.max_linear += 0.1
        return super().describe()


class Centimetres(SeeingToy):
    def describe(self) -> RobotDescription:
        footprint = np.array([[20.0, 0.0], [-10.0, 10.0], [-10.0, -10.0]], np.float32)
        return super().describe().model_copy(update={"footprint": footprint})


class Shapeless(SeeingToy):
    def describe(self) -> RobotDescription:
        footprint = np.zeros((1, 2), np.float32)
        return super().describe().model_copy(update={"footprint": footprint})


class Immobile(SeeingToy):
    def describe(self) -> RobotDescription:
        return super().describe().model_copy(update={"max_linear": 0.0, "max_angular": 0.0})


class Jumping(SeeingToy):
    def sense(self, now_ns: int) -> Iterable[Measurement]:
        self.pose[0] += 5.0
        return super().sense(now_ns)


class Closed(SeeingToy):
    def __enter__(self) -> Self:
        raise PermissionError("/dev/ttyUSB0")


class Unclosable(SeeingToy):
    def __exit__(self, *_: object) -> None:
        raise ValueError("never opened")


class Mute(SeeingToy):
    def describe(self) -> RobotDescription:
        return None  # type: ignore[return-value]  # what a forgotten return gives


class Dumb(SeeingToy):
    def describe(self) -> RobotDescription:
        return RobotDescription(name="half")  # type: ignore[call-arg]  # fields forgotten


class Blank(SeeingToy):
    def sense(self, now_ns: int) -> Iterable[Measurement]:
        list(super().sense(now_ns))
        return None  # type: ignore[return-value]  # what a forgotten return gives


class Torn(SeeingToy):
    def sense(self, now_ns: int) -> Iterable[Measurement]:
        yield from super().sense(now_ns)
        raise ZeroDivisionError("division by zero")


class Endless(SeeingToy):
    def sense(self, now_ns: int) -> Iterable[Measurement]:
        while True:
            yield Measurement("odometry", odometry(now_ns))


class Bare(SeeingToy):
    def sense(self, now_ns: int) -> Iterable[Measurement]:
        yield ("odometry", odometry(now_ns))  # type: ignore[misc]  # a pair is none


class Empty(SeeingToy):
    def sense(self, now_ns: int) -> Iterable[Measurement]:
        yield from super().sense(now_ns)
        yield Measurement("odometry", None)  # type: ignore[arg-type]  # nothing is no message


class Watchful(SeeingToy):
    """A toy with a camera that sees a post five times a second and turns at once."""

    mounted = "camera"

    def __init__(self) -> None:
        super().__init__()
        self.commands = (*self.commands, "look")
        self.pans: list[float] = []
        self.next_ns = 0

    def describe(self) -> RobotDescription:
        plain = super().describe()
        origin = Pose2(x=0.1, y=0.0, theta=0.0)
        camera = SensorMount(frame_id=self.mounted, kind="camera", pose=origin)
        return plain.model_copy(update={"mounts": (*plain.mounts, camera)})

    def sense(self, now_ns: int) -> Iterable[Measurement]:
        yield from super().sense(now_ns)
        if now_ns >= self.next_ns:
            self.next_ns = now_ns + 200_000_000
            yield self.spoil(Measurement("landmarks", post_ahead(now_ns)))

    def look(self, pan: float) -> None:
        self.pans.append(pan)


def post_ahead(stamp_ns: int, distance: float = 2.0) -> LandmarkSightings:
    post = Landmark(kind="post", range=distance, bearing=0.0, range_sigma=0.2, bearing_sigma=0.1)
    return LandmarkSightings(stamp_ns=stamp_ns, frame_id="camera", sightings=(post,))


class Elsewhere(Watchful):
    mounted = "eye"


class Millimetres(Watchful):
    def spoil(self, measurement: Measurement) -> Measurement:
        if measurement.topic != "landmarks":
            return measurement
        return Measurement("landmarks", post_ahead(measurement.message.stamp_ns, 2000.0))


class EdgesInDegrees(Watchful):
    said = 25.0

    def spoil(self, measurement: Measurement) -> Measurement:
        if measurement.topic != "landmarks":
            return measurement
        edges = VerticalEdges(
            stamp_ns=measurement.message.stamp_ns,
            frame_id="camera",
            bearings=np.array([-self.said, self.said], np.float32),
            sigma=0.002,
        )
        return Measurement("vertical_edges", edges)


class EdgesElsewhere(EdgesInDegrees):
    said, mounted = 0.4, "eye"


class StiffNecked(SeeingToy):
    """It promises to look, but cannot."""

    def describe(self) -> RobotDescription:
        plain = super().describe()
        return plain.model_copy(update={"commands": (*plain.commands, "look")})


class Eyeless(Watchful):
    def describe(self) -> RobotDescription:
        mounts = tuple(m for m in super().describe().mounts if m.kind != "camera")
        return super().describe().model_copy(update={"mounts": mounts})


class Dazed(Watchful):
    def look(self, pan: float) -> None:
        self.pans.append(pan)
        self.next_ns = 2**62


class WryNecked(Watchful):
    def look(self, pan: float) -> None:
        raise OSError(f"the joint is stuck at {pan}")


class Wedged(SeeingToy):
    def drive(self, twist: Twist2) -> None:
        super().drive(twist)
        raise TimeoutError("no reply")


class Loose(SeeingToy):
    def stop(self) -> None:
        raise AttributeError("no brake")


@pytest.mark.parametrize(
    ("kind", "finding"),
    [
        (StuckClock, "odometry: stamps must increase"),
        (Milliseconds, "s from now; stamps are Unix time in ns"),
        (Degrees, "more than a full turn; are angles in radians?"),
        (TooFar, "scan: ranges beyond range_max; no return is infinity"),
        (Unmounted, "scan: frame 'lidar' has no mount in the description"),
        (Blind, "scan: not one beam came back"),
        (WrongTopic, "pose: no topic of the robot"),
        (WrongMessage, "heading: carries Heading, not Odometry"),
        (Runaway, "stop: it still moved 0.6 s later"),
        (Lame, "drive: told to go 0.1 m/s, the odometry's twist says that it stands"),
        (Slow, "odometry: 5.0 a second, usual are 20"),
        (Fickle, "describe: two calls gave different answers"),
        (Centimetres, "describe: a footprint of more than 5 m; is it in metres?"),
        (Shapeless, "describe: a footprint needs 3 corners or more, not 1"),
        (Immobile, "describe: it takes commands, but max_linear and max_angular are 0"),
        (Jumping, "odometry: jumped by 5"),
        (Closed, "__enter__: raised PermissionError: /dev/ttyUSB0"),
        (Unclosable, "__exit__: raised ValueError: never opened"),
        (Mute, "describe: gave NoneType, not RobotDescription"),
        (Dumb, "describe: raised ValidationError: "),
        (Blank, "sense: raised TypeError: 'NoneType' object is not iterable"),
        (Torn, "sense: raised ZeroDivisionError: division by zero"),
        (Endless, "sense: one look never ends"),
        (Bare, "sense: yields tuple, not Measurement(topic, message)"),
        (Empty, "odometry: carries Odometry, not NoneType"),
        (Wedged, "drive: raised TimeoutError: no reply"),
        (Loose, "stop: raised AttributeError: no brake"),
        (Elsewhere, "landmarks: frame 'camera' has no mount in the description"),
        (Millimetres, "landmarks: one 2000 m away; is it in metres?"),
        (EdgesInDegrees, "vertical_edges: one at 25 rad; are bearings in radians?"),
        (EdgesElsewhere, "vertical_edges: frame 'camera' has no mount in the description"),
        (StiffNecked, "look: among the commands, but the driver has no method look(pan)"),
        (Eyeless, "look: among the commands, but the description has no mount of a camera"),
        (Dazed, "look: no picture came after it"),
        (WryNecked, "look: raised OSError: the joint is stuck at 0.3"),
    ],
)
def test_what_is_wrong_is_found_and_said_once(kind: type[SeeingToy], finding: str) -> None:
    said = [line for line in findings(kind()) if finding in line]
    assert len(said) == 1
    assert "\n" not in said[0]


def test_a_driver_without_odometry_is_of_no_use() -> None:
    robot = SeeingToy()
    robot.silent = {"odometry"}
    assert "odometry: none came; nothing works without it" in findings(robot)


def test_a_driver_that_takes_long_to_look_is_found() -> None:
    clock = HandClock()

    class Sleepy(SeeingToy):
        def sense(self, now_ns: int) -> Iterable[Measurement]:
            clock.advance(0.05)
            return super().sense(now_ns)

    said = list(check_driver(Sleepy(), clock, clock.advance))
    assert "sense: took 50 ms; it must return at once" in said


def test_a_camera_is_pointed_to_either_side_and_ahead_again() -> None:
    robot = Watchful()
    assert findings(robot) == []
    assert robot.pans == [0.3, -0.3, 0.0]


def test_a_camera_that_waits_until_it_has_turned_is_found() -> None:
    clock = HandClock()

    class Patient(Watchful):
        def look(self, pan: float) -> None:
            super().look(pan)
            clock.advance(0.5)

    said = list(check_driver(Patient(), clock, clock.advance))
    assert [line for line in said if "look" in line] == [
        "look: took 500 ms; it must return at once"
    ]


def test_a_driver_that_does_not_open_is_said_so() -> None:
    robot = SeeingToy()
    robot.broken = "no such port"
    assert findings(robot) == ["the driver gave up: no such port"]


def test_a_driver_that_fails_is_closed_all_the_same() -> None:
    robot = Torn()
    assert findings(robot)
    assert not robot.is_open


def test_a_driver_that_fails_twice_is_told_both() -> None:
    class Hopeless(Mute, Unclosable):
        pass

    said = findings(Hopeless())
    assert [line.split(":")[0] for line in said] == ["describe", "__exit__"]


def test_our_own_faults_are_not_laid_at_the_drivers_door() -> None:
    def broken_wait(_seconds: float) -> None:
        raise OSError("ours")

    with pytest.raises(OSError, match="ours"):
        list(check_driver(SeeingToy(), HandClock(), broken_wait))


def test_the_example_of_the_readme_keeps_every_promise(repository: Path) -> None:
    readme = repository / "services" / "pilotage" / "robot" / "README.md"
    (example,) = re.findall(r"```python\n(.*?)```", readme.read_text("utf-8"), re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(example, str(readme), "exec"), names)  # noqa: S102 - our own README
    assert findings(names["MyRobot"]()) == []
    assert findings(names["MyRobot"](port="/dev/tty9")) == [
        "the driver gave up: nothing answers at /dev/tty9"
    ]
