"""THE PROCESS TABLE: the whole system as one list, in the order in which it starts.

A process exists only if it stands here. Read a line as: name, the module that `python -m` runs,
the class of its settings, what must be ready before it starts, and when it belongs to a run.
"""

from collections.abc import Callable
from dataclasses import dataclass

from pilotage.bus.deployment import Deployment
from pilotage.launcher.addresses import is_accepting

When = Callable[[Deployment], bool]


def named(name: str) -> When:
    """Return the predicate: the deployment has a section for this service."""
    return lambda deployment: name in deployment.services


def unless_a_router_answers(deployment: Deployment) -> bool:
    """Belongs to a run whose endpoint nobody serves yet: any zenohd can stand in its place."""
    return not is_accepting(deployment.router)


@dataclass(frozen=True)
class Entry:
    """One process of the system.

    `settings` is `module:Class`, imported only when the deployment is checked; None takes none.
    `sends_beats`: a service says itself that it lives; of the router, the bus it carries says so.
    `is_critical`: the run ends when this process is given up.
    """

    name: str
    module: str
    settings: str | None
    after: tuple[str, ...]
    when: When
    sends_beats: bool = True
    is_critical: bool = False


def _service(name: str) -> Entry:
    settings = f"pilotage.{name}.config:{name.capitalize()}Settings"
    return Entry(name, f"pilotage.{name}", settings, after=("router",), when=named(name))


ROUTER = Entry(
    "router",
    "pilotage.bus.router",
    settings=None,
    after=(),
    when=unless_a_router_answers,
    sends_beats=False,
    is_critical=True,
)

PROCESSES = (
    ROUTER,
    _service("gateway"),  # first of the services, so that the page can show the others come
    _service("mapper"),
    _service("robot"),
    _service("localizer"),
    _service("planner"),
    _service("topology"),
)


def wanted(table: tuple[Entry, ...], deployment: Deployment) -> tuple[Entry, ...]:
    """Return the entries that belong to a run of this deployment, in table order."""
    return tuple(entry for entry in table if entry.when(deployment))
