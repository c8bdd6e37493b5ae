"""Whether a process lives, judged by its heartbeats alone.

Each beat says within how many seconds the next one comes. One that does not come makes the
process late, which is shown; late for `hang_grace` s more makes it hung, which is ended. Beats
that cannot arrive (the router is away) or could not be counted (this machine was too busy to run
the launcher) are excused.
"""

from dataclasses import dataclass
from typing import Literal

BeatState = Literal["starting", "ready", "busy"]


@dataclass
class Liveness:
    """The heartbeats of one process since its start at `last` s.

    The first beat is due within `within` s of the start; `hang_grace` s are the patience with a
    late process, because a loaded machine delays beats too.
    """

    last: float
    within: float
    hang_grace: float
    is_ready: bool = False
    _excused_until: float = 0.0

    def beat(self, state: BeatState, within: float, now: float) -> None:
        """Note a beat; the next one is due in `within` s. `busy` leaves ready what was ready."""
        if state != "busy":
            self.is_ready = state == "ready"
        self.last = now
        self.within = within

    def excuse(self, until: float) -> None:
        """Expect no beat before `until`."""
        self._excused_until = max(self._excused_until, until)

    def is_late(self, now: float) -> bool:
        """Say whether a beat is overdue."""
        return now >= self._due

    def is_hung(self, now: float) -> bool:
        """Say whether a beat is so long overdue that the process must be ended."""
        return now >= self._due + self.hang_grace

    def silent_for(self, now: float) -> float:
        """Return the seconds since the last beat, or since the start."""
        return max(0.0, now - self.last)

    @property
    def _due(self) -> float:
        return max(self.last + self.within, self._excused_until)
