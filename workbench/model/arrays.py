"""Arrays inside frozen nouns are read-only, of one dtype and of a checked shape.

A `GrowingArray` grows row by row, in memory while it is small, in a temporary file beyond: memory stays
bounded.
"""

from __future__ import annotations

import mmap
import tempfile
import weakref
from collections.abc import Iterator, Mapping
from typing import IO, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.errors import InputError

__all__ = [
    "IN_MEMORY",
    "PIECE",
    "ArrayKind",
    "Bools",
    "Floats",
    "GrowingArray",
    "Ints",
    "for_rows",
    "freeze_fields",
    "pieces",
    "read_only",
    "xyz",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
ArrayKind = tuple[type, tuple[int | None, ...]]
"""The dtype of an array, and its shape; None is any length."""


def read_only(
    values: ArrayLike, dtype: type, shape: tuple[int | None, ...], what: str
) -> NDArray[Any]:
    """Return a read-only C-ordered copy of `values` with this dtype, or `values` itself where
    nobody can write to it; None in `shape` is any length.

    Raises InputError, naming `what`, where the shape is another, or the values are no numbers of
    this dtype (whole ones for integers, truth values for booleans).
    """
    array = _converted(values, dtype, what)
    fits = array.ndim == len(shape) and all(
        want in (None, have) for want, have in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = str(shape).replace("None", "any")
        raise InputError(f"{what}: expected an array of shape {wanted}, got {array.shape}")
    array.flags.writeable = False
    return array


def for_rows(
    values: ArrayLike, dtype: type, shape: tuple[int, ...], *, rows: int, what: str
) -> NDArray[Any]:
    """Return a read-only array (rows, *shape) of this dtype: the values as given, or the same for
    all rows where they have this shape alone. Raises as `read_only`."""
    wanted = shape if np.ndim(values) <= len(shape) else (rows, *shape)
    return np.broadcast_to(read_only(values, dtype, wanted, what), (rows, *shape))


def freeze_fields(noun: object, arrays: Mapping[str, ArrayKind], called: str) -> None:
    """Make the arrays of a frozen noun read-only, each of its dtype and shape.

    Parameters
    ----------
    noun
        The noun that is being made.
    arrays
        The dtype and shape of each field; None in a shape is any length.
    called
        What the noun is called in messages.

    Raises
    ------
    InputError
        As `read_only` raises it, naming noun and field.
    """
    for name, (dtype, shape) in arrays.items():
        value = read_only(getattr(noun, name), dtype, shape, f"{called}.{name}")
        object.__setattr__(noun, name, value)


def _converted(values: ArrayLike, dtype: type, what: str) -> NDArray[Any]:
    """A C-ordered array of this dtype, the values themselves where nobody can write to them;
    InputError where a value would become another one."""
    try:
        given = np.asarray(values)
        if given.dtype != dtype and given.size:
            _same_numbers(given, dtype, what)
        if isinstance(values, np.ndarray) and _settled(values):
            return np.asarray(values, dtype=dtype, order="C")
        return np.array(given, dtype=dtype, order="C")
    except (ValueError, TypeError, OverflowError):
        raise InputError(
            f"{what}: expected an array of {np.dtype(dtype)}, got {type(values).__name__}"
        ) from None


def _same_numbers(given: NDArray[Any], dtype: type, what: str) -> None:
    kinds = {"f": "fiub", "i": "iufb", "b": "b"}[np.dtype(dtype).kind]
    if given.dtype.kind not in kinds:
        raise InputError(
            f"{what}: expected an array of {np.dtype(dtype)}, got one of {given.dtype}"
        )
    if np.dtype(dtype).kind == "i" and given.dtype.kind == "f":
        odd = ~(np.abs(given) < 2.0**63) | (given != np.rint(given))
        if odd.any():
            raise InputError(f"{what}: expected whole numbers, got {given[odd].flat[0]:g}")


def _settled(array: NDArray[Any]) -> bool:
    """True where an array and all that it is a view of are read-only, down to who owns the memory
    or a file."""
    at: object = array
    while isinstance(at, np.ndarray):
        if at.flags.writeable:
            return False
        if at.flags.owndata:
            return True
        at = at.base
    return isinstance(at, mmap.mmap)


def xyz(vector: Floats) -> tuple[float, float, float]:
    """A vector (3,) as three numbers."""
    x, y, z = vector.tolist()
    return x, y, z


IN_MEMORY = 2**26
"""[bytes] An array larger than this is kept in a file."""
PIECE = 4096
"""Frames that are worked on at a time."""


def pieces(count: int, *, size: int = PIECE) -> Iterator[slice]:
    """The slices of at most `size` of range(count), in order."""
    for first in range(0, count, size):
        yield slice(first, min(first + size, count))


class GrowingArray:
    """Rows of one shape that are added piece by piece and become one read-only array.

    Beyond IN_MEMORY bytes they go to a file without a name in the folder for temporary files
    (TMPDIR), which is gone with the array. InputError where that folder is full.
    """

    def __init__(self, *shape: int) -> None:
        self._shape = shape
        self._count = 0
        self._bytes = 0
        self._held: list[Floats] = []
        self._file: IO[bytes] | None = None

    def add(self, rows: Floats) -> None:
        """Add rows (n, *shape)."""
        piece = np.array(rows, dtype=np.float64, order="C").reshape(-1, *self._shape)
        self._count += len(piece)
        self._bytes += piece.nbytes
        if self._bytes <= IN_MEMORY:
            self._held.append(piece)
            return
        try:
            if self._file is None:
                self._file = tempfile.TemporaryFile(prefix="workbench-")  # noqa: SIM115 (lives as long as the array)
                weakref.finalize(self, self._file.close)
                for held in self._held:
                    held.tofile(self._file)
                self._held = []
            piece.tofile(self._file)
        except OSError as error:
            raise InputError(
                f"{tempfile.gettempdir()}: no room for {self._bytes / 2**20:.0f} MiB of frames "
                f"({error.strerror})"
            ) from None

    def done(self) -> Floats:
        """All rows (n, *shape), read-only."""
        if self._file is None:
            whole = np.concatenate([np.empty((0, *self._shape)), *self._held])
            whole.flags.writeable = False
            return whole
        self._file.flush()
        whole = np.memmap(self._file, np.float64, "r", shape=(self._count, *self._shape))
        self._file.close()  # the mapping holds on to what it needs
        return np.asarray(whole)
