"""The tests. Read before everything else: where kernels are compiled to has to be said before they
are imported."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path


def own_compiled_code(worker: str) -> None:
    """Give a worker of pytest-xdist a folder of its own for compiled kernels.

    Two processes that compile one function for two signatures at once may each write the other's
    machine code under its own name: numba's index and its data files are replaced one by one, not
    together.
    """
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base is None:
        base = tempfile.mkdtemp(prefix="workbench-kernels-")
        atexit.register(shutil.rmtree, base, ignore_errors=True)
    os.environ["NUMBA_CACHE_DIR"] = str(Path(base) / worker)


if "PYTEST_XDIST_WORKER" in os.environ:
    own_compiled_code(os.environ["PYTEST_XDIST_WORKER"])
