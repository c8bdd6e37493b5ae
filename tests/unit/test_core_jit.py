import numpy as np
import pytest

from pilotage.core.jit import kernel


@kernel
def add_up(values: np.ndarray) -> float:
    total = 0.0
    for value in values:
        total += value
    return total


def test_kernel_computes_what_its_python_says() -> None:
    assert add_up(np.array([1.0, 2.5])) == pytest.approx(3.5)


def test_kernel_keeps_its_name_and_documentation() -> None:
    assert add_up.__name__ == "add_up"
