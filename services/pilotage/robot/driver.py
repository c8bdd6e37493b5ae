"""What a robot must be able to do to be piloted: the protocol that every driver fulfils.

The simulator and the replay of logs are drivers like any other; a robot of one's own needs one
class with these methods and one line in the deployment file (see README.md, "Parameters").
"""

from collections.abc import Iterable
from dataclasses import dataclass
from types import TracebackType
from typing import Protocol, Self, runtime_checkable

from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.message import Message
from pilotage_schemas.sensors import RobotDescription


class DriverError(RuntimeError):
    """The robot cannot do what was asked; the text says why, in one line."""


def in_words(error: BaseException) -> str:
    """Return kind and message of whatever a driver raised, in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


@dataclass(frozen=True)
class Measurement:
    """A message and the topic of the registry that it goes out by; its `seq` is set there."""

    topic: str
    message: Message


class RobotDriver(Protocol):
    """A robot. No method may block for more than a few milliseconds.

    All of them are called by one thread. `sense` comes 50 times a second; between two calls a
    driver with its own input (serial line, socket) collects what arrives.
    """

    def __enter__(self) -> Self:
        """Open the connection; DriverError if that is not possible."""
        ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
        /,
    ) -> None:
        """Stop the robot and close the connection."""
        ...

    def describe(self) -> RobotDescription:
        """Say how the robot is built; the same answer each time, its stamp is not used."""
        ...

    def sense(self, now_ns: int) -> Iterable[Measurement]:
        """Return what was measured since the last call, stamped with its time of measurement.

        `now_ns` is Unix time. DriverError if the connection is lost; the call is repeated.
        """
        ...

    def drive(self, twist: Twist2) -> None:
        """Drive with this twist until told otherwise; it is within the limits of `describe`.

        DriverError refuses the command with its reason.
        """
        ...

    def stop(self) -> None:
        """Stand still as fast as the robot can; must never be refused by a robot that moves."""
        ...


@runtime_checkable
class Kidnappable(Protocol):
    """A robot that can be carried away: a simulated one."""

    def kidnap(self, pose: Pose2 | None) -> Pose2:
        """Put the robot at `pose`, or at a random free place; return where it now is.

        DriverError if it cannot stand there.
        """
        ...


@runtime_checkable
class Gazeable(Protocol):
    """A robot with a camera on a joint; its description has a camera and the command `look`."""

    def look(self, pan: float) -> None:
        """Turn the camera to `pan` rad off the robot's x axis, or as far that way as it goes.

        Returns at once; the camera gets there at its own speed. DriverError if it cannot turn.
        """
        ...


@runtime_checkable
class Playback(Protocol):
    """A recorded run in place of a robot."""

    @property
    def speed_factor(self) -> float:
        """Log seconds per second."""
        ...

    @property
    def progress(self) -> float:
        """Part of the log that has been played, 0 to 1."""
        ...

    @property
    def is_finished(self) -> bool:
        """Whether nothing more will come."""
        ...

    @property
    def account(self) -> str:
        """Where the playback is, in words."""
        ...


LOG_REFUSAL = "a recorded log cannot be driven"
