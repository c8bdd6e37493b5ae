"""How the services are."""

from typing import Annotated, Literal

from pydantic import Field

from pilotage_schemas.message import Message, Name, NonNegative, Part, Positive, Text

Count = Annotated[int, Field(ge=0, lt=2**63)]


class Heartbeat(Message):
    """Sent by a service's own loop at 4 Hz, so that a loop that hangs is noticed.

    Before work that takes longer the service says so: the next beat comes `within` seconds.
    """

    service: Name
    state: Literal["starting", "ready", "busy"]
    within: Positive


class TopicHealth(Part):
    """Traffic on one topic of a service since it started; `age` of the newest sample in s."""

    topic: Name
    direction: Literal["in", "out"]
    count: Count
    rate_hz: NonNegative
    dropped: Count
    age: NonNegative | None
    limit: NonNegative | None
    """Age beyond which the topic is stale, by the registry's rate; None for events, and for what
    another service publishes at present."""


class Health(Message):
    """A service's own account, once a second."""

    service: Name
    uptime: NonNegative
    cpu_percent: NonNegative
    rss_mb: NonNegative
    topics: Annotated[tuple[TopicHealth, ...], Field(max_length=200, strict=False)]
    dropped: Count
    last_error: Text


class Process(Part):
    """One process of a deployment as its supervisor sees it.

    `late_for` is the time since the last heartbeat when it is overdue; `try_number` of
    `max_tries` counts restarts in the current minute.
    """

    name: Name
    state: Literal["starting", "ready", "late", "down", "given_up", "stopped"]
    pid: Annotated[int, Field(ge=0)] | None
    since_ns: Count
    late_for: NonNegative | None
    limit: Positive
    restarts: Count
    try_number: Count
    max_tries: Count
    reason: Text


class Deployment(Message):
    """All processes of a deployment, sent at every change and once a second."""

    processes: Annotated[tuple[Process, ...], Field(max_length=64, strict=False)]
