"""Write a folder of results in one step, and keep whatever else its user keeps in it.

A folder that was written lists its own files in `manifest.json`, with their SHA-256. When the
folder is written again, the files that the manifest lists are replaced or removed. All other files
and subfolders are the user's and stay. A listed file that was edited since, and a user's file in
the way of a new one, is kept under another name and reported. A folder with files but without a
manifest is refused.

The new folder is made in a hidden work folder beside the output:

1. The new files are written. The user's files are added as hard links, so that they are the same
   files.
2. The new folder and the old one are exchanged in one step. A process that is killed leaves the old
   result whole or the new one, with the user's files in either. Where the system has no such step
   (Windows, some network drives), the old folder is first renamed aside, and the next command on
   the same output puts it back.
3. The old folder is emptied. What the new one lacks is moved there: files that appeared during step
   1, and all of the user's where the file system has no hard links.

The name of the new folder says its inode, `new-INODE`. So it shows what a killed process left: a
folder with its own inode was not in place yet, and is removed; one with another inode is the old
folder, and is emptied.
"""

from __future__ import annotations

import ctypes
import errno
import hashlib
import math
import os
import shutil
import stat
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from workbench.errors import InputError
from workbench.files.file_errors import is_input
from workbench.files.output_file import Content, locked, planted, probe, writable, write_errors

__all__ = [
    "MANIFEST",
    "Holding",
    "Manifest",
    "check_folder",
    "exchange",
    "manifest_of",
    "write_folder",
]

MANIFEST = "manifest.json"
Holding = Literal["result", "comparison", "people", "region"]
Tell = Callable[[str], None]
_LOCK = "lock"
_OLD = "old"
_NEW = "new"
_WORDS = {
    "result": "a result",
    "comparison": "a comparison",
    "people": "bodies of people",
    "region": "places of a control",
}


