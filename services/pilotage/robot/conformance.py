"""Does a driver keep what the protocol promises? One line per finding; nothing said is well.

The robot is driven forward slowly for two seconds: it must stand on free ground. A camera that can
be pointed is pointed to either side.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from itertools import islice, pairwise

import numpy as np

from pilotage.bus.clock import Clock
from pilotage.robot.driver import (
    DriverError,
    Gazeable,
    Measurement,
    Playback,
    RobotDriver,
    in_words,
)
from pilotage_schemas.codec import encode
from pilotage_schemas.geometry import Twist2
from pilotage_schemas.message import Message
from pilotage_schemas.sensors import (
    LandmarkSightings,
    LaserScan,
    Odometry,
    RobotDescription,
    VerticalEdges,
)
from pilotage_schemas.topics import TOPICS

LOOK_PERIOD = 0.02
WATCHED = 2.0
"""s that the driver is watched at rest, while it drives, and after it was stopped."""
LONGEST_CALL = 0.02
"""s that `sense` may take: longer ones delay the stop."""
CLOCK_TOLERANCE_S = 1.0
STANDING_WITHIN = 0.6
"""s after `stop` within which a robot must stand (design, section 6)."""
TRIAL_SPEED = 0.1
TRIAL_PAN = 0.3
"""rad."""
STILL = 0.02
"""m/s and rad/s."""
FARTHEST_LANDMARK = 200.0
"""m: a camera recognises nothing beyond; more was meant in other units."""
MOST_AT_ONCE = 10_000
"""Measurements of one look; more come only from a generator that never ends."""
LARGEST_ROBOT = 5.0
"""m from the centre to the farthest point of a footprint; more was meant in other units."""

Wait = Callable[[float], None]


class _BrokenError(Exception):
    """A driver did what leaves nothing to go on with; the text is the finding."""


@dataclass
class Trial:
    """What a driver said while it was watched; `findings` by topic and kind, each once."""

    heard: dict[str, list[Message]] = field(default_factory=dict)
    findings: dict[tuple[str, str], str] = field(default_factory=dict)
    slowest_call: float = 0.0


def check_driver(driver: RobotDriver, clock: Clock, wait: Wait) -> Iterator[str]:
    """Open the driver, watch it, drive it, stop it; yield what is wrong, one line each."""
    with ExitStack() as opened:
        yield from _until_broken(_of_open(opened, driver, clock, wait))
        yield from _until_broken(_of_closing(opened))


def _of_open(opened: ExitStack, driver: RobotDriver, clock: Clock, wait: Wait) -> Iterator[str]:
    with _foreign("__enter__"):
        opened.enter_context(driver)
    description = _described(driver)
    yield from _of_description(description, _described(driver))
    trial = _watched(driver, clock, wait)
    yield from _of_trial(trial, description)
    if not isinstance(driver, Playback):
        yield from _of_driving(driver, description.max_linear, clock, wait)
    if "look" in description.commands:
        yield from _of_camera(driver, description)
        yield from _of_looking(driver, trial, clock, wait)


def _of_closing(opened: ExitStack) -> Iterator[str]:
    with _foreign("__exit__"):
        opened.close()
    yield from ()


def _until_broken(findings: Iterator[str]) -> Iterator[str]:
    try:
        yield from findings
    except DriverError as error:
        yield f"the driver gave up: {error}"
    except _BrokenError as error:
        yield str(error)


@contextmanager
def _foreign(method: str) -> Iterator[None]:
    """Make a finding of whatever a method of the driver raises: it is not our code that failed."""
    try:
        yield
    except DriverError:
        raise
    except Exception as error:
        raise _BrokenError(f"{method}: raised {in_words(error)}") from error


def _described(driver: RobotDriver) -> RobotDescription:
    with _foreign("describe"):
        description: object = driver.describe()
    if not isinstance(description, RobotDescription):
        raise _BrokenError(f"describe: gave {type(description).__name__}, not RobotDescription")
    return description


def _of_description(first: RobotDescription, again: RobotDescription) -> Iterator[str]:
    if encode(first) != encode(again):
        yield "describe: two calls gave different answers"
    if len(first.footprint) < 3:
        yield f"describe: a footprint needs 3 corners or more, not {len(first.footprint)}"
    elif np.abs(first.footprint).max() > LARGEST_ROBOT:
        yield f"describe: a footprint of more than {LARGEST_ROBOT:g} m; is it in metres?"
    if first.commands and first.max_linear == 0.0 and first.max_angular == 0.0:
        yield "describe: it takes commands, but max_linear and max_angular are 0"


def _watched(driver: RobotDriver, clock: Clock, wait: Wait) -> Trial:
    """Collect what the driver senses for a while."""
    trial = Trial()
    end = clock.monotonic() + WATCHED
    while (begun := clock.monotonic()) < end:
        now_ns = clock.now_ns()
        with _foreign("sense"):
            measurements = list(islice(driver.sense(now_ns), MOST_AT_ONCE))
        if len(measurements) == MOST_AT_ONCE:
            raise _BrokenError("sense: one look never ends; it must return what has come by now")
        trial.slowest_call = max(trial.slowest_call, clock.monotonic() - begun)
        for measurement in measurements:
            _take(trial, measurement, now_ns)
        wait(LOOK_PERIOD)
    return trial


def _take(trial: Trial, measurement: object, now_ns: int) -> None:
    if not isinstance(measurement, Measurement):
        text = f"sense: yields {type(measurement).__name__}, not Measurement(topic, message)"
        trial.findings.setdefault(("sense", "kind"), text)
        return
    name, message = measurement.topic, measurement.message
    topic = TOPICS.get(name)
    if topic is None or topic.owner != "robot":
        text = f"{name}: no topic of the robot; there are {', '.join(_own_topics())}"
        trial.findings.setdefault((name, "topic"), text)
    elif not isinstance(message, topic.message):
        text = f"{name}: carries {topic.message.__name__}, not {type(message).__name__}"
        trial.findings.setdefault((name, "message"), text)
    else:
        trial.heard.setdefault(name, []).append(message)
        ahead = (message.stamp_ns - now_ns) / 1e9
        if abs(ahead) > CLOCK_TOLERANCE_S:
            text = f"{name}: stamped {ahead:+.1f} s from now; stamps are Unix time in ns"
            trial.findings.setdefault((name, "clock"), text)


def _of_trial(trial: Trial, description: RobotDescription) -> Iterator[str]:
    yield from trial.findings.values()
    if trial.slowest_call > LONGEST_CALL:
        yield f"sense: took {1e3 * trial.slowest_call:.0f} ms; it must return at once"
    if "odometry" not in trial.heard:
        yield "odometry: none came; nothing works without it"
    for name, messages in trial.heard.items():
        yield from _of_stamps(name, messages)
        yield from _of_rate(name, len(messages))
    yield from _of_odometry(trial, description.max_linear)
    frames = {mount.frame_id for mount in description.mounts}
    yield from _of_scans(trial, frames)
    yield from _of_sightings(trial, frames)
    yield from _of_edges(trial, frames)


def _of_stamps(name: str, messages: list[Message]) -> Iterator[str]:
    if any(later.stamp_ns <= earlier.stamp_ns for earlier, later in pairwise(messages)):
        yield f"{name}: stamps must increase from message to message"


def _of_rate(name: str, count: int) -> Iterator[str]:
    usual = TOPICS[name].rate_hz
    if usual is not None and count < 0.5 * usual * WATCHED:
        yield f"{name}: {count / WATCHED:.1f} a second, usual are {usual:g}"


def _of_odometry(trial: Trial, max_linear: float) -> Iterator[str]:
    poses = [m.pose for m in trial.heard.get("odometry", []) if isinstance(m, Odometry)]
    farthest = max((math.dist((a.x, a.y), (b.x, b.y)) for a, b in pairwise(poses)), default=0.0)
    if farthest > max(max_linear, 1.0):
        yield f"odometry: jumped by {farthest:.2f} m; is it in metres?"


def _of_scans(trial: Trial, frames: set[str]) -> Iterator[str]:
    scans = [m for m in trial.heard.get("scan", []) if isinstance(m, LaserScan)]
    for scan in scans[:1]:
        sweep = abs(scan.angle_increment) * max(len(scan.ranges) - 1, 0)
        if sweep > 2.0 * math.pi + 0.02:
            yield f"scan: sweeps {sweep:.1f} rad, more than a full turn; are angles in radians?"
        if scan.frame_id not in frames:
            yield f"scan: frame '{scan.frame_id}' has no mount in the description"
    if scans and all(bool(np.isinf(scan.ranges).all()) for scan in scans):
        yield "scan: not one beam came back"
    if any(bool((s.ranges[np.isfinite(s.ranges)] > s.range_max).any()) for s in scans):
        yield "scan: ranges beyond range_max; no return is infinity"


def _of_sightings(trial: Trial, frames: set[str]) -> Iterator[str]:
    pictures = [m for m in trial.heard.get("landmarks", []) if isinstance(m, LandmarkSightings)]
    strange = {picture.frame_id for picture in pictures} - frames - {"base_link"}
    for frame in sorted(strange):
        yield f"landmarks: frame '{frame}' has no mount in the description"
    ranges = [seen.range for picture in pictures for seen in picture.sightings]
    if max(ranges, default=0.0) > FARTHEST_LANDMARK:
        yield f"landmarks: one {max(ranges):.0f} m away; is it in metres?"


def _of_edges(trial: Trial, frames: set[str]) -> Iterator[str]:
    pictures = [m for m in trial.heard.get("vertical_edges", []) if isinstance(m, VerticalEdges)]
    strange = {picture.frame_id for picture in pictures} - frames - {"base_link"}
    for frame in sorted(strange):
        yield f"vertical_edges: frame '{frame}' has no mount in the description"
    widest = max((float(np.abs(p.bearings).max(initial=0.0)) for p in pictures), default=0.0)
    if widest > math.pi:
        yield f"vertical_edges: one at {widest:.0f} rad; are bearings in radians?"


def _of_camera(driver: RobotDriver, description: RobotDescription) -> Iterator[str]:
    if all(mount.kind != "camera" for mount in description.mounts):
        yield "look: among the commands, but the description has no mount of a camera"
    if not isinstance(driver, Gazeable):
        yield "look: among the commands, but the driver has no method look(pan)"


def _of_looking(driver: RobotDriver, trial: Trial, clock: Clock, wait: Wait) -> Iterator[str]:
    """Look to either side and ahead again; pictures must go on coming."""
    if not isinstance(driver, Gazeable):
        return
    for pan in (TRIAL_PAN, -TRIAL_PAN, 0.0):
        begun = clock.monotonic()
        with _foreign("look"):
            driver.look(pan)
        if (took := clock.monotonic() - begun) > LONGEST_CALL:
            yield f"look: took {1e3 * took:.0f} ms; it must return at once"
            break
    pictures = {"landmarks", "vertical_edges"} & trial.heard.keys()
    if pictures and not pictures & _watched(driver, clock, wait).heard.keys():
        yield "look: no picture came after it"


def _of_driving(driver: RobotDriver, max_linear: float, clock: Clock, wait: Wait) -> Iterator[str]:
    """Drive slowly, stop, and compare with the odometry's twist."""
    speed = min(TRIAL_SPEED, max_linear)
    with _foreign("drive"):
        driver.drive(Twist2(vx=speed, vy=0.0, omega=0.0))
    driving = _watched(driver, clock, wait)
    with _foreign("stop"):
        driver.stop()
    told_ns = clock.now_ns()
    stopped = _watched(driver, clock, wait)
    if speed > STILL and not any(_moves(m) for m in driving.heard.get("odometry", [])):
        yield f"drive: told to go {speed:g} m/s, the odometry's twist says that it stands"
    late_from = told_ns + STANDING_WITHIN * 1e9
    if any(_moves(m) and m.stamp_ns > late_from for m in stopped.heard.get("odometry", [])):
        yield f"stop: it still moved {STANDING_WITHIN:g} s later"


def _moves(message: Message) -> bool:
    if not isinstance(message, Odometry):
        return False
    return max(abs(message.twist.vx), abs(message.twist.vy), abs(message.twist.omega)) > STILL


def _own_topics() -> list[str]:
    return [topic.name for topic in TOPICS.values() if topic.owner == "robot"]
