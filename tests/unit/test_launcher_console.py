"""What people see of a run."""

import io
import sys
import webbrowser

import pytest

from pilotage.launcher import browser
from pilotage.launcher.console import Console


def test_an_event_is_one_line_that_begins_with_its_process() -> None:
    events = io.StringIO()
    Console(events, io.StringIO()).event("robot", "ready after 0.4 s")
    assert events.getvalue() == "robot      ready after 0.4 s\n"


def test_the_output_of_services_goes_beside_the_events() -> None:
    events, output = io.StringIO(), io.StringIO()
    Console(events, output).output("robot", "hello")
    assert events.getvalue() == ""
    assert output.getvalue() == "robot      | hello\n"


def test_a_reader_that_has_gone_away_disturbs_nothing() -> None:
    gone = io.StringIO()
    gone.close()
    Console(gone, gone).say("nobody hears this")


def test_without_a_screen_no_browser_is_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(webbrowser, "open", lambda _address: pytest.fail("opened"))
    browser.open_page("http://127.0.0.1:8000/")
    assert not browser.has_screen()


def test_with_a_screen_there_is_a_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert browser.has_screen()


def test_a_browser_that_fails_fails_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_address: str) -> bool:
        raise webbrowser.Error("no browser")

    monkeypatch.setattr(webbrowser, "open", refuse)
    browser._open("http://127.0.0.1:8000/")
