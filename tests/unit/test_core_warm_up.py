import inspect
from importlib import import_module

import pytest

from pilotage.core import warm_up


@pytest.mark.parametrize("entry", warm_up.WARM_UPS)
def test_entry_names_a_function_without_arguments(entry: str) -> None:
    module, function = entry.split(":")
    assert not inspect.signature(getattr(import_module(module), function)).parameters


def test_all_entries_run() -> None:
    warm_up.main()
