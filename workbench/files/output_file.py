"""Write one file, in one step: a reader finds the old file or the new one, never a part of it.

The content goes into a hidden file beside the output, which then replaces the output by one rename.
A process that is killed leaves this hidden file behind; the next write of the same output uses it
again. What must not be written over is refused, before the work by `check_file` and again when the
file is written: a folder, a link, a device, a file that may not be written, and an input of the
same command.
"""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from workbench.errors import InputError
from workbench.files.lock import locked
from workbench.files.opening import is_input

__all__ = ["Content", "check_file", "probe", "staged", "writable", "write_errors", "write_file"]

Content = str | bytes | Iterable[str]
"""What a file holds: a text, bytes, or a text in parts that are made as they are written."""
_PROBE = ".workbench-probe-"


def check_file(path: Path) -> None:
    """Check, before any work, that a file can be written. Nothing is left on the disk.

    Raises
    ------
    InputError
        If the output is a folder, a link, a device, not writable or an input of this command, or if
        its folder cannot be made or written to.
    """
    with write_errors(path):
        _refuse(path)
        with suppress(FileNotFoundError):
            _partial(path).lstat()  # the longest name that is needed
        probe(path.parent)


@contextmanager
def staged(path: Path) -> Iterator[Path]:
    """Yield the path of a hidden file to write. On leaving, it replaces `path`; after an error it
    is removed.

    Raises
    ------
    InputError
        See `check_file`; or if the disk is full, or another command writes the same file.
    """
    with write_errors(path):
        _refuse(path)
        if not path.parent.is_dir():
            raise InputError(f"{path}: there is no folder {path.parent}; make it first")
        partial = _partial(path)
        with locked(partial, path):
            complete = False
            try:
                yield partial
                _refuse(path)  # it may have become something else during the work
                partial.replace(path)
                complete = True
            finally:
                if not complete:
                    partial.unlink(missing_ok=True)


def write_file(path: Path, content: Content) -> None:
    """Write one file that appears at once or not at all. InputError as of `staged`."""
    with staged(path) as partial, partial.open("wb") as file:
        for part in [content] if isinstance(content, (str, bytes)) else content:
            file.write(part.encode() if isinstance(part, str) else part)


@contextmanager
def write_errors(path: Path) -> Iterator[None]:
    """Turn the system's errors within into an InputError that names the output."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from None


def probe(folder: Path) -> None:
    """Try whether something can be made in a folder, or in its nearest ancestor that is there.
    OSError if not.

    To try is the only sure way: rights, read-only disks and quotas all count.
    """
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    for left in folder.glob(f"{_PROBE}*"):  # of a process that was killed
        with suppress(OSError):
            left.rmdir()
    made = Path(tempfile.mkdtemp(prefix=_PROBE, dir=folder))
    with suppress(FileNotFoundError):  # another command has removed it as one that was left
        made.rmdir()


def writable(path: Path) -> bool:
    """Whether the rights of a file or folder let this process write to it."""
    return os.access(path, os.W_OK, effective_ids=os.access in os.supports_effective_ids)


def _refuse(path: Path) -> None:
    """InputError where `path` names something that must not be replaced by a file."""
    if path.name in ("", "..") or path.is_dir():
        raise InputError(f"{path}: cannot be written (is a folder; name the file to write)")
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return
    if stat.S_ISLNK(mode):
        target = path.readlink()
        raise InputError(f"{path}: cannot be written (is a link to {target}; name the file itself)")
    if not stat.S_ISREG(mode):
        raise InputError(f"{path}: cannot be written (is no regular file)")
    if is_input(path):
        raise InputError(
            f"{path}: cannot be written (is an input of this command; name another file)"
        )
    if not writable(path):
        raise InputError(f"{path}: cannot be written (is read-only)")


def _partial(path: Path) -> Path:
    return path.with_name(f".{path.name}.workbench-partial")
