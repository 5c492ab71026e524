"""The key of kept work: a hash of everything that reaches the computation, and of the program that
does it.

A kept file is believed only under its key. So nobody lists by hand what a key is made from: values
are walked as they are built, a dataclass by all its fields and an array by its type, shape and
bytes. A field that is added later belongs to the key without anybody thinking of it. What the walk
does not know is an error, never skipped.

Where a computation needs only a part of a noun, it gets a noun that holds this part alone, and the
key is made from the same noun (see `contact.fields` and `study.situation.Seating`).
"""

from __future__ import annotations

import hashlib
import platform
import struct
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import workbench
from workbench.errors import InputError

__all__ = ["LIBRARIES", "content_hash", "content_key", "program_hash"]

LIBRARIES = ("numpy", "scipy", "numba", "llvmlite")
"""Packages whose numbers a computation rests on; their versions belong to every key."""
_PACKAGE = Path(workbench.__file__).resolve().parent
_COMPILED = "__pycache__"
_BLOCK = 1 << 20

Update = Callable[[bytes | memoryview], None]


def content_key(purpose: str, *values: object) -> bytes:
    """Hash some values, what the result is for, and the program.

    Parameters
    ----------
    purpose
        What is kept under the key ("fitted bodies"): equal values kept for two purposes have two
    keys. values
        None, bool, int, float, str, bytes, enums, NumPy scalars and arrays, and paths, which count
        by the bytes of their files; tuples, lists, sets, mappings and dataclasses of these. The
        order of a mapping counts.

    Returns
    -------
    bytes
        32 bytes. Two values have the same key where types, names of fields and all bytes are the
        same.

    Raises
    ------
    TypeError
        For a value of another type.
    InputError
        If the file of a path cannot be read.
    """
    digest = hashlib.sha256()
    _add(digest.update, (program_hash(_PACKAGE), purpose, values))
    return digest.digest()


def content_hash(value: object) -> str:
    """Hash a value as `content_key` does, whatever the program; in hexadecimal digits."""
    return _hash(value).hex()


@lru_cache(maxsize=4)
def program_hash(package: Path) -> bytes:
    """Hash all files of a package (code, and data that lie in it) and the versions of Python and of
    LIBRARIES.

    The files are read once a process.
    """
    digest = hashlib.sha256()
    files = [
        path
        for path in sorted(package.rglob("*"))
        if _COMPILED not in path.parts and path.is_file()
    ]
    versions = {name: _version(name) for name in LIBRARIES}
    names = [path.relative_to(package).as_posix() for path in files]
    _add(digest.update, (platform.python_version(), versions, names, files))
    return digest.digest()


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def _add(update: Update, value: object) -> None:
    """Hash a value: the name of its type, how long it is, and what is in it."""
    kind = type(value)
    update(f"{kind.__module__}.{kind.__qualname__} ".encode())
    if isinstance(value, Enum):
        _add(update, value.name)
        _add(update, value.value)
    elif isinstance(value, (np.ndarray, np.generic)):
        _add_array(update, np.asarray(value))
    elif isinstance(value, (bytes, str, int, float, type(None))):  # bool is an int
        data = _data(value)
        update(len(data).to_bytes(8, "little"))
        update(data)
    elif isinstance(value, Path):
        _add_file(update, value)
    else:
        _add_container(update, value)


def _add_container(update: Update, value: object) -> None:
    """Hash what is in a dataclass, a mapping, a sequence or a set."""
    if is_dataclass(value) and not isinstance(value, type):
        _add(update, {field.name: getattr(value, field.name) for field in fields(value)})
    elif isinstance(value, Mapping):
        _add(update, [*value.keys()])
        _add(update, [*value.values()])
    elif isinstance(value, (tuple, list)):
        update(len(value).to_bytes(8, "little"))
        for item in value:
            _add(update, item)
    elif isinstance(value, (set, frozenset)):
        _add(update, sorted(_hash(item) for item in value))
    else:
        kind = type(value)
        raise TypeError(f"no key can be made from a {kind.__module__}.{kind.__qualname__}")


def _data(value: bytes | str | int | float | None) -> bytes:
    """The bytes of a plain value."""
    if isinstance(value, bytes):
        return value
    if isinstance(value, float):
        return struct.pack("<d", value)
    return str(value).encode("utf-8", "surrogatepass")


def _add_array(update: Update, array: NDArray[Any]) -> None:
    if array.dtype.hasobject:
        raise TypeError(
            "no key can be made from an array of Python objects: its bytes are addresses"
        )
    update(f"{array.dtype.str} {array.dtype.descr} {array.shape} ".encode())
    update(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data)


def _add_file(update: Update, path: Path) -> None:
    """Hash what is in a file, whatever it is called."""
    digest = hashlib.sha256()
    try:
        with path.open("rb") as file:
            while block := file.read(_BLOCK):
                digest.update(block)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    update(digest.digest())


def _hash(value: object) -> bytes:
    digest = hashlib.sha256()
    _add(digest.update, value)
    return digest.digest()
