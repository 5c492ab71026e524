"""How kernels are compiled, and how compiled code is kept between runs.

Numba keeps the machine code of a function on disk and believes what it finds there: a damaged file
ends in an error of the reader or in a crash. It also keeps the code until the function's own file
changes, though the code holds what the functions of other files were when they were drawn into it.
Here each file begins with a hash of its contents, of all kernels' sources and of the compiler's
version. A file whose hash does not fit is not read: the function is compiled and kept again. Where
nothing can be written, nothing is kept.
"""

from __future__ import annotations

import hashlib
import pickle
import platform
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.dispatcher import Dispatcher

__all__ = ["KERNELS", "njit", "source_stamp"]

KERNELS = Path(__file__).parent
_DIGEST = hashlib.sha256().digest_size


def njit(*, cache: bool = False, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function as `numba.njit` does; cache: keep the code, in files that are checked when
    they are read."""

    def compiled(function: Callable[..., Any]) -> Any:
        made = numba.njit(**options)(function)
        if cache and isinstance(made, Dispatcher):  # not one where the compiler is off
            with suppress(RuntimeError):  # no folder can be written to
                made._cache = _Cache(function)  # type: ignore[attr-defined]
        return made

    return compiled


@lru_cache(maxsize=4)
def source_stamp(folder: Path) -> bytes:
    """Hash the Python files in a folder and what compiles them."""
    digest = hashlib.sha256(" ".join([platform.python_version(), *_versions()]).encode())
    for path in sorted(folder.rglob("*.py")):
        data = path.read_bytes()
        digest.update(f"\n{path.relative_to(folder).as_posix()} {len(data)}\n".encode())
        digest.update(data)
    return digest.digest()


def _versions() -> list[str]:
    return [numba.__version__, llvmlite.__version__, np.__version__]


class _Cache(FunctionCache):  # type: ignore[misc]
    """The compiled code of one function, for all types of arguments that it was compiled for."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._cache_file = _Files(self._cache_path, self._impl.filename_base, source_stamp(KERNELS))


class _Files(IndexDataCacheFile):  # type: ignore[misc]
    """An index of one function's compiled code, and a file for each code in it, all of them
    checked."""

    def load(self, key: object) -> Any:
        """The code for a key; None where there is none that can be believed."""
        found = super().load(key)
        if found is None or found[0] != key:  # another process has written another code over it
            return None
        return found[1]

    def save(self, key: object, data: object) -> None:
        """Keep the code for a key, where the disk lets us."""
        with suppress(OSError):
            super().save(key, (key, data))

    def _load_index(self) -> Any:
        data = self._contents(self._index_path)
        return {} if data is None else pickle.loads(data)

    def _save_index(self, overloads: object) -> None:
        self._write(self._index_path, overloads)

    def _load_data(self, name: str) -> Any:
        data = self._contents(self._data_path(name))
        if data is None:
            raise FileNotFoundError(name)
        return pickle.loads(data)

    def _save_data(self, name: str, data: object) -> None:
        self._write(self._data_path(name), data)

    def _contents(self, path: str) -> bytes | None:
        """What a file holds after its hash; None where the hash is another one."""
        try:
            data = Path(path).read_bytes()
        except OSError:
            return None
        return data[_DIGEST:] if data[:_DIGEST] == self._sealed(data[_DIGEST:]) else None

    def _write(self, path: str, held: object) -> None:
        data = self._dump(held)
        with self._open_for_write(path) as file:
            file.write(self._sealed(data) + data)

    def _sealed(self, data: bytes) -> bytes:
        """The hash that a file of such contents begins with."""
        return hashlib.sha256(self._source_stamp + data).digest()
