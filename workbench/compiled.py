"""How kernels are compiled.

The linking compiler (`compiled_linked.py`) takes a half to a sixth of the time that numba's own
takes, and stands on inner classes of numba, which a new release may change. So it is used only with
the versions that it was tested with. With any other, and where something that it stands on is not
there, kernels are compiled by `numba.njit` itself: slower, with the same answers. `why_plain` says
why. WORKBENCH_COMPILER=plain asks for it.
"""

from __future__ import annotations

import hashlib
import logging
import os
import re
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import numba

__all__ = ["batch_loop", "inlined", "inner", "njit", "shared", "why_plain"]

TESTED = (0, 63), (0, 68)
"""The first and the last version of numba that the linking compiler was tested with."""


def njit(*, cache: bool = False, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function as `numba.njit` does; a division by zero gives infinity or NaN.

    Parameters
    ----------
    cache : bool
        Keep the machine code between runs.
    **options
        Options of `numba.njit`.
    """
    options = {"error_model": "numpy", **options}

    def compiled(function: Callable[..., Any]) -> Any:
        if numba.config.DISABLE_JIT:
            return function
        if why_plain():
            return numba.njit(cache=cache and _kept() is not None, **options)(function)
        from workbench.compiled_linked import Kernel

        made = Kernel(function, {}, {"nopython": True, **options})
        if cache:
            del made._cache  # numba's own; the kernel's is made where it is first asked for
        return made

    return compiled


def inner(function: Callable[..., Any]) -> Any:
    """Compile what only compiled code calls: it counts no references, so it makes no arrays."""
    return njit(cache=True, _nrt=False)(function)


def shared(function: Callable[..., Any]) -> Any:
    """Compile as `inner` does, for all entries at once: they call its machine code, and bring none.

    For what is large and called from several entries. Calls cannot be inlined.
    """
    made = inner(function)
    if not numba.config.DISABLE_JIT and not why_plain():
        made.share()
    return made


def inlined(function: Callable[..., Any]) -> Any:
    """Compile as `inner` does, inlined by force: a call would copy the descriptions of arrays."""
    return njit(cache=True, _nrt=False, forceinline=True)(function)


def batch_loop(function: Callable[..., Any]) -> Any:
    """Compile a loop that Python calls in threads; it fills the arrays that it is given."""
    return njit(cache=True, _nrt=False, nogil=True)(function)


@lru_cache(maxsize=1)
def why_plain() -> str:
    """Why kernels are compiled by numba alone; "" where the linking compiler compiles them."""
    if os.environ.get("WORKBENCH_COMPILER") == "plain":
        return "WORKBENCH_COMPILER=plain: kernels are compiled by numba alone"
    version = tuple(int(number) for number in re.findall(r"\d+", numba.__version__)[:2])
    first, last = TESTED
    if not first <= version <= last:
        tested = f"{first[0]}.{first[1]} to {last[0]}.{last[1]}"
        return (
            f"numba {numba.__version__} is none of {tested}, with which the quick compiler was "
            "tested: kernels are compiled by numba alone"
        )
    try:
        import workbench.compiled_linked  # noqa: F401
    except (ImportError, AttributeError, TypeError) as error:
        return f"numba {numba.__version__} lacks what the quick compiler stands on ({error})"
    return ""


@lru_cache(maxsize=1)
def _kept() -> Path | None:
    """Say that numba alone compiles, and choose the folder where it keeps its code; None where no
    folder can be written to.

    It is a folder for this state of all files: numba looks at the file of a function, and not at
    those of what it calls.
    """
    logging.getLogger("workbench").warning("%s; first runs take minutes", why_plain())
    package = Path(__file__).parent
    files = sorted(package.rglob("*.py"))
    states = "\n".join(f"{file} {file.stat().st_mtime_ns} {file.stat().st_size}" for file in files)
    name = f"plain-{hashlib.sha256(states.encode()).hexdigest()[:16]}"
    cache = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser()
    given = os.environ.get("NUMBA_CACHE_DIR")
    for base in [Path(given)] if given else [package / "__pycache__", cache / "workbench"]:
        with suppress(OSError):
            (base / name).mkdir(parents=True, exist_ok=True)
            if os.access(base / name, os.W_OK):
                numba.config.CACHE_DIR = str(base / name)
                return base / name
    return None
