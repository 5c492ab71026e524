"""The files that a command has read, so that no output is written over one of them.

Every reader opens its files within `opening.opened`, which notes them here. Files are known by
device and inode, so that another name of the same file, or a link to it, is recognised.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import NamedTuple

__all__ = ["is_input", "note_input", "noted_inputs"]


class FileId(NamedTuple):
    """A file, whatever it is called."""

    device: int
    inode: int


_INPUTS: ContextVar[set[FileId] | None] = ContextVar("inputs", default=None)


@contextmanager
def noted_inputs() -> Iterator[None]:
    """Note all files that are read within, for `is_input`. Without it nothing is noted."""
    token = _INPUTS.set(set())
    try:
        yield
    finally:
        _INPUTS.reset(token)


def note_input(path: Path) -> None:
    """Note that a file is read. A file that is not there is not noted."""
    inputs = _INPUTS.get()
    found = _id(path)
    if inputs is not None and found is not None:
        inputs.add(found)


def is_input(path: Path) -> bool:
    """Whether a file was read by this command."""
    inputs = _INPUTS.get()
    return bool(inputs) and _id(path) in (inputs or ())


def _id(path: Path) -> FileId | None:
    try:
        found = path.stat()
    except (OSError, ValueError):
        return None
    return FileId(found.st_dev, found.st_ino)
