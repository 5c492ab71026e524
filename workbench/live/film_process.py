"""A film written by a process of its own, behind all others: answers of the bench go first.

The process says after each frame how far it is. Where nobody listens any more it ends, and leaves no
file.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

from workbench.errors import InputError, WorkbenchError
from workbench.live.filming import Take

__all__ = ["write_apart"]

NICE = 5
"""By how much it stands back behind other processes, where the system knows that."""


def write_apart(take: Take, path: Path, progress: Callable[[int, int], None]) -> int:
    """Write a film in another process.

    Parameters
    ----------
    progress
        Called with the number of frames that are done, and of all; what it raises ends the film.

    Returns
    -------
    int
        The number of frames.

    Raises
    ------
    InputError
        If the film cannot be made.
    """
    own, theirs = get_context("spawn").Pipe(duplex=False)
    process = get_context("spawn").Process(
        target=_write, args=(take, path, theirs), daemon=True, name="film"
    )
    process.start()
    theirs.close()
    frames = 0
    try:
        while True:
            said = own.recv()
            if isinstance(said, str):
                raise InputError(said)
            if said is None:
                return frames
            frames, count = said
            progress(frames, count)
    except EOFError:
        raise InputError("the film could not be made: its process has ended") from None
    finally:
        own.close()
        process.join()


def _write(take: Take, path: Path, told: Connection) -> None:
    """Write a film, and tell how far it is; None at its end, or why it cannot be made."""
    if hasattr(os, "nice"):
        os.nice(NICE)
    with suppress(OSError, KeyboardInterrupt):  # nobody listens any more
        try:
            take.write(path, lambda done, count: told.send((done, count)))
            told.send(None)
        except WorkbenchError as error:
            told.send(str(error))
