"""A service's own account of itself: traffic, memory, processor time."""

import os
import time
from pathlib import Path
from typing import Literal

from pilotage.bus.clock import Clock
from pilotage.bus.endpoints import Traffic
from pilotage_schemas.arrays import LARGEST
from pilotage_schemas.health import Health, TopicHealth
from pilotage_schemas.topics import Topic


def resident_mb() -> float:
    """Return the memory that this process holds now, in MB of 2^20 bytes."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def _bounded(number: float) -> float:
    """Return the number as Health may hold it: a sender's stamp can lie anywhere in time."""
    return min(max(number, 0.0), LARGEST)


class Vitals:
    """Counts what passes and reports it once a second."""

    def __init__(self, service: str, clock: Clock) -> None:
        self.last_error = ""
        self.bad_questions = 0
        self._service = service
        self._clock = clock
        self._started = clock.monotonic()
        self._last = self._started
        self._last_cpu = time.process_time()
        self._traffic: list[Traffic] = []
        self._last_counts: dict[int, int] = {}

    def traffic(self, topic: Topic, direction: Literal["in", "out"]) -> Traffic:
        """Return new counters of a topic, reported from now on."""
        counters = Traffic(topic, direction)
        self._traffic.append(counters)
        return counters

    def report(self) -> Health:
        """Return the account since the last report."""
        now, cpu = self._clock.monotonic(), time.process_time()
        elapsed = max(now - self._last, 1e-6)
        health = Health(
            stamp_ns=self._clock.now_ns(),
            frame_id="",
            service=self._service,
            uptime=_bounded(now - self._started),
            cpu_percent=_bounded(100.0 * (cpu - self._last_cpu) / elapsed),
            rss_mb=resident_mb(),
            topics=tuple(self._line(t, elapsed) for t in self._traffic),
            dropped=sum(t.dropped for t in self._traffic) + self.bad_questions,
            last_error=self.last_error[:2000],
        )
        self._last, self._last_cpu = now, cpu
        return health

    def _line(self, traffic: Traffic, elapsed: float) -> TopicHealth:
        before = self._last_counts.get(id(traffic), 0)
        self._last_counts[id(traffic)] = traffic.count
        last = traffic.last_stamp_ns
        age = None if last is None else _bounded((self._clock.now_ns() - last) / 1e9)
        return TopicHealth(
            topic=traffic.topic.name,
            direction=traffic.direction,
            count=traffic.count,
            rate_hz=_bounded((traffic.count - before) / elapsed),
            dropped=traffic.dropped,
            age=age,
            limit=None if traffic.is_resting else traffic.topic.stale_after,
        )
