"""Indexes kept on disk between runs, by the key of what they were made from (see `model.content`).

A file is an .npz with its key beside the arrays, whose CRC-32 is checked, so that one that is torn,
altered, of another version or of somebody else is not believed: it is made anew. WORKBENCH_CACHE
names another folder, or "off" keeps nothing. Where a file cannot be written the run goes on without:
the cache saves time and decides nothing.
"""

from __future__ import annotations

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

__all__ = ["PARTIAL", "cache_folder", "cached", "forget_partial", "read_arrays", "write_arrays"]

PARTIAL = "new-"
"""How the names of files begin that are being written."""
_DAY = 86_400.0
MOST_FILES = 32
"""The files used longest ago give way."""
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


def cached(key: bytes, make: Callable[[], Arrays]) -> Arrays:
    """The arrays kept under a key, or else made and kept."""
    folder = cache_folder()
    if folder is None:
        return make()
    path = folder / f"{key[:20].hex()}.index"
    found = read_arrays(path, key)
    if found is None:
        found = make()
        with suppress(OSError):
            write_arrays(path, key, found)
            files = sorted(folder.glob("*.index"), key=lambda file: file.stat().st_mtime)
            for old in files[:-MOST_FILES]:
                old.unlink(missing_ok=True)
            forget_partial(folder)
    else:
        with suppress(OSError):
            os.utime(path)
    return found


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
    """Write arrays and their key as one .npz file in one step; OSError as of `write_atomic`."""
    contents = BytesIO()
    with zipfile.ZipFile(contents, "w") as archive:
        for name, values in {_KEY: np.frombuffer(key, np.uint8), **arrays}.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, values, allow_pickle=False)
    write_atomic(path, contents.getvalue())


def write_atomic(path: Path, contents: bytes) -> None:
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
