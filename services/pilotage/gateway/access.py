"""Who may do what: exact hosts and origins, tokens and roles.

A hostile web page reaches loopback too. It can aim a name of its own at this machine (DNS
rebinding: then the Host header is wrong) or send requests across origins (then Origin is).
"""

import hmac
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from pydantic import SecretStr

from pilotage.gateway.config import GatewaySettings

Role = Literal["viewer", "operator"]
LOOPBACK_NAMES = ("127.0.0.1", "localhost", "[::1]")
DEFAULT_PORTS = {"http": "80", "https": "443"}


@dataclass(frozen=True)
class Access:
    """The rules of one deployment; `hosts` are the exact `name:port` the gateway answers to."""

    hosts: frozenset[str]
    viewer_tokens: tuple[bytes, ...] = ()
    operator_tokens: tuple[bytes, ...] = ()

    @property
    def is_open(self) -> bool:
        """Whether no tokens are in use: everybody who reaches the gateway is an operator."""
        return not self.viewer_tokens and not self.operator_tokens

    def allows_host(self, host: str | None, scheme: str = "http") -> bool:
        """Say whether a Host header names this gateway."""
        return host is not None and _with_port(host.lower(), scheme) in self.hosts

    def allows_origin(self, origin: str | None) -> bool:
        """Say whether an Origin header is this gateway's own page; programs send none."""
        if origin is None:
            return True
        scheme, separator, host = origin.lower().partition("://")
        if not separator or scheme not in DEFAULT_PORTS:
            return False
        return self.allows_host(host, scheme)

    def role_of(self, token: str | None) -> Role | None:
        """Return what the bearer of `token` may be; None: nobody."""
        if self.is_open:
            return "operator"
        if token is None:
            return None
        offered = token.encode("utf-8", "surrogateescape")
        # Every token is compared, in constant time each, so that timing tells nothing.
        is_operator = _is_any(offered, self.operator_tokens)
        is_viewer = _is_any(offered, self.viewer_tokens)
        return "operator" if is_operator else "viewer" if is_viewer else None


def access_of(settings: GatewaySettings, port: int) -> Access:
    """Return the rules of these settings for a gateway that listens at `port`."""
    named = (f"[{settings.host}]" if ":" in settings.host else settings.host).lower()
    own = {f"{name}:{port}" for name in (*LOOPBACK_NAMES, named)}
    further = {_with_port(host.lower(), "http") for host in settings.allowed_hosts}
    return Access(
        frozenset(own | further),
        tuple(_secrets(settings.viewer_tokens)),
        tuple(_secrets(settings.operator_tokens)),
    )


def _with_port(host: str, scheme: str) -> str:
    has_port = ":" in host.rpartition("]")[2]
    return host if has_port else f"{host}:{DEFAULT_PORTS.get(scheme, '80')}"


def _is_any(offered: bytes, tokens: tuple[bytes, ...]) -> bool:
    matches = [hmac.compare_digest(offered, token) for token in tokens]
    return any(matches)


def _secrets(tokens: Iterable[SecretStr]) -> Iterable[bytes]:
    return (token.get_secret_value().encode() for token in tokens)
