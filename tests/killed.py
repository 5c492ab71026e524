"""Kill a process just before its n-th step on the disk: what stands there then is what a killed run
leaves.

Python announces every file that is opened, renamed, linked or removed to audit hooks, before it
happens. So nothing of the program is replaced: the process ends itself by SIGKILL at the n-th
announcement that is about a folder.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

EXCHANGE = "ctypes.dlsym"
"""The announcement of the function that exchanges two folders."""
STEPS = {
    "open",
    "os.rename",
    "os.link",
    "os.mkdir",
    "os.rmdir",
    "os.remove",
    "os.chmod",
    "os.utime",
    EXCHANGE,
}
"""Announcements that are counted."""


def killed_before(number: int, folder: Path, work: Callable[[], Any]) -> bool:
    """Do some work in a fork of this process that is killed before its step `number` in a folder,
    counted from 1.

    Returns whether it was killed; it is not where it takes fewer steps.
    """
    child = os.fork()
    if child == 0:
        code = 1
        try:
            kill_before(number, folder)
            work()
            code = 0
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    assert os.WIFSIGNALED(status) or os.WEXITSTATUS(status) == 0
    return os.WIFSIGNALED(status)


def kill_before(number: int, folder: Path, steps: Collection[str] = STEPS) -> None:
    """From now on count the steps of this process in a folder, and kill it before one of them."""
    left = number

    def heard(event: str, arguments: tuple[Any, ...]) -> None:
        nonlocal left
        if event in steps and _is_about(event, arguments, str(folder)):
            left -= 1
            if left == 0:
                os.kill(os.getpid(), signal.SIGKILL)
                time.sleep(60)

    sys.addaudithook(heard)


def _is_about(event: str, arguments: tuple[Any, ...], folder: str) -> bool:
    if event == EXCHANGE:
        return arguments[1] in ("renameat2", "renamex_np")
    if event == "open" and not _writes(arguments):
        return False
    if (
        event in ("os.remove", "os.rmdir") and arguments[1] != -1
    ):  # beside an open folder: a tree that is removed
        return True
    return any(
        isinstance(word, (str, os.PathLike)) and os.fspath(word).startswith(folder)
        for word in arguments
    )


def _writes(arguments: tuple[Any, ...]) -> bool:
    _, _, flags = arguments
    return bool(flags & (os.O_WRONLY | os.O_RDWR))
