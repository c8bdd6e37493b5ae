"""Errors as problem documents (RFC 9457)."""

import http
import json
from collections.abc import Mapping
from typing import Any
from urllib.parse import quote

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import Response

MEDIA_TYPE = "application/problem+json"

KINDS = {
    400: "bad-request",
    401: "unauthorized",
    403: "forbidden",
    404: "not-found",
    405: "method-not-allowed",
    409: "refused",
    413: "too-large",
    421: "wrong-host",
    422: "invalid",
    429: "too-many",
    500: "fault",
    502: "bad-answer",
    503: "unavailable",
    504: "no-answer",
}

SCHEMA: dict[str, Any] = {
    "type": "object",
    "required": ["type", "title", "status", "detail", "instance"],
    "properties": {
        "type": {"type": "string", "format": "uri-reference"},
        "title": {"type": "string"},
        "status": {"type": "integer"},
        "detail": {"type": "string"},
        "instance": {"type": "string", "format": "uri-reference"},
    },
}


class ProblemError(Exception):
    """What went wrong with a request: an HTTP status and a sentence for people."""

    def __init__(self, status: int, detail: str) -> None:
        super().__init__(detail)
        self.status = status
        self.detail = detail


def problem_response(
    status: int, detail: str, path: str, headers: Mapping[str, str] | None = None
) -> Response:
    """Return the problem document of a failed request for `path`."""
    document = {
        "type": f"urn:pilotage:problem:{KINDS.get(status, 'other')}",
        "title": http.HTTPStatus(status).phrase,
        "status": status,
        "detail": detail,
        "instance": quote(path),
    }
    # Nothing a client sent may end up as a lone surrogate, which is not JSON.
    body = json.dumps(document).encode("ascii")
    return Response(body, status, headers, MEDIA_TYPE)


def responses(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI description of these error responses."""
    return {
        status: {
            "description": http.HTTPStatus(status).phrase,
            "content": {MEDIA_TYPE: {"schema": SCHEMA}},
        }
        for status in statuses
    }


def add_problem_handlers(app: FastAPI) -> None:
    """Let every error of `app` be answered with a problem document."""
    app.add_exception_handler(ProblemError, _on_problem)
    app.add_exception_handler(HTTPException, _on_http_error)
    app.add_exception_handler(RequestValidationError, _on_invalid)
    app.add_exception_handler(Exception, _on_fault)


def _on_problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, ProblemError)  # noqa: S101 - registered for this class only
    return problem_response(error.status, error.detail, request.url.path)


def _on_http_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)  # noqa: S101 - registered for this class only
    return problem_response(error.status_code, error.detail, request.url.path, error.headers)


def _on_invalid(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)  # noqa: S101 - registered for this class only
    first = error.errors()[0]
    place = ".".join(str(part) for part in first["loc"])
    return problem_response(422, f"{place}: {first['msg']}", request.url.path)


def _on_fault(request: Request, _error: Exception) -> Response:
    return problem_response(500, "the gateway failed; its log says why", request.url.path)
