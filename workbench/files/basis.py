"""Shape bases: a NumPy archive without pickles, every array's name, kind and shape checked before
it is used."""

from __future__ import annotations

import tokenize
import zipfile
import zlib
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError, printable
from workbench.files.file_errors import note_input, read_whole
from workbench.model.arrays import Floats, Ints
from workbench.model.basis import Detail, ShapeBasis
from workbench.model.body import DIRECTIONS

__all__ = ["LEVELS", "load_basis"]

LEVELS = ("coarse", "medium", "fine")
FORMAT = 1
_DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    ValueError,
    EOFError,
    KeyError,
    NotImplementedError,
    MemoryError,
    OverflowError,
    TypeError,
    SyntaxError,
    tokenize.TokenError,
)
"""What NumPy and the archive under it raise on damaged arrays; their headers are written in
Python's own words."""
MOST_BYTES = 256 * 2**20
MOST_NAMES = 100_000
LONGEST_NAME = 200

Arrays = dict[str, np.ndarray[Any, Any]]


def load_basis(path: Path) -> ShapeBasis:
    """The basis in a file `NAME.npz`; the same noun for the same file. InputError says which array
    is wrong and how."""
    note_input(path)  # also where it was read before
    return _loaded(path.resolve(), path.stat().st_mtime_ns)


@lru_cache(maxsize=4)
def _loaded(path: Path, changed: int) -> ShapeBasis:
    del changed  # a file written anew is read anew
    arrays = _arrays(path)
    read = _Reader(path, arrays)
    if (given := read.number("format")) != FORMAT:
        raise InputError(f"{path}: format {given} is unknown; {FORMAT} is what can be read")
    segments = read.names("segments")
    joints = read.names("joints")
    n = len(segments)
    j = len(joints)
    count = read.array("joint_basis", (None, j, 3)).shape[0]
    levels = [level for level in LEVELS if f"{level}_segment" in arrays]
    if not levels:
        raise InputError(
            f"{path}: no level of detail; arrays of {', '.join(LEVELS)} are needed, as coarse_segment..."
        )
    anchors = read.names("anchor_names")
    return ShapeBasis(
        name=path.name,
        segments=segments,
        joints=joints,
        joint_mean=read.array("joint_mean", (j, 3)),
        joint_basis=read.array("joint_basis", (count, j, 3)),
        origin_mean=read.array("origin_mean", (n, 3)),
        origin_basis=read.array("origin_basis", (count, n, 3)),
        details={level: _detail(read, level, (count, n, j)) for level in levels},
        density=read.array("density", (n,)),
        anchor_names=anchors,
        anchors=read.array("anchors", (len(anchors), count)),
        anchor_spread=_spread(read, len(anchors), count),
        anchor_seated=read.array("anchor_seated", (len(anchors), 2)),
    )


def _arrays(path: Path) -> Arrays:
    try:
        data = BytesIO(read_whole(path, "a shape basis", most=MOST_BYTES))
        with zipfile.ZipFile(data) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > MOST_BYTES:
            raise InputError(
                f"{path}: unpacks to {size} bytes, too large for a shape basis (most: {MOST_BYTES})"
            )
        with np.load(data, allow_pickle=False) as found:
            arrays = {name: found[name] for name in found.files}
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except _DAMAGED as error:
        raise InputError(f"{path}: not a NumPy archive without pickles ({error})") from None
    foreign = [name for name, found in arrays.items() if not isinstance(found, np.ndarray)]
    if foreign:
        raise InputError(f"{path}: {foreign[0]!r} is no array")
    return arrays


