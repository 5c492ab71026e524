"""A lock file: held by one process at a time, and free again once that process has ended, however
it ended."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from workbench.errors import InputError

if sys.platform != "win32":
    import fcntl

__all__ = ["locked"]

_TRIES = 1000
"""How often a lock file is made that another process removes at once."""


@contextmanager
def locked(path: Path, output: Path, *, wait: bool = False) -> Iterator[None]:
    """Hold the lock file `path` for the writing of `output`. The file and its folder are made if
    they are missing.

    Where the system or the file system has no locks (Windows, some network drives), nothing is
    locked.

    Parameters
    ----------
    wait
        Whether to wait for another process that holds it.

    Raises
    ------
    InputError
        If another process holds it, and `wait` is false.
    OSError
        If the file cannot be made, or is a link.
    """
    for _ in range(_TRIES):
        file = _acquired(path, output, wait)
        if file is not None:
            break
    else:
        raise OSError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
    if sys.platform == "win32":  # an open file could not be replaced
        os.close(file)
        yield
        return
    try:
        yield
    finally:
        os.close(file)


def _acquired(path: Path, output: Path, wait: bool) -> int | None:
    """The lock file, opened and locked; None where its last holder has removed it meanwhile."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
    except FileNotFoundError:  # its folder was removed
        return None
    except (
        FileExistsError
    ):  # its folder was there when it was to be made, and was removed before it was looked at
        if os.path.lexists(path.parent) and not path.parent.is_dir():
            raise
        return None
    try:
        _lock(file, output, wait)
        if _is_still(path, file):
            return os.dup(file)
        return None
    finally:
        os.close(file)


def _lock(file: int, output: Path, wait: bool) -> None:
    if sys.platform == "win32":
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        raise InputError(
            f"{output}: cannot be written (another command is writing it now)"
        ) from None
    except OSError:  # a file system without locks
        return


def _is_still(path: Path, file: int) -> bool:
    """Whether an open file is the one that has the name `path` now."""
    with suppress(FileNotFoundError):
        return os.path.samestat(path.lstat(), os.fstat(file))
    return False
