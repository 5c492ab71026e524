"""Arrays inside frozen nouns are read-only, of one dtype and of a checked shape."""

from __future__ import annotations

import mmap
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.errors import InputError

__all__ = ["Bools", "Floats", "Ints", "frozen"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


def frozen(values: ArrayLike, dtype: type, shape: tuple[int | None, ...], what: str) -> NDArray[Any]:
    """Return a read-only C-ordered copy of `values` with this dtype, or `values` itself where nobody can write to it;
    None in `shape` is any length.

    Raises InputError where the shape is another, naming `what`.
    """
    array: NDArray[Any]
    if isinstance(values, np.ndarray) and _settled(values):
        array = np.asarray(values, dtype=dtype, order="C")
    else:
        array = np.array(values, dtype=dtype, order="C")
    fits = array.ndim == len(shape) and all(want in (None, have) for want, have in zip(shape, array.shape, strict=True))
    if not fits:
        raise InputError(f"{what}: an array of shape {shape} is needed (None: any), got {array.shape}")
    array.flags.writeable = False
    return array


def _settled(array: NDArray[Any]) -> bool:
    """True where an array and all that it is a view of are read-only, down to who owns the memory or a file."""
    at: object = array
    while isinstance(at, np.ndarray):
        if at.flags.writeable:
            return False
        if at.flags.owndata:
            return True
        at = at.base
    return isinstance(at, mmap.mmap)