class Manifest(BaseModel):
    """manifest.json: what a folder holds, and the SHA-256 of each of its own files by name."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    format: Literal["bubbleman-workbench manifest 1"] = "bubbleman-workbench manifest 1"
    holds: Holding
    files: dict[str, str]


def check_folder(folder: Path, *, holds: Holding) -> Path:
    """Check, before any work, that a result can be written into a folder; finish what a killed
    process left there.

    Returns
    -------
    Path
        The folder itself, links resolved.

    Raises
    ------
    InputError
        If the folder holds something else, or cannot be written.
    """
    with write_errors(folder):
        place = _resolved(folder)
        if _work_folder(place).is_dir():
            with _working(place):
                pass
        _check(folder, place, holds)
        probe(place.parent)
        return place


def write_folder(
    folder: Path, files: Mapping[str, Content], *, holds: Holding, tell: Tell = lambda line: None
) -> None:
    """Write files into a folder, with their manifest, in place of the earlier result in it.

    Parameters
    ----------
    files
        Contents by name; a name may have folders in it, "a/b.csv".
    tell
        Called with a line for each of the user's files that is kept under another name.

    Raises
    ------
    InputError
        As of `check_folder`; or if the disk is full, or another command writes into the same
        folder.
    """
    with write_errors(folder):
        place = _resolved(folder)
        place.parent.mkdir(parents=True, exist_ok=True)
        with _working(place, tell) as work:
            _check(folder, place, holds)
            staged = _staged_folder(work)
            _write(staged, files, holds)
            if not place.exists():
                staged.rename(place)
                return
            _link_users(place, staged, tell)
            if not exchange(staged, place):
                place.rename(work / _OLD)
                staged.rename(place)


def _resolved(folder: Path) -> Path:
    try:
        place = folder.resolve()
    except RuntimeError:
        raise InputError(f"{folder}: cannot be written (symbolic links in a circle)") from None
    if not place.name:
        raise InputError(f"{folder}: cannot be written (is a mount point; name a folder in it)")
    return place


def _check(folder: Path, place: Path, holds: Holding) -> None:
    """InputError where the folder is not empty and not an earlier result of the same kind, or
    cannot be replaced."""
    _work_folder(place).exists()  # the longest name that is needed
    if not place.exists():
        return
    if os.path.ismount(place):
        raise InputError(f"{folder}: cannot be written (is a mount point; name a folder in it)")
    if not place.is_dir() or (any(place.iterdir()) and not (place / MANIFEST).is_file()):
        raise InputError(_foreign(folder, place))
    _check_subfolders(place, place.stat().st_dev)
    found = manifest_of(place)
    if found is None:
        return
    if found.holds != holds:
        raise InputError(
            f"{folder}: holds {_WORDS[found.holds]}, not {_WORDS[holds]}; choose another folder"
        )
    for name in found.files:
        if is_input(place / name):
            raise InputError(
                f"{folder}: cannot be written ({name} in it is an input of this command)"
            )


def _foreign(folder: Path, place: Path) -> str:
    told = f"{folder}: is there already and is not a result of the workbench; choose another --out"
    if any((place / name).is_file() for name in ("result.json", "comparison.json", "people.csv")):
        told += f" (it has no {MANIFEST}: move or delete what an earlier version wrote)"
    return told


def _check_subfolders(folder: Path, device: int) -> None:
    """InputError where a folder, or one in it, cannot be made anew as it is."""
    info = folder.stat()
    mine = not hasattr(os, "geteuid") or os.geteuid() in (0, info.st_uid)
    if info.st_dev != device or not mine or not writable(folder):
        raise InputError(
            f"{folder}: cannot be written (is read-only, another user's, or on another disk)"
        )
    for path in folder.iterdir():
        if _is_folder(path):
            _check_subfolders(path, device)


def manifest_of(folder: Path) -> Manifest | None:
    """Return the manifest of a folder, None where it has none.

    Raises
    ------
    InputError
        Where it is damaged.
    """
    file = folder / MANIFEST
    try:
        return Manifest.model_validate_json(file.read_bytes())
    except FileNotFoundError:
        return None
    except ValidationError:
        raise InputError(
            f"{file}: is damaged; move the folder away or choose another --out"
        ) from None


def _work_folder(place: Path) -> Path:
    return place.with_name(f".{place.name}.workbench")


@contextmanager
def _working(place: Path, tell: Tell = lambda line: None) -> Iterator[Path]:
    """The work folder of an output, for this process alone. Before and after, what is left in it is
    put right."""
    work = _work_folder(place)
    if work.is_symlink():  # what is in it would be taken for what an earlier run has left
        raise planted(work, place)
    with locked(work / _LOCK, place, wait=math.inf):
        _put_right(work, place, tell)
        try:
            yield work
        finally:
            _put_right(work, place, tell)
            (work / _LOCK).unlink()
            with suppress(OSError):  # another process waits in it already
                work.rmdir()


def _put_right(work: Path, place: Path, tell: Tell) -> None:
    """Bring an interrupted write to its end: the old result is in place, or the new one, and
    nothing is left of it."""
    for folder in sorted(path for path in work.iterdir() if path.name != _LOCK):
        if folder.name in (_NEW, f"{_NEW}-{folder.stat().st_ino}"):
            shutil.rmtree(folder)
        elif not place.exists():
            folder.rename(place)
        else:
            _empty(folder, place, tell)


def _staged_folder(work: Path) -> Path:
    """An empty folder that has its inode in its name."""
    made = work / _NEW
    made.mkdir()
    return made.rename(work / f"{_NEW}-{made.stat().st_ino}")


def _write(folder: Path, files: Mapping[str, Content], holds: Holding) -> None:
    """Write the files and then the manifest, which is the same for the same files."""
    sums = {name: _put(folder / name, content) for name, content in files.items()}
    listed = Manifest(holds=holds, files=dict(sorted(sums.items())))
    _put(folder / MANIFEST, listed.model_dump_json(indent=1) + "\n")


def _put(path: Path, content: Content) -> str:
    """Write one file; returns its SHA-256."""
    path.parent.mkdir(parents=True, exist_ok=True)
    digest = hashlib.sha256()
    with path.open("wb") as file:
        for part in [content] if isinstance(content, (str, bytes)) else content:
            data = part.encode() if isinstance(part, str) else part
            digest.update(data)
            file.write(data)
    return digest.hexdigest()


class _Own:
    """Which files of a folder are the result's own: listed in its manifest, and not edited
    since."""

    def __init__(self, folder: Path) -> None:
        found = manifest_of(folder)
        self.folder = folder
        self.listed: Mapping[str, str] = found.files if found is not None else {}

    def holds(self, path: Path) -> bool:
        """Whether a path in the folder is one of the result's own files, unchanged."""
        name = _name(path, self.folder)
        if path.is_symlink() or not path.is_file():
            return False
        if name == MANIFEST:
            return True
        return name in self.listed and _digest(path) == self.listed[name]


