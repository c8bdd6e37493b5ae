"""The launcher on the bus: heartbeats in, the topic `deployment` out, `restart` on request."""

from collections.abc import Callable

from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.launcher.supervisor import TICK_S, Ending, Supervisor
from pilotage_schemas.commands import Done, Restart
from pilotage_schemas.health import Deployment

REPORT_S = 1.0
BEATS_KEPT = 256


class LauncherService:
    """Lets the supervisor look at its processes and tells the bus what it sees.

    `when_served()` is called once, when the gateway serves its page.
    """

    def __init__(self, node: Node, supervisor: Supervisor, when_served: Callable[[], None]) -> None:
        self.ending: Ending | None = None
        self._node = node
        self._supervisor = supervisor
        self._when_served = when_served
        self._is_served = False
        self._deployment = node.publisher("deployment")
        node.subscribe("heartbeat", supervisor.heard, depth=BEATS_KEPT)
        node.answer("restart", self.restart)
        node.every(TICK_S, self.look)
        node.every(REPORT_S, self.publish)

    def look(self) -> None:
        """Look at the processes; publish what changed; stop when the run must end."""
        if self._supervisor.tick(bus_is_up=self._node.fabric.is_connected()):
            self.publish()
            self._tell_when_served()
        self.ending = self._supervisor.ending()
        if self.ending is not None:
            self._node.stop()

    def publish(self) -> None:
        """Publish the state of every process."""
        self._deployment.publish(
            Deployment(
                stamp_ns=self._node.clock.now_ns(),
                frame_id="",
                processes=self._supervisor.report(),
            )
        )

    def restart(self, request: Restart) -> Done:
        """Restart one process; refused for one that does not belong to this run."""
        if request.service not in self._supervisor.names():
            known = ", ".join(self._supervisor.names())
            raise RefusedError(f"no process '{request.service}' in this run (it has {known})")
        self._supervisor.restart(request.service)
        return Done(detail=f"{request.service} is restarting")

    def _tell_when_served(self) -> None:
        names = self._supervisor.names()
        if not self._is_served and "gateway" in names and self._supervisor.is_ready("gateway"):
            self._is_served = True
            self._when_served()
