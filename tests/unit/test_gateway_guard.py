"""What hostile pages and strangers get from the gateway."""

from collections.abc import Iterator

import pytest

from gateway_world import HOST, ROBOT, GatewayWorld, WebSocketDenialResponse, pose_estimate

VIEWER, OPERATOR = "viewer-token-0123456789", "operator-token-0123456789"


@pytest.fixture
def world() -> Iterator[GatewayWorld]:
    with GatewayWorld() as world:
        yield world


@pytest.fixture
def guarded() -> Iterator[GatewayWorld]:
    with GatewayWorld(viewer_tokens=(VIEWER,), operator_tokens=(OPERATOR,)) as world:
        world.publish("localizer", "pose", pose_estimate(world.now_ns))
        yield world


def bearer(token: str) -> dict[str, str]:
    return {"authorization": f"Bearer {token}"}


def test_a_rebound_name_is_misdirected(world: GatewayWorld) -> None:
    answer = world.client.get("/healthz", headers={"host": "evil.example:8000"})
    assert answer.status_code == 421
    assert answer.headers["content-type"] == "application/problem+json"
    assert "allowed_hosts" in answer.json()["detail"]


def test_a_request_across_origins_is_forbidden(world: GatewayWorld) -> None:
    headers = {"origin": "http://evil.example"}
    assert world.client.post(f"{ROBOT}/commands/stop", headers=headers).status_code == 403
    assert world.client.get(f"{ROBOT}/pose", headers=headers).status_code == 403


def test_a_picture_on_a_foreign_page_is_forbidden(world: GatewayWorld) -> None:
    headers = {"sec-fetch-site": "cross-site"}
    assert world.client.get(f"{ROBOT}/events", headers=headers).status_code == 403


def test_the_page_may_be_linked_to(world: GatewayWorld) -> None:
    headers = {"sec-fetch-site": "cross-site"}
    assert world.client.get("/healthz", headers=headers).status_code == 200


def test_the_own_page_is_let_in(world: GatewayWorld) -> None:
    headers = {"origin": f"http://{HOST}", "sec-fetch-site": "same-origin"}
    assert world.client.get("/api/v1/robots", headers=headers).status_code == 200


def test_a_websocket_across_origins_is_refused_before_it_opens(world: GatewayWorld) -> None:
    with (
        pytest.raises(WebSocketDenialResponse) as denial,
        world.stream(headers={"origin": "http://evil.example"}),
    ):
        pass
    assert denial.value.status_code == 403


def test_a_websocket_to_a_rebound_name_is_refused(world: GatewayWorld) -> None:
    with (
        pytest.raises(WebSocketDenialResponse) as denial,
        world.stream(headers={"host": "evil.example"}),
    ):
        pass
    assert denial.value.status_code == 421


@pytest.mark.parametrize("path", ["/", "/healthz", "/nowhere", f"{ROBOT}/pose", "/metrics"])
def test_every_answer_forbids_foreign_code(world: GatewayWorld, path: str) -> None:
    headers = world.client.get(path).headers
    assert headers["content-security-policy"].startswith("default-src 'self'")
    assert "unsafe-inline" not in headers["content-security-policy"]
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"


def test_live_data_are_not_stored(world: GatewayWorld) -> None:
    assert world.client.get(f"{ROBOT}/pose").headers["cache-control"] == "no-store"


def test_a_body_beyond_the_limit_is_too_large(world: GatewayWorld) -> None:
    answer = world.client.post(f"{ROBOT}/commands/stop", content=b" " * (64 * 1024 + 1))
    assert answer.status_code == 413
    assert answer.json()["status"] == 413


@pytest.mark.parametrize(
    "path",
    [
        "/static/../config.py",
        "/static/%2e%2e/config.py",
        "/static/..%2fconfig.py",
        "/static//etc/passwd",
        "/static/%2fetc%2fpasswd",
        "/static/....//config.py",
    ],
)
def test_static_files_end_at_their_folder(world: GatewayWorld, path: str) -> None:
    assert world.client.get(path).status_code == 404


def test_strangers_get_nothing_of_the_robot(guarded: GatewayWorld) -> None:
    for path in ("/api/v1/robots", f"{ROBOT}/pose", "/metrics", "/api/v1/openapi.json"):
        answer = guarded.client.get(path)
        assert answer.status_code == 401
        assert answer.headers["www-authenticate"] == "Bearer"


def test_probes_and_the_page_need_no_token(guarded: GatewayWorld) -> None:
    assert guarded.client.get("/healthz").status_code == 200
    assert guarded.client.get("/readyz").status_code == 503
    assert guarded.client.get("/static/none.js").status_code == 404


def test_a_viewer_may_look_but_not_command(guarded: GatewayWorld) -> None:
    assert guarded.client.get(f"{ROBOT}/pose", headers=bearer(VIEWER)).status_code == 200
    answer = guarded.client.post(f"{ROBOT}/commands/restart", headers=bearer(VIEWER))
    assert answer.status_code == 403


def test_an_operator_may_command(guarded: GatewayWorld) -> None:
    answer = guarded.client.post(f"{ROBOT}/commands/stop", headers=bearer(OPERATOR))
    assert answer.status_code == 503  # nobody is there to stop


def test_a_wrong_token_is_no_token(guarded: GatewayWorld) -> None:
    assert guarded.client.get(f"{ROBOT}/pose", headers=bearer(VIEWER[:-1])).status_code == 401
    basic = {"authorization": f"Basic {VIEWER}"}
    assert guarded.client.get(f"{ROBOT}/pose", headers=basic).status_code == 401


def test_a_token_in_the_address_opens_streams_and_nothing_else(guarded: GatewayWorld) -> None:
    with guarded.stream(f"?token={VIEWER}") as stream:
        assert stream.receive_bytes()
    assert guarded.client.get(f"{ROBOT}/pose?token={VIEWER}").status_code == 401
    with pytest.raises(WebSocketDenialResponse) as denial, guarded.stream("?token=guess"):
        pass
    assert denial.value.status_code == 401
