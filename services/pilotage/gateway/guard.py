"""The ASGI door: checks host, origin and token of every request before anything else sees it."""

from urllib.parse import parse_qs

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from pilotage.gateway.access import Access
from pilotage.gateway.problems import problem_response

PUBLIC_PATHS = frozenset({"/", "/healthz", "/readyz", "/favicon.ico"})
PUBLIC_PREFIX = "/static/"
"""Code of the page and the probes of a supervisor; neither tells anything about a robot."""

TOKEN_IN_QUERY = ("/stream", "/events")
"""Browsers cannot set headers on WebSockets and event sources."""

SECURITY_HEADERS = {
    "content-security-policy": (
        "default-src 'self'; img-src 'self' data: blob:; object-src 'none'; base-uri 'none'; "
        "form-action 'none'; frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}


class Guard:
    """Lets in who names this gateway, comes from its page or is a program, and has a token.

    The role that the token gives is put into `scope["state"]["role"]`.
    """

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self.app = app
        self.access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse the connection or pass it on."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if refusal is not None:
            await refusal(scope, receive, _with_headers(send))
            return
        await self.app(scope, receive, _with_headers(send))

    def _refusal(self, scope: Scope) -> Response | None:
        """Return why the request is refused; None lets it in and sets its role."""
        headers, path = Headers(scope=scope), scope["path"]
        if not self.access.allows_host(headers.get("host")):
            detail = "this gateway does not answer to that Host; see its setting allowed_hosts"
            return problem_response(421, detail, path)
        if not self.access.allows_origin(headers.get("origin")) or _is_foreign(headers, path):
            return problem_response(403, "requests from other origins are refused", path)
        role = self.access.role_of(_token(headers, scope))
        if role is None and not _is_public(path):
            challenge = {"www-authenticate": "Bearer"}
            return problem_response(401, "a token is needed", path, challenge)
        scope.setdefault("state", {})["role"] = role
        return None


def _is_foreign(headers: Headers, path: str) -> bool:
    """Say whether a browser asks on behalf of another site's page (images send no Origin)."""
    site = headers.get("sec-fetch-site", "none")
    return site not in ("same-origin", "none") and path not in PUBLIC_PATHS


def _is_public(path: str) -> bool:
    return path in PUBLIC_PATHS or path.startswith(PUBLIC_PREFIX)


def _token(headers: Headers, scope: Scope) -> str | None:
    scheme, _, token = headers.get("authorization", "").partition(" ")
    if scheme.lower() == "bearer":
        return token.strip()
    if scope["path"].endswith(TOKEN_IN_QUERY):
        values = parse_qs(scope["query_string"].decode("latin-1")).get("token")
        return values[0] if values else None
    return None


def _with_headers(send: Send) -> Send:
    async def send_with_headers(message: Message) -> None:
        if message["type"] in ("http.response.start", "websocket.http.response.start"):
            headers = MutableHeaders(scope=message)
            for name, value in SECURITY_HEADERS.items():
                headers[name] = value
            headers.setdefault("cache-control", "no-store")
        await send(message)

    return send_with_headers
