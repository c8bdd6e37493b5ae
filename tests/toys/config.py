"""Settings of the toys."""

from typing import Literal

from pilotage.bus.deployment import Settings

Mood = Literal["steady", "crashing", "refusing", "deaf", "silent", "slow"]


class ToySettings(Settings):
    """How the toy behaves.

    steady: lives. crashing: ends with code 1 at once. refusing: cannot use its settings.
    deaf: lives and does not end when asked. silent: gets ready, then its loop hangs. slow: says
    that it is starting for longer than a beat's limit, then lives.
    """

    mood: Mood = "steady"
