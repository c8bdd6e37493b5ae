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
HTTP_PORT = 80
"""Browsers leave it out of Host and Origin."""


@dataclass(frozen=True)
class Access:
    """The rules of one deployment; `hosts` are the exact Host headers the gateway answers to."""

    hosts: frozenset[str]
    viewer_tokens: tuple[bytes, ...] = ()
    operator_tokens: tuple[bytes, ...] = ()

    @property
    def is_open(self) -> bool:
        """Whether no tokens are in use: everybody who reaches the gateway is an operator."""
        return not self.viewer_tokens and not self.operator_tokens

    def allows_host(self, host: str | None) -> bool:
        """Say whether a Host header names this gateway."""
        return host is not None and host.lower() in self.hosts

    def allows_origin(self, origin: str | None) -> bool:
        """Say whether an Origin header is this gateway's own page; programs send none."""
        if origin is None:
            return True
        scheme, _, host = origin.lower().partition("://")
        return scheme in ("http", "https") and host in self.hosts

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
    named = f"[{settings.host}]" if ":" in settings.host else settings.host
    names = (*LOOPBACK_NAMES, named)
    own = {f"{name}:{port}" for name in names}
    if port == HTTP_PORT:
        own |= set(names)
    return Access(
        frozenset(host.lower() for host in (*own, *settings.allowed_hosts)),
        tuple(_secrets(settings.viewer_tokens)),
        tuple(_secrets(settings.operator_tokens)),
    )


def _is_any(offered: bytes, tokens: tuple[bytes, ...]) -> bool:
    matches = [hmac.compare_digest(offered, token) for token in tokens]
    return any(matches)


def _secrets(tokens: Iterable[SecretStr]) -> Iterable[bytes]:
    return (token.get_secret_value().encode() for token in tokens)
