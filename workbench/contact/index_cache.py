"""Indexes kept on disk between runs, by the key of what they were made from (see `model.content`).

A file holds a hash of its key and contents before the contents, so that one that is torn, altered,
of another version or of somebody else is not believed: it is made anew. Names, types and places of
the arrays come first, as JSON, then the arrays as they lie in memory: a large index is read in one
go and only added up, for its checksum. That reads the 21 MB of the trainer three times as fast as
an .npz file (11 ms instead of 33), so indexes have this format of their own; smaller arrays are
kept by `write_arrays` as .npz. WORKBENCH_CACHE names another folder, or "off" keeps nothing. Where
a file cannot be written the run goes on without: the cache saves time and decides nothing.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["PARTIAL", "cache_folder", "forget_partial", "kept", "read_arrays", "write_arrays"]

PARTIAL = "new-"
"""How the names of files begin that are being written."""
_DAY = 86_400.0
MOST_FILES = 32
"""The files used longest ago give way."""
_DIGEST = hashlib.sha256().digest_size
_ALIGN = 64
"""Arrays begin at multiples of so many bytes."""
_ROW = 509
"""Words that are added up in columns: no divisor of a page's, so that pages that changed places
show."""
_KEY = "key"
"""The entry of an .npz file that holds the key."""
Arrays = dict[str, NDArray[Any]]


def cache_folder() -> Path | None:
    """Where indexes are kept; None where WORKBENCH_CACHE says "off"."""
    asked = os.environ.get("WORKBENCH_CACHE")
    if asked is not None:
        return None if asked.strip().lower() in ("", "0", "off") else Path(asked).expanduser()
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", "~/AppData/Local"))
    elif sys.platform == "darwin":
        base = Path("~/Library/Caches")
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache")
    return base.expanduser() / "workbench"


def kept(key: bytes, make: Callable[[], Arrays]) -> Arrays:
    """The arrays kept under a key, or else made and kept."""
    folder = cache_folder()
    if folder is None:
        return make()
    path = folder / f"{key[:20].hex()}.index"
    found = _read(path, key)
    if found is None:
        found = make()
        _write(path, key, found)
    return found


def _read(path: Path, key: bytes) -> Arrays | None:
    """The arrays of a file; None where there is none, or none that can be believed.

    They are parts of one large block of memory, which the system gives out in large pages: searches
    that jump about in it find their way faster than in a mapped file.
    """
    try:
        data = np.fromfile(path, dtype=np.uint8)
        head = data[: _DIGEST + 8].tobytes()
        begin = _DIGEST + 8 + int.from_bytes(head[_DIGEST:], "little")
        if len(data) < begin or head[:_DIGEST] != _checksum(key, data[_DIGEST:]):
            return None
        os.utime(path)
        found = {}
        for name, kind, shape, at in json.loads(data[_DIGEST + 8 : begin].tobytes()):
            size = int(np.prod(shape)) * np.dtype(kind).itemsize
            found[name] = data[begin + at : begin + at + size].view(kind).reshape(shape)
        return found
    except (OSError, ValueError):
        return None


def _write(path: Path, key: bytes, arrays: Arrays) -> None:
    """Write a file in one step, and let the oldest go; nothing where the disk does not let us."""
    listed = []
    parts = []
    at = 0
    for name, values in arrays.items():
        listed.append([name, values.dtype.str, values.shape, at])
        part = _bytes(values).tobytes()
        parts.append(part + bytes(-len(part) % _ALIGN))
        at += len(parts[-1])
    said = json.dumps(listed).encode()
    said += b" " * (-(_DIGEST + 8 + len(said)) % _ALIGN)
    contents = b"".join([len(said).to_bytes(8, "little"), said, *parts])
    try:
        write_whole(path, _checksum(key, np.frombuffer(contents, dtype=np.uint8)) + contents)
        files = sorted(path.parent.glob("*.index"), key=lambda file: file.stat().st_mtime)
        for old in files[:-MOST_FILES]:
            old.unlink(missing_ok=True)
        forget_partial(path.parent)
    except OSError:
        return


def _bytes(values: NDArray[Any]) -> NDArray[np.uint8]:
    """The bytes of an array, in order."""
    return np.ascontiguousarray(values).reshape(-1).view(np.uint8)


def _checksum(key: bytes, data: NDArray[np.uint8]) -> bytes:
    """A hash of a key, of how many bytes there are and of their words added up in columns.

    It goes at the speed of memory, ten times that of hashing all of them, and tells what disks and
    writers do to files: cut off, altered, moved or left out. It is no guard against who means to
    deceive, who could alter our own files too.
    """
    whole = len(data) // (8 * _ROW) * (8 * _ROW)
    columns = data[:whole].view(np.uint64).reshape(-1, _ROW).sum(axis=0, dtype=np.uint64)
    said = key + len(data).to_bytes(8, "little") + columns.tobytes()
    return hashlib.sha256(said + data[whole:].tobytes()).digest()


def forget_partial(folder: Path) -> None:
    """Remove from a folder of kept files what processes that were killed had half written, more
    than a day ago."""
    for path in folder.glob(f"{PARTIAL}*"):
        with suppress(OSError):
            if time.time() - path.stat().st_mtime > _DAY:
                path.unlink()


def read_arrays(path: Path, key: bytes) -> Arrays | None:
    """Read the arrays of an .npz file; None if it is not there, damaged, or of another key.

    Each array must take up its whole entry, so that the CRC-32 of all bytes is checked.
    """
    found = {}
    try:
        with zipfile.ZipFile(path) as archive:
            for name in archive.namelist():
                with archive.open(name) as entry:
                    found[name.removesuffix(".npy")] = np.lib.format.read_array(
                        entry, allow_pickle=False
                    )
                    if entry.read(1):
                        return None
    except (OSError, ValueError, RuntimeError, EOFError, MemoryError, zipfile.BadZipFile):
        return None
    stored = found.pop(_KEY, None)
    return found if stored is not None and stored.tobytes() == key else None


def write_arrays(path: Path, key: bytes, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays and their key as one .npz file in one step; OSError as of `write_whole`."""
    contents = BytesIO()
    with zipfile.ZipFile(contents, "w") as archive:
        for name, values in {_KEY: np.frombuffer(key, np.uint8), **arrays}.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, values, allow_pickle=False)
    write_whole(path, contents.getvalue())


def write_whole(path: Path, contents: bytes) -> None:
    """Write a file in one step, its folder with it; OSError where the disk does not let us, and
    then nothing is left of it and what was there before stays."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=PARTIAL, delete=False) as part:
        try:
            part.write(contents)
            part.close()
            Path(part.name).replace(path)
        except OSError:
            Path(part.name).unlink(missing_ok=True)
            raise
