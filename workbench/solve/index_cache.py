"""Indexes kept on disk between runs, by the hash of what they were made from.

A file holds the hash of its key and contents before the contents, so that one that is torn, altered, of another
version or of somebody else is not believed: it is made anew. WORKBENCH_CACHE names another folder, or "off" keeps
nothing. Where a file cannot be written the run goes on without: the cache saves time and decides nothing.
"""

from __future__ import annotations

import hashlib
import io
import os
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["cache_folder", "content_key", "kept", "write_whole"]

VERSION = b"workbench index 2"
"""Another one where the meaning of the arrays changes: older files are then not believed."""
MOST_FILES = 32
"""The files used longest ago give way."""
_DIGEST = hashlib.blake2b().digest_size
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


def content_key(values: Iterable[NDArray[Any] | bytes]) -> bytes:
    """A hash of arrays, their types and shapes."""
    digest = hashlib.blake2b(VERSION)
    for value in values:
        if not isinstance(value, bytes):
            digest.update(f"{value.dtype.str} {value.shape} ".encode())
            value = np.ascontiguousarray(value).tobytes()
        digest.update(value)
    return digest.digest()


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
    """The arrays of a file; None where there is none, or none that can be believed."""
    try:
        data = path.read_bytes()
        if data[:_DIGEST] != hashlib.blake2b(key + data[_DIGEST:]).digest():
            return None
        os.utime(path)
        with np.load(io.BytesIO(data[_DIGEST:]), allow_pickle=False) as arrays:
            return dict(arrays)
    except (OSError, ValueError, EOFError, zipfile.BadZipFile):
        return None


def _write(path: Path, key: bytes, arrays: Arrays) -> None:
    """Write a file in one step, and let the oldest go; nothing where the disk does not let us."""
    packed = io.BytesIO()
    np.savez(packed, **arrays)  # type: ignore[arg-type]
    contents = packed.getvalue()
    try:
        write_whole(path, hashlib.blake2b(key + contents).digest() + contents)
        files = sorted(path.parent.glob("*.index"), key=lambda file: file.stat().st_mtime)
        for old in files[:-MOST_FILES]:
            old.unlink(missing_ok=True)
    except OSError:
        return


def write_whole(path: Path, contents: bytes) -> None:
    """Write a file in one step, its folder with it; OSError where the disk does not let us, and then nothing is left of
    it and what was there before stays."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix="new-", delete=False) as part:
        try:
            part.write(contents)
            part.close()
            Path(part.name).replace(path)
        except OSError:
            Path(part.name).unlink(missing_ok=True)
            raise
