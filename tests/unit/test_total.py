"""The sum of several runs of pytest."""

from pathlib import Path

import pytest

import total


def report(folder: Path, name: str, **counts: int) -> Path:
    attributes = " ".join(f'{key}="{value}"' for key, value in counts.items())
    path = folder / name
    path.write_text(f'<testsuites><testsuite {attributes} time="1.5"/></testsuites>', "utf-8")
    return path


def test_runs_are_added_up(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    reports = [
        report(tmp_path, "a.xml", tests=10, failures=0, errors=0, skipped=2),
        report(tmp_path, "b.xml", tests=5, failures=0, errors=0, skipped=0),
    ]
    assert total.main(reports) == 0
    assert capsys.readouterr().out == "===== 13 passed, 2 skipped in 3.00s =====\n"


@pytest.mark.parametrize("word", ["failures", "errors"])
def test_one_failure_is_the_failure_of_all(tmp_path: Path, word: str) -> None:
    good = report(tmp_path, "a.xml", tests=10)
    assert total.main([good, report(tmp_path, "b.xml", tests=5, **{word: 1})]) == 1


def test_a_run_that_found_no_tests_is_a_failure(tmp_path: Path) -> None:
    assert total.main([report(tmp_path, "a.xml", tests=10), report(tmp_path, "b.xml")]) == 1
    assert total.main([]) == 1
