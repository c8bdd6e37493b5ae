"""Ports and endpoints of this machine: free, taken, answering."""

import errno
import socket

from pilotage.bus.deployment import ConfigError

PROBE_S = 0.2
LOOPBACK = "127.0.0.1"
EVERY_ADDRESS = ("", "0.0.0.0", "::")  # noqa: S104 - recognised here, never bound


def free_endpoint() -> str:
    """Return a router endpoint at a port of this machine that is free now."""
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return f"tcp/{LOOPBACK}:{probe.getsockname()[1]}"


def is_accepting(endpoint: str) -> bool:
    """Say whether somebody accepts connections at a `tcp/HOST:PORT` or `tls/HOST:PORT`."""
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.rpartition(":")
    if protocol not in ("tcp", "tls") or not port.isdigit():
        return False
    try:
        with socket.create_connection((host.strip("[]"), int(port)), PROBE_S):
            return True
    except OSError:
        return False


def require_free_port(host: str, port: int) -> None:
    """Raise ConfigError when nobody can listen at this address, as when someone else does."""
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            # As servers do: a port that only waits for its former owner's last packets is free.
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
            probe.listen(1)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise ConfigError(
                f"port {port} of {host} is in use: choose another with --port"
            ) from error
        raise ConfigError(f"cannot listen at {host}:{port}: {error.strerror or error}") from error


def page_address(host: str, port: int) -> str:
    """Return the address of the page for a browser on this machine."""
    name = LOOPBACK if host in EVERY_ADDRESS else host
    return f"http://[{name}]:{port}/" if ":" in name else f"http://{name}:{port}/"
