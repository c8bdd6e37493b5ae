"""A fabric in one process for tests: delivers at once, on the caller's thread."""

import fnmatch
from collections import deque
from collections.abc import Callable

from pilotage.bus.fabric import (
    NoAnswerError,
    NoAnswerInTimeError,
    Question,
    RefusedError,
    Sample,
)
from pilotage_schemas.topics import Delivery


class FakeFabric:
    """Carries bytes between the nodes of one test; shared by all of them.

    `pump` lets a test step the answering node while a query waits.
    """

    def __init__(self) -> None:
        self.pump: Callable[[], None] = lambda: None
        self.connected = True
        self._subscribers: list[tuple[str, Callable[[Sample], None]]] = []
        self._queryables: dict[str, Callable[[Question], None]] = {}
        self._watchers: list[tuple[str, Callable[[str, bool], None]]] = []
        self._present: list[str] = []
        self._kept: dict[str, deque[bytes]] = {}

    def declare_publisher(
        self, key: str, encoding: str, delivery: Delivery, history: int = 1
    ) -> Callable[[bytes], None]:
        """Return the function that hands a payload to every matching subscriber."""
        if not encoding.startswith("application/cbor;"):
            raise ValueError(f"{key} is published with encoding {encoding}")

        def put(payload: bytes) -> None:
            if delivery == "never_drop":
                self._kept.setdefault(key, deque(maxlen=history)).append(payload)
            for pattern, on_sample in list(self._subscribers):
                if fnmatch.fnmatchcase(key, pattern):
                    on_sample(Sample(key, payload))

        return put

    def declare_subscriber(
        self, key: str, delivery: Delivery, on_sample: Callable[[Sample], None], history: int = 1
    ) -> None:
        """Subscribe; a topic that must not drop begins with its last payloads."""
        self._subscribers.append((key, on_sample))
        if delivery == "never_drop":
            for kept_key, payloads in self._kept.items():
                if fnmatch.fnmatchcase(kept_key, key):
                    for payload in list(payloads)[-history:]:
                        on_sample(Sample(kept_key, payload))

    def declare_queryable(self, key: str, on_question: Callable[[Question], None]) -> None:
        """Answer a query."""
        self._queryables[key] = on_question

    def ask(self, key: str, payload: bytes, timeout_s: float) -> bytes:
        """Ask, pump the nodes once, and return the answer."""
        if key not in self._queryables:
            raise NoAnswerError("the service is not running")
        replies: list[bytes] = []
        refusals: list[bytes] = []
        self._queryables[key](Question(payload, replies.append, refusals.append))
        self.pump()
        if refusals:
            raise RefusedError(refusals[0])
        if not replies:
            raise NoAnswerInTimeError(f"no answer within {timeout_s:g} s")
        return replies[0]

    def declare_presence(self, key: str) -> None:
        """Announce a key."""
        self._present.append(key)
        self._tell(key, present=True)

    def withdraw(self, key: str) -> None:
        """Let a key go, as when its process dies."""
        self._present.remove(key)
        self._tell(key, present=False)

    def watch_presence(self, key: str, on_change: Callable[[str, bool], None]) -> None:
        """Tell of what is present and of each change."""
        self._watchers.append((key, on_change))
        for present in self._present:
            if fnmatch.fnmatchcase(present, key):
                on_change(present, True)  # noqa: FBT003 - the fabric's signature

    def is_connected(self) -> bool:
        """Say what the test has set."""
        return self.connected

    def close(self) -> None:
        """Forget everybody."""
        self._subscribers.clear()
        self._queryables.clear()
        self._watchers.clear()

    def _tell(self, key: str, *, present: bool) -> None:
        for pattern, on_change in list(self._watchers):
            if fnmatch.fnmatchcase(key, pattern):
                on_change(key, present)
