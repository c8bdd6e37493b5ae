"""The API's description of itself, completed by what only a running gateway knows."""

from typing import Any

from fastapi import FastAPI

from pilotage.gateway.access import Access
from pilotage.gateway.problems import responses


class DescribedApi(FastAPI):
    """A FastAPI application whose description names its robot and asks for tokens."""

    def __init__(self, robot: str, access: Access, **settings: Any) -> None:  # noqa: ANN401 - FastAPI's
        super().__init__(**settings)
        self._robot = robot
        self._access = access

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document."""
        if self.openapi_schema is None:
            document = super().openapi()
            for name, path in document["paths"].items():
                for operation in path.values():
                    self._complete(name, operation)
            document.pop("components", None)
            if not self._access.is_open:
                schemes = {"token": {"type": "http", "scheme": "bearer"}}
                document["components"] = {"securitySchemes": schemes}
        return super().openapi()

    def _complete(self, path: str, operation: dict[str, Any]) -> None:
        for parameter in operation.get("parameters", []):
            if parameter["name"] == "robot_id":
                parameter["schema"]["enum"] = [self._robot]
        answers = operation["responses"]
        # FastAPI's own error format, which problem documents replace.
        if "application/json" in answers.get("422", {}).get("content", {}):
            del answers["422"]
        if not self._access.is_open and path.startswith(("/api/", "/metrics")):
            operation["security"] = [{"token": []}]
            answers |= {str(status): answer for status, answer in responses(401).items()}
