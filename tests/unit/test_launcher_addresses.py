"""Addresses: what is free, what answers, what a browser is told."""

import socket

import pytest

from pilotage.launcher.addresses import (
    free_endpoint,
    is_accepting,
    page_address,
    require_free_port,
)


def test_a_free_endpoint_is_one_nobody_answers_at() -> None:
    endpoint = free_endpoint()
    assert endpoint.startswith("tcp/127.0.0.1:")
    assert not is_accepting(endpoint)


def test_an_endpoint_with_a_listener_accepts() -> None:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(1)
        assert is_accepting(f"tcp/127.0.0.1:{listener.getsockname()[1]}")


@pytest.mark.parametrize(
    "endpoint", ["", "tcp/", "tcp/127.0.0.1", "udp/127.0.0.1:1", "tcp/127.0.0.1:x"]
)
def test_what_is_no_tcp_endpoint_does_not_accept(endpoint: str) -> None:
    assert not is_accepting(endpoint)


def test_a_port_left_a_moment_ago_is_free() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        with socket.create_connection(("127.0.0.1", port)):
            listener.accept()[0].close()
    require_free_port("127.0.0.1", port)


@pytest.mark.parametrize(
    ("host", "address"),
    [
        ("127.0.0.1", "http://127.0.0.1:80/"),
        ("0.0.0.0", "http://127.0.0.1:80/"),  # noqa: S104 - only named, never bound
        ("::1", "http://[::1]:80/"),
        ("localhost", "http://localhost:80/"),
    ],
)
def test_the_page_has_an_address_for_people(host: str, address: str) -> None:
    assert page_address(host, 80) == address
