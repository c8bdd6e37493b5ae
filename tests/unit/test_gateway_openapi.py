"""The API's description of itself."""

import json
from typing import Any

import jsonschema_rs
import pytest

from gateway_world import ROBOT, GatewayWorld
from pilotage.gateway.routes.commands import COMMANDS

PATH = "/api/v1/robots/{robot_id}"


def described(**settings: object) -> dict[str, Any]:
    with GatewayWorld(**settings) as world:
        headers = {"authorization": "Bearer operator-token-0123"}
        document: dict[str, Any] = world.client.get("/api/v1/openapi.json", headers=headers).json()
        return document


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    return described()


def operations(document: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    return [
        (path, operation)
        for path, methods in document["paths"].items()
        for operation in methods.values()
    ]


def test_every_operation_has_a_summary_and_a_subject(document: dict[str, Any]) -> None:
    for path, operation in operations(document):
        assert operation["summary"], path
        assert operation["tags"], path


def test_every_error_is_a_problem_document(document: dict[str, Any]) -> None:
    for path, operation in operations(document):
        for status, answer in operation["responses"].items():
            if int(status) >= 400:
                assert list(answer["content"]) == ["application/problem+json"], (path, status)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_is_described_with_an_example(document: dict[str, Any], name: str) -> None:
    operation = document["paths"][f"{PATH}/commands/{name}"]["post"]
    body = operation["requestBody"]["content"]["application/json"]
    jsonschema_rs.validator_for(body["schema"]).validate(body["example"])
    reply = operation["responses"]["200"]["content"]["application/json"]
    jsonschema_rs.validator_for(reply["schema"]).validate(reply["example"])
    assert {"404", "409", "413", "422", "503", "504"} <= set(operation["responses"])


def test_all_other_examples_fit_their_schemas_too(document: dict[str, Any]) -> None:
    for path, operation in operations(document):
        for answer in operation["responses"].values():
            for kind, content in answer.get("content", {}).items():
                if kind == "application/json" and "example" in content:
                    validator = jsonschema_rs.validator_for(content["schema"])
                    assert validator.is_valid(content["example"]), path


def test_the_robot_is_named(document: dict[str, Any]) -> None:
    (parameter,) = document["paths"][f"{PATH}/pose"]["get"]["parameters"]
    assert parameter["schema"]["enum"] == ["demo"]
    assert ROBOT.endswith("demo")


def test_tokens_are_asked_for_only_where_they_are_needed(document: dict[str, Any]) -> None:
    assert "security" not in document["paths"][f"{PATH}/pose"]["get"]
    guarded = described(operator_tokens=("operator-token-0123",))
    operation = guarded["paths"][f"{PATH}/pose"]["get"]
    assert operation["security"] == [{"token": []}]
    assert "401" in operation["responses"]
    assert "security" not in guarded["paths"]["/healthz"]["get"]


def test_the_description_stands_alone(document: dict[str, Any]) -> None:
    assert "$ref" not in json.dumps(document)
