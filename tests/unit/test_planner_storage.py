"""What a restarted planner remembers."""

from pathlib import Path

import pytest

from pilotage.planner.storage import FILE, Orders, load_orders, save_orders


@pytest.fixture
def told() -> list[str]:
    """What the planner was warned of."""
    return []


def test_what_was_kept_is_found(tmp_path: Path, told: list[str]) -> None:
    for orders in (Orders(always=True, task="going to (1.00, 2.00)"), Orders(always=False)):
        save_orders(tmp_path, orders, told.append)
        assert load_orders(tmp_path, told.append) == orders
    assert [path.name for path in tmp_path.iterdir()] == [FILE]
    assert told == []


def test_without_a_folder_nothing_is_kept_and_nothing_found(told: list[str]) -> None:
    save_orders(None, Orders(always=True), told.append)
    assert load_orders(None, told.append) is None


def test_a_new_run_remembers_nothing(tmp_path: Path, told: list[str]) -> None:
    assert load_orders(tmp_path, told.append) is None
    assert told == []


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
def test_a_file_written_by_half_is_told_and_ignored(
    tmp_path: Path, told: list[str], share: float
) -> None:
    save_orders(tmp_path, Orders(always=True), told.append)
    whole = (tmp_path / FILE).read_bytes()
    (tmp_path / FILE).write_bytes(whole[: int(share * len(whole))])
    assert load_orders(tmp_path, told.append) is None
    assert told == [f"{FILE} is ignored: it is damaged"]


def test_a_folder_that_is_gone_is_told_and_costs_the_memory_only(
    tmp_path: Path, told: list[str]
) -> None:
    save_orders(tmp_path / "gone", Orders(always=True), told.append)
    assert load_orders(tmp_path / "gone", told.append) is None
    assert len(told) == 1
