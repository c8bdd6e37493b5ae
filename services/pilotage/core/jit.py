"""The one place that says how kernels are compiled."""

from collections.abc import Callable
from typing import TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., object])


def kernel(function: Function) -> Function:
    """Compile a function of arrays and numbers with numba, keeping its Python type.

    Machine code is cached on disk, so only the first start after a change compiles; the
    interpreter lock is released, so a kernel never holds up the thread that feeds the bus.
    """
    return _compiled(function)


def reduction(function: Function) -> Function:
    """Compile a kernel that sums or compares along a row, the order of its terms being free.

    Only so may the compiler take many terms at a time; NaN and the sign of zero are given up
    (a belief has neither).
    """
    relaxed = {"reassoc", "nnan", "nsz"}
    return _compiled(function, relaxed)


def _compiled(function: Function, relaxed: set[str] | None = None) -> Function:
    fastmath = relaxed or False
    try:
        return cast("Function", numba.njit(cache=True, nogil=True, fastmath=fastmath)(function))
    except RuntimeError:
        # Installed read-only, and no home to write to: every start compiles.
        return cast("Function", numba.njit(nogil=True, fastmath=fastmath)(function))