class _Names:
    """Where a user's file of the old folder goes in the new one: to its own name, or to a free
    one."""

    def __init__(self, old: Path, new: Path, tell: Tell) -> None:
        self.old = old
        self.new = new
        self.tell = tell
        self.listed = _Own(old).listed

    def free(self, path: Path, at: Path) -> Path:
        """The place of an old path that would go to `at`."""
        if not os.path.lexists(at) or (_is_folder(path) and _is_folder(at)):
            return at
        number = 1
        while True:
            kept = at.with_name(f"{at.stem}.kept{f'-{number}' if number > 1 else ''}{at.suffix}")
            if not os.path.lexists(kept) and not os.path.lexists(path.with_name(kept.name)):
                return kept
            number += 1

    def report(self, path: Path, at: Path) -> None:
        """Tell of a path that has another name now."""
        name = _name(path, self.old)
        if at.name != path.name:
            why = (
                "was edited since it was written"
                if name in self.listed
                else "is not a file of the result"
            )
            self.tell(f"{name}: {why}; it is kept as {_name(at, self.new)}")


def _link_users(old: Path, new: Path, tell: Tell) -> None:
    """Make the user's folders in the new folder as they are in the old one, and hard links to the
    user's files."""
    own = _Own(old)
    names = _Names(old, new, tell)

    def link(source: Path, target: Path) -> None:
        for path in sorted(source.iterdir()):
            if own.holds(path) or (_is_folder(path) and _only_own(path, own)):
                continue
            at = names.free(path, target / path.name)
            if _is_folder(path):
                at.mkdir(exist_ok=True)
                link(path, at)
            else:
                try:
                    os.link(path, at, follow_symlinks=False)
                except (OSError, NotImplementedError):  # no hard links here: it is moved in step 3
                    continue
            names.report(path, at)
        _copy_rights(source, target)

    link(old, new)
    os.utime(new)


def _only_own(folder: Path, own: _Own) -> bool:
    """Whether a subfolder holds the result's own files and nothing else; one that is empty is the
    user's."""
    paths = list(folder.iterdir())
    return bool(paths) and all(
        _only_own(path, own) if _is_folder(path) else own.holds(path) for path in paths
    )


def _copy_rights(source: Path, target: Path) -> None:
    """Give a folder the rights, times and owner of another."""
    shutil.copystat(source, target)
    before = source.stat()
    now = target.stat()
    if hasattr(os, "chown") and (before.st_uid, before.st_gid) != (now.st_uid, now.st_gid):
        os.chown(target, before.st_uid, before.st_gid)


def _empty(old: Path, new: Path, tell: Tell) -> None:
    """Remove an old folder: its own files, and links to files of the new one. All else is moved to
    the new one."""
    own = _Own(old)
    names = _Names(old, new, tell)
    there = {_inode(path) for path in new.rglob("*") if not _is_folder(path)}

    def empty(source: Path, target: Path) -> None:
        for path in sorted(
            source.iterdir(), key=lambda path: path.name == MANIFEST
        ):  # it says to the end what is own
            if _is_folder(path):
                empty(path, target / path.name)
            elif own.holds(path) or _inode(path) in there:
                path.unlink()
            else:
                folder = names.free(source, target)
                folder.mkdir(parents=True, exist_ok=True)
                at = names.free(path, folder / path.name)
                path.rename(at)
                names.report(path, at)
        source.rmdir()

    empty(old, new)


def _is_folder(path: Path) -> bool:
    """Whether a path is a folder and no link to one. A path that another command removes meanwhile
    is none."""
    try:
        return stat.S_ISDIR(path.lstat().st_mode)
    except OSError:
        return False


def _inode(path: Path) -> tuple[int, int]:
    info = path.lstat()
    return info.st_dev, info.st_ino


def _name(path: Path, folder: Path) -> str:
    return PurePosixPath(path.relative_to(folder)).as_posix()


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


_RENAME_EXCHANGE = 2
"""Flag of renameat2 in Linux, and, as RENAME_SWAP, of renamex_np in macOS."""
_AT_FDCWD = -100
_UNSUPPORTED = {errno.ENOSYS, errno.EINVAL, errno.ENOTSUP}


def exchange(first: Path, second: Path) -> bool:
    """Exchange two paths of one file system. False, and nothing is done, where the system cannot
    exchange.

    Raises
    ------
    OSError
        If the system refuses.
    """
    paths = os.fsencode(first), os.fsencode(second)
    try:
        system = ctypes.CDLL(None, use_errno=True)
        if sys.platform == "darwin":
            result = system.renamex_np(paths[0], paths[1], ctypes.c_uint(_RENAME_EXCHANGE))
        else:
            result = system.renameat2(
                _AT_FDCWD, paths[0], _AT_FDCWD, paths[1], ctypes.c_uint(_RENAME_EXCHANGE)
            )
    except (
        AttributeError,
        TypeError,
    ):  # no such function in the system's library; Windows has no library by this name
        return False
    if result == 0:
        return True
    code = ctypes.get_errno()
    if code in _UNSUPPORTED:
        return False
    raise OSError(code, os.strerror(code), str(second))
