"""The one way in which files are opened for reading: regular files only, of a size that is known
before they are read.

A pipe would wait for a writer and a device never ends, so both are refused once they are open and
before any byte is asked for.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import BinaryIO, NamedTuple

from workbench.errors import InputError

__all__ = ["BYTE_ORDER_MARK", "is_input", "note_input", "noted_inputs", "opened", "read_whole"]

BYTE_ORDER_MARK = b"\xef\xbb\xbf"
"""Byte order mark that some editors write at the start of a text file; it is no part of the
text."""
_FLAGS = os.O_RDONLY | sum(
    getattr(os, name, 0) for name in ("O_NONBLOCK", "O_NOCTTY", "O_CLOEXEC", "O_BINARY")
)
"""Flags of `os.open`: without O_NONBLOCK, opening a pipe that nobody writes to never returns."""


@contextmanager
def opened(path: Path, kind: str) -> Iterator[BinaryIO]:
    """Open a regular file as bytes; errors of the system while it is read are reported too.

    The file is noted as an input, so that no output of the same command is written over it (see
    `inputs`).

    Parameters
    ----------
    kind
        What is needed, with its article: "a YAML file".

    Raises
    ------
    InputError
        If the file is missing, is a folder, a pipe or a device, or cannot be read.
    """
    if "\0" in str(path):
        raise InputError(f"{path}: is no name of a file, {kind} is needed")
    note_input(path)
    try:
        descriptor = os.open(path, _FLAGS)
        try:
            _check_regular(path, kind, os.fstat(descriptor).st_mode)
        except InputError:
            os.close(descriptor)
            raise
        with os.fdopen(descriptor, "rb") as file:
            yield file
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, {kind} is needed") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None


def read_whole(path: Path, kind: str, *, most: int | None = None) -> bytes:
    """Read all bytes of a regular file, at most `most` of them.

    Raises
    ------
    InputError
        As `opened`, and if the file is larger than `most`; it is then not read.
    """
    with opened(path, kind) as file:
        size = os.fstat(file.fileno()).st_size
        if most is not None and size > most:
            raise InputError(f"{path}: {size} bytes are too many for {kind} (most: {most})")
        return file.read()


def _check_regular(path: Path, kind: str, mode: int) -> None:
    if stat.S_ISDIR(mode):
        raise InputError(f"{path}: is a folder, {kind} is needed")
    if not stat.S_ISREG(mode):
        raise InputError(f"{path}: is a pipe, a device or a socket, {kind} is needed")


# The files that a command has read, so that no output is written over one of them.
#
# Every reader opens its files within `file_errors.opened`, which notes them here. Files are known by
# device and inode, so that another name of the same file, or a link to it, is recognised.


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
