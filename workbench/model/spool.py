"""Arrays that grow row by row, in memory while they are small, in a temporary file beyond: memory
stays bounded."""

from __future__ import annotations

import tempfile
import weakref
from collections.abc import Iterator
from typing import IO

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats

__all__ = ["IN_MEMORY", "PIECE", "Spool", "pieces"]

IN_MEMORY = 2**26
"""[bytes] An array larger than this is kept in a file."""
PIECE = 4096
"""Frames that are worked on at a time."""


def pieces(count: int, *, size: int = PIECE) -> Iterator[slice]:
    """The slices of at most `size` of range(count), in order."""
    for first in range(0, count, size):
        yield slice(first, min(first + size, count))


class Spool:
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
