"""How functions are compiled that only compiled code calls.

Numba makes two more entries for each function, for Python and for C. Where a function takes bundles
of a hundred arrays these are most of what is compiled: without them it takes a third of the time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from workbench.compiled import njit

__all__ = ["inlined", "inner"]


def inner(function: Callable[..., Any]) -> Any:
    """Compile without entries from outside, and without the run time that counts references."""
    return njit(
        cache=True, error_model="numpy", _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True
    )(function)


def inlined(function: Callable[..., Any]) -> Any:
    """The same, inlined by force: a call would copy the descriptions of all its arrays."""
    return njit(
        cache=True,
        error_model="numpy",
        _nrt=False,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
        forceinline=True,
    )(function)
