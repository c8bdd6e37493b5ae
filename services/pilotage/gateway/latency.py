"""Ages of messages at arrival: the end-to-end latency from sensor to gateway."""

from collections import deque
from dataclasses import dataclass

import numpy as np

KEPT = 512
"""Ages per topic; at 10 Hz the last 50 s."""


@dataclass(frozen=True)
class Latency:
    """Median, 99th percentile and maximum of `count` recent ages, in ms."""

    count: int
    p50_ms: float
    p99_ms: float
    max_ms: float


class LatencyStatistics:
    """The recent ages of each topic."""

    def __init__(self) -> None:
        self._ages: dict[str, deque[float]] = {}

    def add(self, topic: str, age_ms: float) -> None:
        """Count one message."""
        self._ages.setdefault(topic, deque(maxlen=KEPT)).append(age_ms)

    def of(self, topic: str) -> Latency | None:
        """Return the statistics of a topic; None when nothing has come."""
        ages = self._ages.get(topic)
        if not ages:
            return None
        p50, p99, highest = np.percentile(np.array(ages), (50, 99, 100)).tolist()
        return Latency(len(ages), p50, p99, highest)

    def all(self) -> dict[str, Latency]:
        """Return the statistics of every topic that has come, by name."""
        found = {topic: self.of(topic) for topic in sorted(self._ages)}
        return {topic: latency for topic, latency in found.items() if latency is not None}
