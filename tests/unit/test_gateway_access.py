"""Who may reach the gateway, and with which role."""

import pytest
from pydantic import SecretStr

from pilotage.bus.deployment import ConfigError, Deployment, service_settings
from pilotage.gateway.access import Access, access_of
from pilotage.gateway.config import GatewaySettings, is_loopback

VIEWER, OPERATOR = "v" * 16, "o" * 16


def access(**settings: object) -> Access:
    return access_of(GatewaySettings.model_validate(settings), 8000)


@pytest.mark.parametrize(
    "host", ["127.0.0.1:8000", "localhost:8000", "[::1]:8000", "LOCALHOST:8000"]
)
def test_loopback_names_with_the_port_are_the_gateway(host: str) -> None:
    assert access().allows_host(host)


@pytest.mark.parametrize(
    "host",
    [
        None,
        "",
        "127.0.0.1",
        "127.0.0.1:8001",
        "evil.example:8000",
        "localhost.evil.example:8000",
        "localhost:8000.evil.example",
        "localhost:8000@evil.example",
        "localhost:8000 ",
        "127.0.0.1:8000,evil.example",
        "0.0.0.0:8000",
    ],
)
def test_any_other_host_is_not(host: str | None) -> None:
    assert not access().allows_host(host)


def test_the_usual_port_is_left_out_of_the_host() -> None:
    assert access_of(GatewaySettings(), 80).allows_host("localhost")


def test_further_hosts_are_taken_exactly() -> None:
    rules = access(allowed_hosts=["robot.example", "Lab-02:8000"])
    assert rules.allows_host("robot.example")
    assert rules.allows_host("lab-02:8000")
    assert not rules.allows_host("robot.example:8000")


def test_the_bound_address_is_a_host() -> None:
    rules = access(host="192.0.2.7", operator_tokens=[OPERATOR])
    assert rules.allows_host("192.0.2.7:8000")
    rules = access(host="2001:db8::7", operator_tokens=[OPERATOR])
    assert rules.allows_host("[2001:db8::7]:8000")


@pytest.mark.parametrize("origin", [None, "http://127.0.0.1:8000", "http://localhost:8000"])
def test_programs_and_the_own_page_have_a_good_origin(origin: str | None) -> None:
    assert access().allows_origin(origin)


@pytest.mark.parametrize(
    "origin",
    [
        "null",
        "",
        "http://evil.example",
        "http://127.0.0.1:8001",
        "http://127.0.0.1",
        "file://",
        "127.0.0.1:8000",
        "ftp://127.0.0.1:8000",
        "http://127.0.0.1:8000/",
        "http://127.0.0.1:8000.evil.example",
        "http://evil.example@127.0.0.1:8000",
    ],
)
def test_other_origins_are_foreign(origin: str) -> None:
    assert not access().allows_origin(origin)


def test_without_tokens_everybody_is_an_operator() -> None:
    assert access().role_of(None) == "operator"
    assert access().role_of("anything") == "operator"


def test_tokens_give_roles() -> None:
    rules = access(viewer_tokens=[VIEWER, "w" * 16], operator_tokens=[OPERATOR])
    assert rules.role_of(VIEWER) == "viewer"
    assert rules.role_of("w" * 16) == "viewer"
    assert rules.role_of(OPERATOR) == "operator"


@pytest.mark.parametrize("token", [None, "", VIEWER[:-1], VIEWER + "v", "é" * 16, "\udcff" * 16])
def test_any_other_token_gives_none(token: str | None) -> None:
    assert access(viewer_tokens=[VIEWER], operator_tokens=[OPERATOR]).role_of(token) is None


def test_tokens_do_not_show_in_prints() -> None:
    settings = GatewaySettings(operator_tokens=(SecretStr(OPERATOR),))
    assert OPERATOR not in repr(settings)
    assert OPERATOR not in settings.model_dump_json()


@pytest.mark.parametrize("host", ["127.0.0.1", "127.1.2.3", "::1", "localhost"])
def test_loopback_needs_no_tokens(host: str) -> None:
    assert is_loopback(host)
    assert GatewaySettings(host=host).host == host


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.7", "robot.example", ""])  # noqa: S104 - refused
def test_any_other_address_is_refused_without_tokens(host: str) -> None:
    deployment = Deployment(services={"gateway": {"host": host}})
    with pytest.raises(ConfigError, match="operator_tokens are needed"):
        service_settings(deployment, "gateway", GatewaySettings)


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"port": 65536}, "port"),
        ({"port": "http"}, "port"),
        ({"operator_tokens": ["short"]}, "at least 16"),
        ({"max_streams": 0}, "max_streams"),
        ({"color": "blue"}, "color"),
    ],
)
def test_wrong_settings_are_refused_in_one_line(settings: dict[str, object], reason: str) -> None:
    deployment = Deployment(services={"gateway": settings})
    with pytest.raises(ConfigError, match=reason) as refusal:
        service_settings(deployment, "gateway", GatewaySettings)
    assert "\n" not in str(refusal.value)
    assert "short" not in str(refusal.value).replace("should have", "")
