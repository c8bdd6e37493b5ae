"""The life of one process of the table: started, ready, late, down, started again, given up."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from pilotage.bus.clock import Clock
from pilotage.launcher.liveness import BeatState, Liveness
from pilotage.launcher.process_table import Entry
from pilotage.launcher.restart_policy import RestartHistory, RestartPolicy
from pilotage_schemas.health import Heartbeat, Process

State = Literal["starting", "ready", "late", "down", "given_up", "stopped"]

STOPPED_LIMIT_S = 0.5
"""A process that a signal holds this long is hung; a tool that throttles holds it far shorter."""

RESTART_GRACE_S = 2.0
"""A process that is to be restarted on request may take this long to end by itself."""

BAD_SETTINGS = 2
"""Exit code of a service whose settings cannot be used: trying again is of no use."""


class Running(Protocol):
    """What a started process can be asked."""

    @property
    def pid(self) -> int:
        """The process id."""
        ...

    def poll(self) -> int | None:
        """Return the exit code; None while it runs."""
        ...

    def exit_reason(self) -> str:
        """Return how it ended."""
        ...

    def is_stopped(self) -> bool:
        """Say whether a signal holds it."""
        ...

    def ask_to_end(self) -> None:
        """Ask it to end by itself."""
        ...

    def kill(self) -> None:
        """End it at once."""
        ...


@dataclass(frozen=True)
class Patience:
    """Limits in seconds: to the first heartbeat, and from late to hung."""

    start_limit: float
    hang_grace: float


class Supervised:
    """One process of the table; `tick` looks at it and does what is due.

    `start(entry)` starts it, OSError says that it cannot; `announce(text)` tells people.
    """

    def __init__(
        self,
        entry: Entry,
        start: Callable[[Entry], Running],
        announce: Callable[[str], None],
        clock: Clock,
        patience: Patience,
    ) -> None:
        self.entry = entry
        self.child: Running | None = None
        self.state: State = "starting"
        self.reason = ""
        self.restarts = 0
        self.refusal: str | None = None
        self._start = start
        self._announce = announce
        self._clock = clock
        self._patience = patience
        self._history = RestartHistory(RestartPolicy())
        self._since_ns = clock.now_ns()
        self._started_ns = 0
        self._start_at: float | None = clock.monotonic()
        self._kill_at: float | None = None
        self._stopped_since: float | None = None
        self._was_ready = False
        self._liveness = self._new_liveness()

    def tick(self, *, may_start: bool) -> None:
        """See how it is now and act: start, restart, end what hangs."""
        now = self._clock.monotonic()
        if self.child is None:
            if self._start_at is not None and now >= self._start_at and may_start:
                self._start_now()
        elif (code := self.child.poll()) is not None:
            self._ended(code, self.child.exit_reason())
        elif self._kill_at is not None:
            self._kill_if_it_does_not_end(now)
        else:
            self._judge(self.child, now)

    def heard(self, beat: Heartbeat) -> None:
        """Note a heartbeat; one of an earlier process of this name does not count."""
        if beat.stamp_ns >= self._started_ns:
            self.beat(beat.state, beat.within)

    def beat(self, state: BeatState, within: float) -> None:
        """Note a sign of life; the next one is due in `within` s."""
        self._liveness.beat(state, within, self._clock.monotonic())

    def excuse(self, until: float) -> None:
        """Expect no heartbeat before `until` (monotonic seconds)."""
        self._liveness.excuse(until)

    def is_held(self) -> bool:
        """Say whether a signal holds the process."""
        return self.child is not None and self.child.is_stopped()

    def restart(self) -> None:
        """Start it anew because someone asked for it; earlier failures are forgotten."""
        self._history.forget()
        if self.child is None:
            self._start_at = self._clock.monotonic()
            self._enter("starting", "restart asked for")
        else:
            self._kill_at = self._clock.monotonic() + RESTART_GRACE_S
            self.child.ask_to_end()

    def put_down(self) -> None:
        """Never start it again: the run ends."""
        self._start_at = None
        self._enter("stopped", "the run ends")

    def report(self) -> Process:
        """Return what the deployment topic says of it."""
        now = self._clock.monotonic()
        late = self.state == "late"
        return Process(
            name=self.entry.name,
            state=self.state,
            pid=None if self.child is None else self.child.pid,
            since_ns=self._since_ns,
            late_for=self._liveness.silent_for(now) if late else None,
            limit=self._liveness.within,
            restarts=self.restarts,
            try_number=self._history.count(now),
            max_tries=self._history.policy.max_failures,
            reason=self.reason[:2000],
        )

    def _start_now(self) -> None:
        self._start_at = None
        self._started_ns = self._clock.now_ns()
        self._liveness = self._new_liveness()
        self._stopped_since = None
        self._enter("starting", self.reason)
        try:
            self.child = self._start(self.entry)
        except OSError as error:
            self._fail(f"cannot be started: {error}")

    def _new_liveness(self) -> Liveness:
        now = self._clock.monotonic()
        return Liveness(now, self._patience.start_limit, self._patience.hang_grace)

    def _judge(self, child: Running, now: float) -> None:
        if self._is_held_for_long(child, now) or self._liveness.is_hung(now):
            child.kill()
            self._fail(self._silence(now))
        elif self._liveness.is_late(now):
            if self.state != "late":
                self._enter("late", self._silence(now))
                self._announce(f"late: {self.reason}")
        elif self._liveness.is_ready:
            self._become_ready()
        else:
            self._enter("starting", self.reason)

    def _become_ready(self) -> None:
        if self.state == "ready":
            return
        took = (self._clock.now_ns() - self._started_ns) / 1e9
        self._announce(f"ready after {took:.1f} s" if self.state == "starting" else "ready again")
        self._was_ready = True
        self._enter("ready", "")

    def _is_held_for_long(self, child: Running, now: float) -> bool:
        if not child.is_stopped():
            self._stopped_since = None
            return False
        if self._stopped_since is None:
            self._stopped_since = now
        return now - self._stopped_since >= STOPPED_LIMIT_S

    def _silence(self, now: float) -> str:
        if self._stopped_since is not None:
            held = now - self._stopped_since
            return f"held by a signal for {held:.1f} s (limit {STOPPED_LIMIT_S:.1f} s)"
        silent, limit = self._liveness.silent_for(now), self._liveness.within
        what = "heartbeat" if self.entry.sends_beats else "connection"
        return f"no {what} for {silent:.1f} s (limit {limit:.1f} s)"

    def _kill_if_it_does_not_end(self, now: float) -> None:
        if self.child is not None and self._kill_at is not None and now >= self._kill_at:
            self.child.kill()

    def _ended(self, code: int, how: str) -> None:
        if self._kill_at is None:
            if code == BAD_SETTINGS and not self._was_ready:
                self.refusal = how
            self._fail(how)
            return
        self.child = self._kill_at = None
        self.restarts += 1
        self._start_at = self._clock.monotonic()
        self._announce("restarting, as asked")
        self._enter("starting", "restart asked for")

    def _fail(self, reason: str) -> None:
        now = self._clock.monotonic()
        self.child = None
        delay = self._history.fail(now)
        tries = f"failure {self._history.count(now)} of {self._history.policy.max_failures}"
        if delay is None:
            self._enter("given_up", reason)
            self._announce(f"GIVEN UP ({tries} within a minute): {reason}")
            return
        self._start_at = now + delay
        self.restarts += 1
        self._enter("down", reason)
        self._announce(f"down: {reason}; restarting in {delay:.1f} s ({tries})")

    def _enter(self, state: State, reason: str) -> None:
        if state != self.state:
            self._since_ns = self._clock.now_ns()
        self.state, self.reason = state, reason
