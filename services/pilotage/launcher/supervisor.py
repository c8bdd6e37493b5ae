"""All processes of a run: in order up, watched, in order down."""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from pilotage.bus.clock import Clock
from pilotage.bus.node import BEAT_LIMIT_S
from pilotage.launcher.process_table import Entry
from pilotage.launcher.supervised import Patience, Running, Supervised
from pilotage_schemas.health import Heartbeat, Process

TICK_S = 0.1
"""How often the processes are looked at: an exit is noticed within this time."""

STALL_S = 0.5
"""When the launcher itself did not run for so long, beats may be waiting: nobody is late yet."""

RECONNECT_GRACE_S = 3.0
"""After the router's return every service has connected again within this time (retry 0.5 s)."""

JOIN_POLL_S = 0.01


@dataclass(frozen=True)
class Ending:
    """Why the run must end by itself, and with which exit code."""

    code: int
    reason: str


class Supervisor:
    """Starts, watches and ends the processes; `tick` is called every TICK_S."""

    def __init__(
        self,
        entries: Iterable[Entry],
        start: Callable[[Entry], Running],
        announce: Callable[[str, str], None],
        clock: Clock,
        patience: Patience,
    ) -> None:
        def announcer(name: str) -> Callable[[str], None]:
            return lambda text: announce(name, text)

        self._clock = clock
        self._all = {
            entry.name: Supervised(entry, start, announcer(entry.name), clock, patience)
            for entry in entries
        }
        self._last_tick = clock.monotonic()
        self._last_states: tuple[object, ...] = ()

    def tick(self, *, bus_is_up: bool) -> bool:
        """Look at every process and do what is due; return whether anything changed."""
        self._excuse(bus_is_up=bus_is_up)
        for one in self._all.values():
            if bus_is_up and not one.entry.sends_beats:
                one.beat("ready", BEAT_LIMIT_S)
            one.tick(may_start=self._may_start(one.entry))
        states = tuple((o.state, o.restarts, o.child is None) for o in self._all.values())
        changed, self._last_states = states != self._last_states, states
        return changed

    def heard(self, beat: Heartbeat) -> None:
        """Note a service's heartbeat; of others (another launcher's services) nothing is known."""
        one = self._all.get(beat.service)
        if one is not None:
            one.heard(beat)

    def is_ready(self, name: str) -> bool:
        """Say whether a process does its work."""
        return self._all[name].state == "ready"

    def names(self) -> tuple[str, ...]:
        """Return the names of the processes of this run."""
        return tuple(self._all)

    def restart(self, name: str) -> None:
        """Start a process anew; KeyError when it does not belong to this run."""
        self._all[name].restart()

    def ending(self) -> Ending | None:
        """Return why the run must end: settings refused, or nothing left worth running."""
        for one in self._all.values():
            if one.refusal is not None:
                return Ending(2, f"{one.entry.name} {one.refusal}")
            if one.state == "given_up" and one.entry.is_critical:
                return Ending(1, f"{one.entry.name} is given up: {one.reason}")
        services = [one for one in self._all.values() if one.entry.sends_beats]
        if services and all(one.state == "given_up" for one in services):
            return Ending(1, "every service is given up")
        return None

    def report(self) -> tuple[Process, ...]:
        """Return what the deployment topic says."""
        return tuple(one.report() for one in self._all.values())

    def stop(self, within: float) -> None:
        """Ask all to end, wait `within` s, kill the rest; the router goes after its users."""
        for one in self._all.values():
            one.put_down()
        users = [one for one in self._all.values() if one.entry.after]
        others = [one for one in self._all.values() if not one.entry.after]
        for wave, limit in ((users, within), (others, within / 3.0)):
            _end([one.child for one in wave if one.child is not None], limit)
            for one in wave:
                one.child = None

    def kill(self) -> None:
        """End all at once."""
        for one in self._all.values():
            if one.child is not None:
                one.child.kill()

    def _excuse(self, *, bus_is_up: bool) -> None:
        now = self._clock.monotonic()
        if now - self._last_tick > STALL_S:
            self._excuse_all(now + BEAT_LIMIT_S)
        self._last_tick = now
        router_held = any(o.is_held() for o in self._all.values() if not o.entry.sends_beats)
        if router_held or not bus_is_up:
            self._excuse_all(now + RECONNECT_GRACE_S)

    def _excuse_all(self, until: float) -> None:
        for one in self._all.values():
            if one.entry.sends_beats:
                one.excuse(until)

    def _may_start(self, entry: Entry) -> bool:
        return all(self.is_ready(name) for name in entry.after if name in self._all)


def _end(children: list[Running], within: float) -> None:
    for child in children:
        child.ask_to_end()
    deadline = time.monotonic() + within
    while time.monotonic() < deadline and any(child.poll() is None for child in children):
        time.sleep(JOIN_POLL_S)
    for child in children:
        if child.poll() is None:
            child.kill()
