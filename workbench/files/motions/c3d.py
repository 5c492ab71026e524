"""Read the points of C3D files: a header, parameters in groups, frames of points and samples.

Every size is checked against the length of the file before it is used. Integers and reals of all
three kinds of processor (Intel, DEC, MIPS) are read. Analogue samples are skipped.

References
----------
Motion Lab Systems (2008), The C3D File Format: User Guide.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError
from workbench.files.file_errors import read_whole
from workbench.model.arrays import Floats, Ints

__all__ = ["Points", "read_points"]

MAX_BYTES = 4 * 2**30
"""Largest file that is read."""
_BLOCK = 512
"""Bytes of a block, in which sections are counted."""
_KEY = 0x50
"""Second byte of every C3D file."""
_INTEL = 84
_DEC = 85
_MIPS = 86
_CHARACTERS = -1
_BYTES = 1
_INTEGERS = 2
_REALS = 4
_WIDTH = {_CHARACTERS: 1, _BYTES: 1, _INTEGERS: 2, _REALS: 4}


class _BrokenError(ValueError):
    """An error in the file, without its name."""


@dataclass(frozen=True)
class _Parameter:
    """A parameter of a group."""

    kind: int
    """Type of its values, a key of `_WIDTH`."""
    dimensions: tuple[int, ...]
    """The first one runs fastest."""
    data: bytes


_Parameters = dict[tuple[str, str], _Parameter]
"""Parameters by the names of their group and their own."""


@dataclass(frozen=True, eq=False)
class Points:
    """The points of a C3D file, in its own unit."""

    labels: tuple[str, ...]
    """As many as the file names, not always one for each point."""
    unit: str
    rate: float
    """Frames per second."""
    first: int
    """Number of the first frame, from 0."""
    count: int
    """Number of points M."""
    screen: str
    """Axis that is upward on a screen, "" if it is not stated."""
    frames: np.ndarray[Any, Any]
    """(F, W) numbers as they stand in the file."""
    scale: float
    """Unit of integer coordinates; negative for reals."""
    decimal: bool
    """Whether DEC reals are still to be converted to IEEE 754."""
    notes: tuple[str, ...] = ()

    def position(self, rows: Ints) -> Floats:
        """Return positions (P, M, 3), in units of the file, of frames (P,); NaN for unseen points."""
        table = np.ascontiguousarray(self.frames[rows, : 4 * self.count])
        numbers = _from_dec(table) if self.decimal else table.astype(np.float64)
        values = numbers.reshape(len(rows), self.count, 4)
        position: Floats = values[..., :3] * (self.scale if self.scale > 0 else 1.0)
        with np.errstate(invalid="ignore"):
            unseen = ~(values[..., 3] >= 0)  # the residual is negative
            unseen |= ~np.isfinite(position).all(axis=-1)
        position[unseen] = np.nan
        return position


def read_points(path: Path, *, as_read: bool = False) -> Points:
    """Read the points of a C3D file.

    Parameters
    ----------
    path
        The file.
    as_read
        Whether a file that holds fewer frames than it announces is accepted.

    Raises
    ------
    InputError
        If it is no C3D file, is broken, or is shorter than it states.
    """
    data = read_whole(path, "a C3D file", most=MAX_BYTES)
    if len(data) < _BLOCK or data[1] != _KEY:
        raise InputError(f"{path}: is not a C3D file")
    try:
        return _points(data, as_read)
    except _BrokenError as error:
        raise InputError(f"{path}: broken C3D file: {error}") from None


@dataclass(frozen=True)
class _Header:
    """The first block of a file."""

    count: int
    """Number of points."""
    analogue: int
    """Number of analogue samples in a frame."""
    first: int
    """Number of the first frame, from 1."""
    last: int
    scale: float
    begin: int
    """First byte of the frames."""
    rate: float


def _points(data: bytes, as_read: bool) -> Points:
    start = (data[0] - 1) * _BLOCK
    if data[0] == 0 or start + 4 > len(data):
        raise _BrokenError("its parameters are not there")
    processor = data[start + 3]
    if processor not in (_INTEL, _DEC, _MIPS):
        raise _BrokenError(
            f"the kind of processor is {processor}, {_INTEL}, {_DEC} or {_MIPS} are known"
        )
    numbers = _Numbers(processor)
    parameters = _read_parameters(data, start, numbers)
    header = _read_header(data, numbers)
    frame_count = _frame_count(parameters, numbers, header.last - header.first + 1)
    scale_known = np.isfinite(header.scale) and header.scale != 0
    if not scale_known or header.begin < _BLOCK or frame_count < 0:
        raise _BrokenError("its header is senseless (scale, first frame, or where its data begin)")
    frames, notes = _read_frames(data, header, numbers, frame_count, as_read)
    return Points(
        labels=_labels(parameters),
        unit=next(iter(_texts(parameters.get(("POINT", "UNITS")))), ""),
        rate=numbers.number(parameters.get(("POINT", "RATE"))) or header.rate,
        first=header.first - 1,
        count=header.count,
        screen=next(iter(_texts(parameters.get(("POINT", "Y_SCREEN")))), ""),
        frames=frames,
        scale=header.scale,
        decimal=processor == _DEC and header.scale < 0,
        notes=notes,
    )


def _read_header(data: bytes, numbers: _Numbers) -> _Header:
    count, analogue, first, last = numbers.whole(data[2:10]).tolist()
    return _Header(
        count,
        analogue,
        first,
        last,
        scale=float(numbers.real(data[12:16])[0]),
        begin=(int(numbers.whole(data[16:18])[0]) - 1) * _BLOCK,
        rate=float(numbers.real(data[20:24])[0]),
    )


def _read_frames(
    data: bytes, header: _Header, numbers: _Numbers, count: int, as_read: bool
) -> tuple[np.ndarray[Any, Any], tuple[str, ...]]:
    """Return the numbers (F, W) of all frames, and a note if the file holds another number."""
    kind = np.dtype(numbers.order + ("i2" if header.scale > 0 else "f4"))
    width = 4 * header.count + header.analogue
    row_bytes = max(1, width * kind.itemsize)
    held = max(0, len(data) - header.begin) // row_bytes
    if count > held and not as_read:
        raise _BrokenError(
            f"cut short: it announces {count} frames and holds {held}; state frames: as_read in a "
            "study, or --frames as_read of workbench motion, to read those"
        )
    more = held - count - _BLOCK // row_bytes - 1  # the last block is filled up
    notes: tuple[str, ...] = ()
    if count > held:
        notes = (f"its header says {count} frames, {held} are there and are read",)
        count = held
    elif more > 0:
        notes = (f"holds {more} frames more than it announces: they are left out",)
    return np.frombuffer(data, kind, count * width, header.begin).reshape(count, width), notes


def _frame_count(parameters: _Parameters, numbers: _Numbers, stated: int) -> int:
    """Return the number of frames.

    The header counts to 65535, so some programs count on in parameters.
    """
    ends = [parameters.get(("TRIAL", f"ACTUAL_{end}_FIELD")) for end in ("START", "END")]
    if all(end is not None and end.kind == _INTEGERS and len(end.data) >= 4 for end in ends):
        low, high = (
            int(pair[0]) + 65536 * int(pair[1])
            for pair in (numbers.whole(end.data[:4]) for end in ends if end)
        )
        return high - low + 1
    long = numbers.number(parameters.get(("POINT", "LONG_FRAMES")))
    if long > 0:
        return int(long)
    short = parameters.get(("POINT", "FRAMES"))
    more = numbers.number(short)
    return int(more) if short is not None and short.kind == _REALS and more > 65535 else stated


class _Numbers:
    """Numbers in the byte order of a processor."""

    def __init__(self, processor: int) -> None:
        self.order = ">" if processor == _MIPS else "<"
        self.decimal = processor == _DEC

    def whole(self, data: bytes) -> Ints:
        """Read unsigned 16-bit integers."""
        return np.frombuffer(data, self.order + "u2").astype(np.int64)

    def real(self, data: bytes) -> Floats:
        """Read 32-bit reals."""
        values = np.frombuffer(data, self.order + "f4")
        return _from_dec(values) if self.decimal else values.astype(np.float64)

    def number(self, parameter: _Parameter | None) -> float:
        """Return the first value of a parameter, 0 if it is absent or not finite."""
        if parameter is None or len(parameter.data) < _WIDTH[parameter.kind]:
            return 0.0
        if parameter.kind == _INTEGERS:
            return float(self.whole(parameter.data[:2])[0])
        value = float(self.real(parameter.data[:4])[0]) if parameter.kind == _REALS else 0.0
        return value if np.isfinite(value) else 0.0


def _from_dec(values: np.ndarray[Any, Any]) -> Floats:
    """Convert VAX F floating to IEEE 754: with its two words swapped it is four times the number."""
    words = np.ascontiguousarray(values).view("<u2").reshape(*values.shape, 2)
    turned = np.ascontiguousarray(words[..., ::-1]).view("<f4")[..., 0].astype(np.float64) / 4
    return np.where(words[..., 0] == 0, 0.0, turned)


def _read_parameters(data: bytes, start: int, numbers: _Numbers) -> _Parameters:
    """Read the section of parameters, which starts at byte `start`."""
    end = min(len(data), start + _BLOCK * max(1, data[start + 2]))
    groups: dict[int, str] = {}
    found: dict[tuple[int, str], _Parameter] = {}
    at = start + 4
    while at + 2 <= end:
        length = abs(_signed(data[at]))
        group = _signed(data[at + 1])
        name = data[at + 2 : at + 2 + length].decode("latin-1").upper().strip()
        at += 2 + length
        if not length or at + 2 > end:
            break
        step = int(numbers.whole(data[at : at + 2])[0])
        if group < 0:
            groups[-group] = name
        else:
            found[group, name] = _parameter(data[at + 2 : end], name)
        if not step:
            break
        at += step
    return {(groups.get(group, ""), name): parameter for (group, name), parameter in found.items()}


def _parameter(data: bytes, name: str) -> _Parameter:
    kind = _signed(data[0]) if data else 0
    if kind not in _WIDTH or len(data) < 2 or len(data) < 2 + data[1]:
        raise _BrokenError(f"parameter {name!r} is of no known type, or cut short")
    dimensions = tuple(data[2 : 2 + data[1]])
    size = _WIDTH[kind]
    for dimension in dimensions:
        size *= dimension
    begin = 2 + len(dimensions)
    if size > len(data) - begin:
        raise _BrokenError(
            f"parameter {name!r} announces {size} bytes and {len(data) - begin} are there"
        )
    return _Parameter(kind, dimensions, data[begin : begin + size])


def _signed(byte: int) -> int:
    return byte - 256 if byte > 127 else byte


def _labels(parameters: _Parameters) -> tuple[str, ...]:
    """Return the labels of the points; those that one parameter cannot hold (255) go on in LABELS2
    and so forth."""
    labels = list(_texts(parameters.get(("POINT", "LABELS"))))
    number = 2
    while ("POINT", f"LABELS{number}") in parameters:
        labels += _texts(parameters["POINT", f"LABELS{number}"])
        number += 1
    return tuple(labels)


def _texts(parameter: _Parameter | None) -> tuple[str, ...]:
    """Return the texts of a parameter of characters; its first dimension is their length."""
    if parameter is None or parameter.kind != _CHARACTERS or not parameter.data:
        return ()
    width = parameter.dimensions[0] if parameter.dimensions else 1
    rows = (parameter.data[k : k + width] for k in range(0, len(parameter.data), width))
    return tuple(_text(row) for row in rows)


def _text(row: bytes) -> str:
    try:
        text = row.decode("utf-8")
    except UnicodeDecodeError:
        text = row.decode("latin-1")
    return text.strip(" \0")
