"""Whole runs that must not begin: one clear line and exit code 2, whatever is wrong."""

import socket
from pathlib import Path

import pytest

from runs import Run

pytestmark = pytest.mark.system

MAP = "image: floor.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
MAP += "occupied_thresh: 0.65\nfree_thresh: 0.196\n"


def refusal(folder: Path, text: str, *options: str) -> str:
    """Return the last line of a run that ends with code 2."""
    path = folder / "deployment.yaml"
    path.write_text(text, encoding="utf-8")
    with Run("pilotage", ["up", str(path), "--no-browser", *options], folder) as run:
        assert run.ended(within=60.0) == 2, run.text
    assert "Traceback" not in run.text
    return run.lines[-1]


def test_a_missing_deployment(tmp_path: Path) -> None:
    with Run("pilotage", ["up", str(tmp_path / "none.yaml")], tmp_path) as run:
        assert run.ended() == 2
    assert run.lines == [
        f"pilotage: {tmp_path / 'none.yaml'}: cannot be read: No such file or directory"
    ]


def test_unreadable_yaml(tmp_path: Path) -> None:
    assert "not valid YAML" in refusal(tmp_path, "services: {mapper: ")


def test_an_unknown_key(tmp_path: Path) -> None:
    assert "settings of mapper: mapp" in refusal(tmp_path, "services: {mapper: {mapp: x}}")


def test_a_missing_map(tmp_path: Path) -> None:
    said = refusal(tmp_path, "services: {mapper: {map: none.yaml}}")
    assert f"no such file: {tmp_path / 'none.yaml'}" in said


def test_a_map_of_the_wrong_size(tmp_path: Path) -> None:
    (tmp_path / "floor.yaml").write_text(MAP, encoding="utf-8")
    (tmp_path / "floor.pgm").write_bytes(b"P5\n40 30\n255\n" + bytes(100))
    said = refusal(tmp_path, "services: {mapper: {map: floor.yaml}}")
    assert said.startswith("pilotage up: mapper ended with code 2: ")
    assert "floor.pgm" in said


def test_a_map_that_is_no_map(tmp_path: Path) -> None:
    (tmp_path / "floor.yaml").write_text("just: text\n", encoding="utf-8")
    said = refusal(tmp_path, "services: {mapper: {map: floor.yaml}}")
    assert "floor.yaml" in said


def test_a_port_in_use(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = str(other.getsockname()[1])
        said = refusal(tmp_path, "services: {gateway: }", "--port", port)
    assert f"port {port} of 127.0.0.1 is in use" in said


def test_a_page_for_everyone_without_tokens(tmp_path: Path) -> None:
    said = refusal(tmp_path, "services: {gateway: {host: 0.0.0.0}}")
    assert "operator_tokens are needed" in said
