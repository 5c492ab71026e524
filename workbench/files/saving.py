"""Save a file that others may save too: one at a time, and only after its new text was read.

Who saves holds a lock file beside the file from before it is looked whether that has changed until
it is replaced: of two who save at once the second finds the file changed. The new text is written
under a name of its own, which nobody can have put a link at.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeVar
from zlib import crc32

from workbench.errors import InputError
from workbench.files.opening import read_whole
from workbench.files.output_file import locked, write_errors

__all__ = ["bytes_of", "replaced", "saving"]

WAIT = 10.0
"""Time [s] that is waited for somebody else who saves the same file."""
NEW_MODE = 0o644
"""The rights of a new file."""
Read = TypeVar("Read")


def bytes_of(path: Path) -> bytes | None:
    """Read what a file holds now; None where it is gone, is no regular file or cannot be read."""
    try:
        return read_whole(path, "a file that is saved")
    except InputError:
        return None


@contextmanager
def saving(path: Path) -> Iterator[None]:
    """Hold a file for saving: nobody else who does looks at it or replaces it meanwhile.

    Raises
    ------
    InputError
        If the folder cannot be written, there is something else than a file, or somebody else saves
        it for too long.
    """
    with write_errors(path):
        if os.path.lexists(path) and not path.is_file():
            raise InputError(f"{path}: cannot be written (is no regular file)")
        lock = path.with_name(f"{_hidden(path)}.lock")
        with locked(lock, path, wait=WAIT):
            for left in path.parent.glob(f"{_hidden(path)}-*.yaml"):  # by a process that was killed
                with suppress(OSError):
                    left.unlink()
            try:
                yield
            finally:
                lock.unlink(missing_ok=True)


def replaced(path: Path, data: bytes, read: Callable[[Path], Read]) -> Read:
    """Replace a file that is held for saving by other bytes, in one step.

    Parameters
    ----------
    read
        Is given a file with the bytes, in the same folder; what it raises leaves the file as it was.

    Returns
    -------
    Read
        What `read` returns.

    Raises
    ------
    OSError
        If the folder or the disk has no room.
    """
    descriptor, name = tempfile.mkstemp(".yaml", f"{_hidden(path)}-", path.parent)
    partial = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        found = read(partial)
        partial.chmod(path.stat().st_mode & 0o777 if path.exists() else NEW_MODE)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
    return found


def _hidden(path: Path) -> str:
    """The beginning of hidden names beside a file, of the same length whatever it is called."""
    return f".workbench-saving-{crc32(path.name.encode('utf-8', 'surrogateescape')):08x}"
