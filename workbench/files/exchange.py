"""Exchange the names of two folders in one step, where the system can."""

from __future__ import annotations

import ctypes
import errno
import os
import sys
from pathlib import Path

__all__ = ["exchange"]

_RENAME_EXCHANGE = 2
"""Flag of renameat2 in Linux, and, as RENAME_SWAP, of renamex_np in macOS."""
_AT_FDCWD = -100
_UNSUPPORTED = {errno.ENOSYS, errno.EINVAL, errno.ENOTSUP}


def exchange(first: Path, second: Path) -> bool:
    """Exchange two paths of one file system. False, and nothing is done, where the system cannot
    exchange.

    Raises
    ------
    OSError
        If the system refuses.
    """
    paths = os.fsencode(first), os.fsencode(second)
    try:
        system = ctypes.CDLL(None, use_errno=True)
        if sys.platform == "darwin":
            result = system.renamex_np(paths[0], paths[1], ctypes.c_uint(_RENAME_EXCHANGE))
        else:
            result = system.renameat2(
                _AT_FDCWD, paths[0], _AT_FDCWD, paths[1], ctypes.c_uint(_RENAME_EXCHANGE)
            )
    except (
        AttributeError,
        TypeError,
    ):  # no such function in the system's library; Windows has no library by this name
        return False
    if result == 0:
        return True
    code = ctypes.get_errno()
    if code in _UNSUPPORTED:
        return False
    raise OSError(code, os.strerror(code), str(second))
