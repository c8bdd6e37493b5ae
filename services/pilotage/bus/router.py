"""The embedded router, a process of its own: `python -m pilotage.bus.router`.

The same engine as zenohd; any zenohd can stand in its place.
"""

import signal
import sys
import threading

import zenoh

from pilotage.bus.deployment import ConfigError
from pilotage.bus.runner import complain, deployment_of_arguments, prepare_process
from pilotage.bus.session import common_settings, config_from


def router_config(endpoint: str) -> zenoh.Config:
    """Return the configuration of a router that listens at `endpoint` and nowhere else."""
    return config_from(common_settings() | {"mode": "router", "listen/endpoints": [endpoint]})


def main() -> int:
    """Route until asked to stop; 1 when the endpoint cannot be had."""
    prepare_process("router")
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda _number, _frame: stop.set())
    try:
        endpoint = deployment_of_arguments("router").router
        with zenoh.open(router_config(endpoint)):
            stop.wait()
    except ConfigError as error:
        return complain("router", error, 2)
    except zenoh.ZError as error:
        return complain("router", f"cannot listen at {endpoint}: {error}", 1)
    return 0


if __name__ == "__main__":
    sys.exit(main())