class _Reader:
    """Arrays by name, checked; every fault names file, array, and what was found and what is
    needed."""

    def __init__(self, path: Path, arrays: Arrays) -> None:
        self.path = path
        self.arrays = arrays

    def _found(self, name: str) -> np.ndarray[Any, Any]:
        if name not in self.arrays:
            raise InputError(f"{self.path}: array {name!r} is missing")
        return self.arrays[name]

    def number(self, name: str) -> int:
        found = self._found(name)
        if found.shape != () or found.dtype.kind not in "iu":
            raise InputError(
                f"{self.path}: {name}: one whole number is needed, got {found.dtype} {found.shape}"
            )
        return int(found)

    def names(self, name: str, count: int | None = None) -> tuple[str, ...]:
        found = self._found(name)
        here = f"{self.path}: {name}"
        got = f"got {found.dtype} {found.shape}"
        if found.ndim != 1 or found.dtype.kind != "U" or count not in (None, len(found)):
            raise InputError(f"{here}: {count or 'some'} texts are needed, {got}")
        # texts of no letters take no bytes
        if len(found) > MOST_NAMES or found.dtype.itemsize > 4 * LONGEST_NAME:
            what = f"at most {MOST_NAMES} texts of at most {LONGEST_NAME} letters are possible"
            raise InputError(f"{here}: {what}, {got}")
        try:
            return tuple(printable(str(text)) for text in found)
        except SystemError:  # a number that is no character
            raise InputError(f"{here}: holds what is no text") from None

    def array(self, name: str, shape: tuple[int | None, ...], kind: str = "iuf") -> Floats:
        found = self._found(name)
        fits = found.ndim == len(shape) and all(
            w in (None, h) for w, h in zip(shape, found.shape, strict=True)
        )
        if not fits or found.dtype.kind not in kind:
            what = (
                f"numbers of shape {shape} are needed (None: any), got {found.dtype} {found.shape}"
            )
            raise InputError(f"{self.path}: {name}: {what}")
        if (
            found.dtype.kind == "f"
            and not np.all(np.isfinite(found))
            and not name.endswith("fit_error")
        ):
            raise InputError(f"{self.path}: {name}: finite numbers are needed")
        return np.asarray(found, dtype=np.float64)

    def indices(
        self, name: str, count: int, limit: tuple[int, int]
    ) -> np.ndarray[Any, np.dtype[np.int64]]:
        found = self.array(name, (count,), "iu").astype(np.int64)
        if not np.all((found >= limit[0]) & (found < limit[1])):
            raise InputError(
                f"{self.path}: {name}: numbers from {limit[0]} to {limit[1] - 1} are needed"
            )
        return found


def _detail(read: _Reader, level: str, counts: tuple[int, int, int]) -> Detail:
    """The arrays of a level of detail. counts: of coefficients, segments and joints."""
    k, n, j = counts
    s = len(read.array(f"{level}_segment", (None,), "iu"))
    segment = read.indices(f"{level}_segment", s, (0, n))
    if np.any(np.diff(segment) < 0):
        raise InputError(
            f"{read.path}: {level}_segment: spheres must be grouped by segment, in body order"
        )
    direction = _directions(read, f"{level}_direction", s)
    share = read.array(f"{level}_blend_share", (s,))
    if not np.all((share >= 0) & (share <= 1)):
        raise InputError(f"{read.path}: {level}_blend_share: numbers from 0 to 1 are needed")
    return Detail(
        segment=segment,
        centre_mean=read.array(f"{level}_centre_mean", (s, 3)),
        centre_basis=read.array(f"{level}_centre_basis", (k, s, 3)),
        radius_mean=read.array(f"{level}_radius_mean", (s,)),
        radius_basis=read.array(f"{level}_radius_basis", (k, s)),
        blend_joint=read.indices(f"{level}_blend_joint", s, (-1, j)),
        blend_share=share,
        names=read.names(f"{level}_name", s),
        direction=direction,
        fit_error=read.array(f"{level}_fit_error", (n, 2)),
    )


def _directions(read: _Reader, name: str, count: int) -> Ints:
    """(S,) indices into DIRECTIONS, -1 where a sphere shows none."""
    valid = ("", *DIRECTIONS)
    given = read.names(name, count)
    if unknown := sorted(set(given) - set(valid)):
        raise InputError(
            f"{read.path}: {name}: no direction {unknown[0]!r}; valid: {', '.join(DIRECTIONS)}"
        )
    return np.array([valid.index(word) - 1 for word in given], dtype=np.int64)


def _spread(read: _Reader, anchors: int, count: int) -> Floats:
    """(A, K, K) the covariances; a table (A, K) holds the variances alone."""
    if read.arrays.get("anchor_spread", np.zeros(0)).ndim == 2:
        return np.stack([np.diag(row) for row in read.array("anchor_spread", (anchors, count))])
    return read.array("anchor_spread", (anchors, count, count))
