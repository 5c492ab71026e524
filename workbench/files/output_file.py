"""Write one file, alone and in one step: a reader finds the old file or the new one, never a part of it.

The content goes into a hidden file beside the output, which then replaces the output by one rename.
A process that is killed leaves this hidden file behind; the next write of the same output uses it
again. What must not be written over is refused, before the work by `check_file` and again when the
file is written: a folder, a link, a device, a file that may not be written, and an input of the
same command.
"""

from __future__ import annotations

import errno
import os
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeVar
from zlib import crc32

from workbench.errors import InputError
from workbench.files.file_errors import is_input, read_whole

__all__ = [
    "Content",
    "bytes_of",
    "check_file",
    "locked",
    "planted",
    "probe",
    "replaced",
    "saving",
    "staged",
    "writable",
    "write_errors",
    "write_file",
]


# A lock file: held by one process at a time, and free again once that process has ended, however
# it ended.

if sys.platform != "win32":
    import fcntl


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


# Save a file that others may save too: one at a time, and only after its new text was read.
#
# Who saves holds a lock file beside the file from before it is looked whether that has changed until
# it is replaced: of two who save at once the second finds the file changed. The new text is written
# under a name of its own, which nobody can have put a link at.

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
