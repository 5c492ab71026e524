"""Ctrl-C while a command runs: a KeyboardInterrupt that no library swallows.

It waits for the end of an import: some libraries catch it in theirs, and some in C++ end the process.
Where compiled code drops it, it comes again. Where compiled code makes another error of it, `heard`
says what that error is about.
"""

from __future__ import annotations

import _thread
import signal
import sys
import time
from types import CodeType, FrameType

__all__ = ["heard", "heed_interrupts"]

_IMPORTING = "<frozen importlib._bootstrap>"
_PATIENCE = 0.02
"""After how long [s] Ctrl-C comes again."""
_heard = False


def heard() -> bool:
    """Whether a command has been stopped by Ctrl-C."""
    return _heard


def heed_interrupts(outermost: CodeType) -> None:
    """Take Ctrl-C from now on.

    Parameters
    ----------
    outermost
        Of the function that runs the command: what calls it may be an import itself.
    """

    def interrupt(number: int, frame: FrameType | None) -> None:
        global _heard
        while frame is not None and frame.f_code is not outermost:
            if frame.f_code.co_filename == _IMPORTING:
                _come_again()
                return
            frame = frame.f_back
        _heard = True
        raise KeyboardInterrupt

    def unraisable(lost: sys.UnraisableHookArgs) -> None:
        if lost.exc_type is KeyboardInterrupt:
            _come_again()
        else:
            sys.__unraisablehook__(lost)

    signal.signal(signal.SIGINT, interrupt)
    sys.unraisablehook = unraisable


def _come_again() -> None:
    """Call for the handler of Ctrl-C once more, from beside the main thread."""
    _thread.start_new_thread(_interrupt_later, ())


def _interrupt_later() -> None:
    time.sleep(_PATIENCE)
    _thread.interrupt_main()
