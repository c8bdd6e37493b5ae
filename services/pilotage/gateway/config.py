"""Settings of the gateway."""

import ipaddress
from typing import Annotated, Self

from pydantic import Field, SecretStr, model_validator

from pilotage.bus.deployment import Settings

Token = Annotated[SecretStr, Field(min_length=16)]
"""Long enough that guessing over the network is hopeless."""


class GatewaySettings(Settings):
    """Where the gateway listens and who may use it.

    host: address to bind; anything but this machine's own needs tokens.
    port: TCP port.
    allowed_hosts: further exact values of the Host header (`name:port`, or `name` behind a proxy
        at the usual port); loopback and `host` itself are always allowed.
    viewer_tokens: bearers of these may look.
    operator_tokens: bearers of these may also command.
    max_streams: WebSocket and event streams open at once; each holds at most one message per
        topic, so this bounds the memory too.
    """

    host: str = "127.0.0.1"
    port: Annotated[int, Field(ge=0, le=65535)] = 8000
    allowed_hosts: Annotated[tuple[str, ...], Field(strict=False)] = ()
    viewer_tokens: Annotated[tuple[Token, ...], Field(strict=False)] = ()
    operator_tokens: Annotated[tuple[Token, ...], Field(strict=False)] = ()
    max_streams: Annotated[int, Field(gt=0)] = 64

    @property
    def has_tokens(self) -> bool:
        """Whether anybody needs a token."""
        return bool(self.viewer_tokens or self.operator_tokens)

    @model_validator(mode="after")
    def _only_loopback_goes_without_tokens(self) -> Self:
        if not is_loopback(self.host) and not self.operator_tokens:
            raise ValueError(
                f"host {self.host} can be reached from other machines: operator_tokens are needed"
            )
        return self


def is_loopback(host: str) -> bool:
    """Say whether only this machine can reach `host`."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
