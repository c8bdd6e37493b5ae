"""Between the fabric's threads and a service's loop: a bounded queue and a wake-up call."""

import threading
from collections import deque
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Inbox(Generic[Item]):
    """Numbered items from any thread for one reader; the oldest make room for the newest.

    The lock is held for a few instructions only, so that no callback ever waits. (A bare deque
    would do but for two callbacks that both see it too long, and both shorten it.)
    """

    def __init__(self, depth: int) -> None:
        if depth < 1:
            raise ValueError(f"a queue of depth {depth} would hold nothing")
        self._depth = depth
        self._lock = threading.Lock()
        self._items: deque[tuple[int, Item]] = deque()
        self._lost = 0

    def put(self, arrival: int, item: Item) -> None:
        """Append an item; beyond the depth the oldest goes."""
        with self._lock:
            self._items.append((arrival, item))
            if len(self._items) > self._depth:
                self._items.popleft()
                self._lost += 1

    def oldest(self) -> int | None:
        """Return the arrival number of the oldest item, None when there is none."""
        with self._lock:
            return self._items[0][0] if self._items else None

    def take(self) -> Item:
        """Remove and return the oldest item; IndexError when there is none."""
        with self._lock:
            return self._items.popleft()[1]

    def lost(self) -> int:
        """Return how many items had to make room since the last call."""
        with self._lock:
            lost, self._lost = self._lost, 0
            return lost


class Wake:
    """A wake-up call for one sleeper that may come from a thread or from a signal handler.

    threading.Event takes a lock that the interrupted main thread may be holding, and would then
    wait for itself for ever; releasing a bare lock waits for nobody.
    """

    def __init__(self) -> None:
        self._closed = threading.Lock()
        self._closed.acquire()

    def call(self) -> None:
        """Wake the sleeper now, or keep its next sleep from beginning."""
        try:
            self._closed.release()
        except RuntimeError:
            return  # somebody else has called already

    def wait(self, timeout_s: float) -> bool:
        """Sleep until the call or for `timeout_s`; say whether the call came."""
        return self._closed.acquire(timeout=timeout_s)
