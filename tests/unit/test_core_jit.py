import numba
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


def test_kernel_works_where_machine_code_cannot_be_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    compiled = numba.njit

    def njit(*, cache: bool = False, nogil: bool, fastmath: bool) -> object:
        if cache:
            raise RuntimeError("no locator available")
        return compiled(nogil=nogil, fastmath=fastmath)

    monkeypatch.setattr(numba, "njit", njit)
    assert kernel(add_up.py_func)(np.array([1.0, 2.5])) == pytest.approx(3.5)  # type: ignore[attr-defined]  # numba's dispatcher has it
