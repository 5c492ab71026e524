"""The command `workbench`, and `python -m workbench`.

Ctrl-C while the command line is imported ends the process at once, with exit code 130 and one line.
No file is open then.
"""

from __future__ import annotations

import _signal as signal  # type: ignore[import-not-found]  # the module signal takes milliseconds for its names
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType

__all__ = ["main"]

_COLLECTIONS = 100_000, 50, 1_000
"""After how many new objects cyclic garbage is looked for among them, and after how many such
searches among older ones. What a command makes is mostly kept, and what is not is seldom in a
cycle: with Python's own numbers a tenth of a command's time goes into searches that find nothing."""


def main() -> int:
    """Import the command line and run it; returns the exit code."""
    heard = (
        signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )  # not so in the background of a shell
    if heard:
        signal.signal(signal.SIGINT, _stop)
    import gc

    gc.set_threshold(*_COLLECTIONS)
    from workbench.cli import main as run_command

    if heard:
        from workbench.cli.interrupts import heed_interrupts

        heed_interrupts(main.__code__)
    code = run_command()
    if "_duckdb" not in sys.modules:  # it counts its objects that are left, and prints them
        gc.freeze()  # the interpreter would look through all that was imported before it ends
    if heard:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # no traceback from the end of the interpreter
    return code


def _stop(number: int, frame: FrameType | None) -> None:
    os.write(2, b"stopped\n")
    os._exit(130)


if __name__ == "__main__":
    sys.exit(main())
