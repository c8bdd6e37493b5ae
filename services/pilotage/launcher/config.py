"""Settings of the launcher, section `launcher` of a deployment."""

from typing import Annotated

from pydantic import Field

from pilotage.bus.deployment import Settings

Seconds = Annotated[float, Field(gt=0.0, le=600.0, allow_inf_nan=False)]


class LauncherSettings(Settings):
    """How patient the launcher is; nobody needs to set anything.

    `start_limit` [s]: time to the first heartbeat; with a cold cache kernels are compiled first.
    `hang_grace` [s]: what a late service gets before it is ended, twice its limit; with ten busy
    processes on two cores a service that computed was up to 0.2 s late. `stop_within` [s]: time
    for all to end by themselves. `keep_runs`: run folders that are kept.
    """

    start_limit: Seconds = 60.0
    hang_grace: Seconds = 2.0
    stop_within: Seconds = 2.5
    keep_runs: Annotated[int, Field(ge=1, le=1000)] = 5
