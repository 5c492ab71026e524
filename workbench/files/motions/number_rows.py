"""Text of motion files, line by line: numbered, of numbers only where numbers belong, never held
whole."""

from __future__ import annotations

import math
import re
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import TextIOWrapper
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError, UsageError, printable
from workbench.files.opening import opened
from workbench.model.arrays import Floats, Ints
from workbench.model.spool import Spool

__all__ = ["ALL", "MOST_NUMBERS", "Pick", "Rows", "count_in", "number_rows", "numbered"]

MOST_NUMBERS = 2_000_000_000
"""Numbers of one file that are kept at most (16 GB, in a temporary file)."""
_BLOCK = 2048
_LARGEST = 1e15
"""Numbers of a motion at most: far beyond any angle, length or time, and their squares are
finite."""
_COUNT = re.compile(r"[0-9]{1,9}(\.0*)?")


@dataclass(frozen=True)
class Pick:
    """Which frames of a file are kept: from `start` to `end` [s] on the file's clock, every
    `every`-th of them."""

    start: float = -np.inf
    end: float = np.inf
    every: int = 1

    def __post_init__(self) -> None:
        if self.every < 1:
            raise UsageError(f"every: 1 or more is needed, got {self.every}")
        if not self.start < self.end:
            raise UsageError(f"start {self.start:g} s must be before end {self.end:g} s")


ALL = Pick()


class Rows(NamedTuple):
    """Rows of numbers: values (P, width) of those that were wanted, how many there were in all, and
    the lines (P,) of those that were wanted."""

    values: Floats
    total: int
    lines: Ints


def numbered(path: Path) -> Iterator[tuple[int, str]]:
    """The lines of a text file with their numbers from 1, control characters escaped. InputError
    where it is missing, empty or no text."""
    empty = True
    with opened(path, "a motion file") as file:
        lines = TextIOWrapper(file, encoding="utf-8-sig", errors="replace", newline=None)
        for number, line in enumerate(lines, start=1):
            if "\x00" in line[:1000]:
                raise InputError(f"{path}, line {number}: is not text")
            empty = empty and not line.strip()
            yield number, printable(line.rstrip("\n"))
    if empty:
        raise InputError(f"{path}: is empty")


def count_in(word: str) -> int | None:
    """The number that a count in a header says; None where it is no whole number of up to nine
    digits."""
    return int(float(word)) if _COUNT.fullmatch(word) else None


def number_rows(
    path: Path,
    lines: Iterator[tuple[int, list[str]]],
    width: int,
    *,
    rows: Sequence[str] = (),
    blank: bool = False,
    keep: Pick = ALL,
    clock: tuple[int | None, float] = (0, 1.0),
) -> Rows:
    """Rows of `width` numbers (P, width), only those of `keep`; many are kept in a file
    (`workbench.model.spool`).

    lines: line numbers with the words of each line. blank: an empty word is a gap (NaN). clock: the
    column that holds the time and one unit of it [s], or None and the step between rows [s].
    InputError names line and column of what is no finite number, rows of another length, times that
    do not rise, and a file too long to keep.
    """
    column, unit = clock
    kept = Spool(width)
    wanted = array("q")
    block: list[list[float]] = []
    count = inside = 0
    before = -math.inf
    for number, words in lines:
        if len(words) != width:
            raise InputError(f"{path}, line {number}: {len(words)} values where {width} are needed")
        try:
            row = [float(word) if word or not blank else math.nan for word in words]
        except ValueError:
            row = []
        if not row or not _finite(row, words, blank):
            _refuse(path, number, words, rows)
        now = row[column] * unit if column is not None else count * unit
        count += 1
        if not now > before:
            _refuse_time(f"{path}, line {number}", count, now, before)
        before = now
        if not keep.start <= now <= keep.end:
            continue
        inside += 1
        if (inside - 1) % keep.every:
            continue
        block.append(row)
        wanted.append(number)
        if len(block) == _BLOCK:
            if len(wanted) * width > MOST_NUMBERS:
                raise InputError(
                    f"{path}: too long: read a part of it (start, end) or every n-th frame"
                )
            kept.add(np.array(block))
            block = []
    kept.add(np.array(block, dtype=np.float64).reshape(-1, width))
    return Rows(kept.done(), count, np.array(wanted, dtype=np.int64))


def _finite(row: list[float], words: Sequence[str], blank: bool) -> bool:
    """Whether a row holds only finite numbers of a size that can be reckoned with; empty words may
    be gaps."""
    given = [v for v, w in zip(row, words, strict=True) if w] if blank else row
    if not all(map(math.isfinite, given)):
        return False
    return max(given, default=0.0) <= _LARGEST and min(given, default=0.0) >= -_LARGEST


def _refuse_time(here: str, frame: int, now: float, before: float) -> None:
    if math.isnan(now):
        raise InputError(f"{here}: frame {frame} has no time")
    raise InputError(
        f"{here}: frames are out of order: frame {frame} is at {now:g} s, after frame {frame - 1} at "
        f"{before:g} s"
    )


def _refuse(path: Path, number: int, words: Sequence[str], rows: Sequence[str]) -> None:
    for k, word in enumerate(words):
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not abs(value) <= _LARGEST:
            where = f"column {k + 1}" + (f" ({rows[k]})" if k < len(rows) else "")
            what = (
                f"is too large (most: {_LARGEST:g})"
                if math.isfinite(value)
                else "is not a finite number"
            )
            raise InputError(f"{path}, line {number}, {where}: {word[:60]!r} {what}")
