"""A lock file: held by one process at a time, and free again once that process has ended, however
it ended."""

from __future__ import annotations

import errno
import os
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from workbench.errors import InputError

if sys.platform != "win32":
    import fcntl

__all__ = ["locked", "planted"]

_TRIES = 1000
"""How often a lock file is made that another process removes at once."""
_PAUSE = 0.02
"""Time [s] between two tries to have a lock that another process holds."""


@contextmanager
def locked(path: Path, output: Path, *, wait: float = 0.0) -> Iterator[None]:
    """Hold the lock file `path` for the writing of `output`. The file and its folder are made if
    they are missing. It is free again at the end also where a process was forked meanwhile.

    Where the system or the file system has no locks (Windows, some network drives), nothing is
    locked.

    Parameters
    ----------
    wait
        For how long [s] to wait for another process that holds it.

    Raises
    ------
    InputError
        If another process holds it for longer, or something else than a file of its own has the
        name of the lock file: a link, a pipe, another name of some file.
    OSError
        If the file cannot be made.
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
        with suppress(OSError):  # a file system without locks
            fcntl.flock(file, fcntl.LOCK_UN)  # also what a process forked meanwhile holds of it
        os.close(file)


def _acquired(path: Path, output: Path, wait: float) -> int | None:
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
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise planted(path, output) from None
        raise
    try:
        found = os.fstat(file)
        if not stat.S_ISREG(found.st_mode) or found.st_nlink > 1:
            raise planted(path, output)
        _lock(file, output, wait)
        if _is_still(path, file):
            return os.dup(file)
        return None
    finally:
        os.close(file)


def planted(path: Path, output: Path) -> InputError:
    """Return the error that something else than a file or folder of its own has the hidden name
    `path` beside an output."""
    return InputError(
        f"{output}: cannot be written ({path.name} beside it is a link, or no file of its own; remove it)"
    )


def _lock(file: int, output: Path, wait: float) -> None:
    if sys.platform == "win32":
        return
    end = time.monotonic() + wait
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() < end:
                time.sleep(_PAUSE)
                continue
            raise InputError(
                f"{output}: cannot be written (another command is writing it now)"
            ) from None
        except OSError:  # a file system without locks
            return
        return


def _is_still(path: Path, file: int) -> bool:
    """Whether an open file is the one that has the name `path` now."""
    with suppress(FileNotFoundError):
        return os.path.samestat(path.lstat(), os.fstat(file))
    return False
