"""C3D: a header, parameters in groups, and frames of points and analogue samples; of these the
points are read.

Every size is checked against the length of the file before it is used. Whole and real numbers of
all three kinds of processor (Intel, DEC, MIPS) are read.

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
from workbench.files.opening import read_whole
from workbench.model.arrays import Floats, Ints

__all__ = ["Points", "read_points"]

MAX_BYTES = 4 * 2**30
_BLOCK = 512
_KEY = 0x50
_INTEL = 84
_DEC = 85
_MIPS = 86
_CHARACTERS = -1
_BYTES = 1
_INTEGERS = 2
_REALS = 4
_WIDTH = {_CHARACTERS: 1, _BYTES: 1, _INTEGERS: 2, _REALS: 4}


class _BrokenError(ValueError):
    """What is wrong in the file, without its name."""


@dataclass(frozen=True)
class _Parameter:
    """A parameter: the type of its values, their dimensions (the first runs fastest), their
    bytes."""

    kind: int
    dimensions: tuple[int, ...]
    data: bytes


@dataclass(frozen=True, eq=False)
class Points:
    """The points of a C3D file, in its own unit.

    labels: as many as the file names, not always one a point; frames: (F, W) numbers as they stand
    in the file; first: number of the first frame, from 0; screen: the axis that is upward on a
    screen, "" where it is not told.
    """

    labels: tuple[str, ...]
    unit: str
    rate: float
    first: int
    count: int
    screen: str
    frames: np.ndarray[Any, Any]
    scale: float
    decimal: bool
    """Whether DEC real numbers are still to be turned into IEEE 754."""
    notes: tuple[str, ...] = ()

    def position(self, rows: Ints) -> Floats:
        """(P, M, 3) places in some frames [units of the file]; NaN where a point was not seen."""
        table = np.ascontiguousarray(self.frames[rows, : 4 * self.count])
        values = (_from_dec(table) if self.decimal else table.astype(np.float64)).reshape(
            len(rows), self.count, 4
        )
        found: Floats = values[..., :3] * (self.scale if self.scale > 0 else 1.0)
        with np.errstate(invalid="ignore"):
            unseen = (
                ~(values[..., 3] >= 0)
                | np.all(found == 0, axis=-1)
                | ~np.isfinite(found).all(axis=-1)
            )
        found[unseen] = np.nan
        return found


def read_points(path: Path) -> Points:
    """Read the points of a C3D file. InputError where it is none, is broken, or is shorter than it
    announces."""
    data = read_whole(path, "a C3D file", most=MAX_BYTES)
    if len(data) < _BLOCK or data[1] != _KEY:
        raise InputError(f"{path}: is not a C3D file")
    try:
        return _points(data)
    except _BrokenError as error:
        raise InputError(f"{path}: broken C3D file: {error}") from None


def _points(data: bytes) -> Points:
    start = (data[0] - 1) * _BLOCK
    if data[0] == 0 or start + 4 > len(data):
        raise _BrokenError("its parameters are not there")
    processor = data[start + 3]
    if processor not in (_INTEL, _DEC, _MIPS):
        raise _BrokenError(
            f"the kind of processor is {processor}, {_INTEL}, {_DEC} or {_MIPS} are known"
        )
    numbers = _Numbers(processor)
    known = _parameters(data, start, numbers)
    count, analogue, first, last = numbers.whole(data[2:10])
    scale = float(numbers.real(data[12:16])[0])
    begin = (int(numbers.whole(data[16:18])[0]) - 1) * _BLOCK
    frames = _frame_count(known, numbers, int(last) - int(first) + 1)
    if not np.isfinite(scale) or scale == 0 or begin < _BLOCK or frames < 0:
        raise _BrokenError("its header is senseless (scale, first frame, or where its data begin)")
    kind = np.dtype(numbers.order + ("i2" if scale > 0 else "f4"))
    width = 4 * int(count) + int(analogue)
    have = max(0, len(data) - begin) // max(1, width * kind.itemsize)
    if frames > have:
        raise _BrokenError(f"cut short: it announces {frames} frames and holds {have}")
    more = (
        have - frames - _BLOCK // max(1, width * kind.itemsize) - 1
    )  # the last block of 512 bytes is filled up
    rate = numbers.number(known.get(("POINT", "RATE"))) or float(numbers.real(data[20:24])[0])
    return Points(
        labels=_labels(known),
        unit=next(iter(_texts(known.get(("POINT", "UNITS")))), ""),
        rate=rate,
        first=int(first) - 1,
        count=int(count),
        screen=next(iter(_texts(known.get(("POINT", "Y_SCREEN")))), ""),
        frames=np.frombuffer(data, kind, frames * width, begin).reshape(frames, width),
        scale=scale,
        decimal=processor == _DEC and scale < 0,
        notes=(f"holds {more} frames more than it announces: they are left out",)
        if more > 0
        else (),
    )


def _frame_count(known: dict[tuple[str, str], _Parameter], numbers: _Numbers, told: int) -> int:
    """Frames of the file: the header counts to 65535, so parameters of some programs count on."""
    ends = [known.get(("TRIAL", f"ACTUAL_{end}_FIELD")) for end in ("START", "END")]
    if all(end is not None and end.kind == _INTEGERS and len(end.data) >= 4 for end in ends):
        low, high = (
            int(pair[0]) + 65536 * int(pair[1])
            for pair in (numbers.whole(end.data[:4]) for end in ends if end)
        )
        return high - low + 1
    long = numbers.number(known.get(("POINT", "LONG_FRAMES")))
    if long > 0:
        return int(long)
    short = known.get(("POINT", "FRAMES"))
    more = numbers.number(short)
    return int(more) if short is not None and short.kind == _REALS and more > 65535 else told


class _Numbers:
    """Numbers in the byte order of a processor."""

    def __init__(self, processor: int) -> None:
        self.order = ">" if processor == _MIPS else "<"
        self.decimal = processor == _DEC

    def whole(self, data: bytes) -> Ints:
        """16-bit whole numbers without a sign."""
        return np.frombuffer(data, self.order + "u2").astype(np.int64)

    def real(self, data: bytes) -> Floats:
        """32-bit real numbers."""
        values = np.frombuffer(data, self.order + "f4")
        return _from_dec(values) if self.decimal else values.astype(np.float64)

    def number(self, parameter: _Parameter | None) -> float:
        """The first value of a parameter of numbers, 0 where it is not there or is not finite."""
        if parameter is None or len(parameter.data) < _WIDTH[parameter.kind]:
            return 0.0
        if parameter.kind == _INTEGERS:
            return float(self.whole(parameter.data[:2])[0])
        value = float(self.real(parameter.data[:4])[0]) if parameter.kind == _REALS else 0.0
        return value if np.isfinite(value) else 0.0


def _from_dec(values: np.ndarray[Any, Any]) -> Floats:
    """Numbers of IEEE 754 from VAX F floating: its two words the other way round are four times the
    number."""
    words = np.ascontiguousarray(values).view("<u2").reshape(*values.shape, 2)
    turned = np.ascontiguousarray(words[..., ::-1]).view("<f4")[..., 0].astype(np.float64) / 4
    return np.where(words[..., 0] == 0, 0.0, turned)


def _parameters(data: bytes, start: int, numbers: _Numbers) -> dict[tuple[str, str], _Parameter]:
    """Parameters by the names of their group and their own."""
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


def _labels(known: dict[tuple[str, str], _Parameter]) -> tuple[str, ...]:
    """The labels of the points: those that one parameter cannot hold (255) go on in LABELS2 and so
    forth."""
    labels = list(_texts(known.get(("POINT", "LABELS"))))
    number = 2
    while ("POINT", f"LABELS{number}") in known:
        labels += _texts(known["POINT", f"LABELS{number}"])
        number += 1
    return tuple(labels)


def _texts(parameter: _Parameter | None) -> tuple[str, ...]:
    """Texts of a parameter of characters, as long as its first dimension says."""
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
