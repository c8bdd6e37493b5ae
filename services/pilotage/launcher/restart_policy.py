"""When a process that failed is started again, and when not any more."""

from collections import deque
from dataclasses import dataclass, field


@dataclass(frozen=True)
class RestartPolicy:
    """Back-off between restarts, and its end.

    Waits `first_delay` s after a failure and twice as long after each further one, at most
    `longest_delay` s; gives up at `max_failures` failures within `window` s. A process that ran
    for `window` s without failing begins anew.
    """

    first_delay: float = 0.2
    longest_delay: float = 10.0
    max_failures: int = 5
    window: float = 60.0


@dataclass
class RestartHistory:
    """The failures of one process; times are seconds of any clock that only goes forward."""

    policy: RestartPolicy
    _failures: deque[float] = field(default_factory=deque)
    _in_a_row: int = 0

    def fail(self, now: float) -> float | None:
        """Note a failure; return the seconds to wait before the next start, None to give up."""
        if self.count(now) == 0:
            self._in_a_row = 0
        self._failures.append(now)
        self._in_a_row += 1
        if self.count(now) >= self.policy.max_failures:
            return None
        delay = self.policy.first_delay * 2.0 ** (self._in_a_row - 1)
        return min(delay, self.policy.longest_delay)

    def count(self, now: float) -> int:
        """Return the number of failures within the last `window` s."""
        while self._failures and now - self._failures[0] >= self.policy.window:
            self._failures.popleft()
        return len(self._failures)

    def forget(self) -> None:
        """Begin anew: someone asked for this start."""
        self._failures.clear()
        self._in_a_row = 0
