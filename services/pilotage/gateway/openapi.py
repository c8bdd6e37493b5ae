"""The API's description of itself, completed by what only a running gateway knows."""

from typing import Any

from fastapi import FastAPI

from pilotage.gateway.access import Access


class DescribedApi(FastAPI):
    """A FastAPI application whose description names its robot and asks for tokens."""

    def __init__(self, robot: str, access: Access, **settings: Any) -> None:  # noqa: ANN401 - FastAPI's
        super().__init__(**settings)
        self._robot = robot
        self._access = access

    def openapi(self) -> dict[str, Any]:
        """Return the OpenAPI document."""
        is_first = self.openapi_schema is None
        document = super().openapi()
        if is_first:
            self._name_robot(document)
            if not self._access.is_open:
                self._require_tokens(document)
        return document

    def _name_robot(self, document: dict[str, Any]) -> None:
        for path in document["paths"].values():
            for operation in path.values():
                for parameter in operation.get("parameters", []):
                    if parameter["name"] == "robot_id":
                        parameter["schema"]["enum"] = [self._robot]

    def _require_tokens(self, document: dict[str, Any]) -> None:
        schemes = document.setdefault("components", {}).setdefault("securitySchemes", {})
        schemes["token"] = {"type": "http", "scheme": "bearer"}
        for name, path in document["paths"].items():
            if name.startswith(("/api/", "/metrics")):
                for operation in path.values():
                    operation["security"] = [{"token": []}]
                    operation["responses"] |= {"401": {"description": "Unauthorized"}}
