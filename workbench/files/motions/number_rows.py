"""Read text files of numbers line by line, without holding a whole file in memory."""

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
from workbench.files.file_errors import opened
from workbench.model.arrays import Floats, GrowingArray, Ints

__all__ = [
    "ALL_FRAMES",
    "MAX_NUMBERS",
    "Clock",
    "FrameRange",
    "NumberRows",
    "number_rows",
    "numbered_lines",
    "parse_count",
]

MAX_NUMBERS = 2_000_000_000
"""Largest number of numbers kept of one file (16 GB, in a temporary file)."""
_BLOCK_ROWS = 2048
"""Rows that are converted to an array at once."""
_MAX_VALUE = 1e15
"""Largest value in a motion: far beyond any angle, length or time, and its square is finite."""
_COUNT = re.compile(r"[0-9]{1,9}(\.0*)?")


@dataclass(frozen=True)
class FrameRange:
    """Which frames of a file are kept."""

    start: float = -np.inf
    """First time [s]."""
    end: float = np.inf
    """Last time [s]."""
    every: int = 1
    """Keep every n-th of them."""
    as_read: bool = False
    """Accept a file that holds another number of frames than its header states."""

    def __post_init__(self) -> None:
        if self.every < 1:
            raise UsageError(f"every: 1 or more is needed, got {self.every}")
        if not self.start < self.end:
            raise UsageError(f"start {self.start:g} s must be before end {self.end:g} s")

    def frame_count_notes(self, where: str, stated: int | None, count: int) -> tuple[str, ...]:
        """Compare the number of frames that a header states with the number of rows.

        Parameters
        ----------
        where
            The file and the line of the header, for messages.
        stated
            The number in the header, None if it is no number.
        count
            The number of rows.

        Returns
        -------
        tuple of str
            A note on a wrong number that is accepted.

        Raises
        ------
        InputError
            If the numbers differ and `as_read` is not set.
        """
        if stated == count:
            return ()
        said = f"{stated} frames" if stated is not None else "no number of frames"
        if self.as_read:
            return (f"its header says {said}, {count} are there and are read",)
        raise InputError(
            f"{where}: says {said}, {count} are there; state frames: as_read in a study, or "
            "--frames as_read of workbench motion, to read those that are there"
        )


ALL_FRAMES = FrameRange()


class Clock(NamedTuple):
    """Where the time of a row is."""

    column: int | None = 0
    """Index of the column with the time, None for rows at equal steps."""
    unit: float = 1.0
    """Unit of the column, or the step between rows [s]."""

    def time(self, row: Sequence[float], count: int) -> float:
        """Return the time [s] of a row that `count` rows precede."""
        return (row[self.column] if self.column is not None else count) * self.unit


class NumberRows(NamedTuple):
    """Rows of numbers."""

    values: Floats
    """(P, width) of the frames that are kept."""
    total: int
    """Number of rows of the file."""
    lines: Ints
    """(P,) line numbers of the frames that are kept."""
    notes: tuple[str, ...] = ()
    """What was left out."""


def numbered_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines of a text file with their numbers from 1, control characters escaped.

    Raises
    ------
    InputError
        If the file is missing, empty or no text.
    """
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


def parse_count(word: str) -> int | None:
    """Return a count of a header, None if it is no whole number of up to nine digits."""
    return int(float(word)) if _COUNT.fullmatch(word) else None


def number_rows(
    path: Path,
    lines: Iterator[tuple[int, list[str]]],
    width: int,
    *,
    rows: Sequence[str] = (),
    blank: bool = False,
    keep: FrameRange = ALL_FRAMES,
    clock: Clock | None = None,
) -> NumberRows:
    """Read rows of numbers; many of them are kept in a file (`workbench.model.arrays`).

    Parameters
    ----------
    path
        The file, for messages.
    lines
        Line number and words of each line.
    width
        Numbers in each row.
    rows
        Names of the columns, for messages.
    blank
        Whether an empty word, or NaN, is a gap.
    keep
        The frames that are wanted.
    clock
        Where the time of a row is; if None the first column, in seconds.

    Raises
    ------
    InputError
        With line and column, if a word is no finite number, a row has another length, times do not
        rise (the last row may repeat the time before it: it is left out), or the file is too long to keep.
    """
    clock = clock or Clock()
    kept = GrowingArray(width)
    wanted = array("q")
    block: list[list[float]] = []
    count = in_range = 0
    last_time = -math.inf
    repeated = 0  # line of a row at the time of the row before it
    for number, words in lines:
        row = _parse_row(path, number, words, width, rows, blank)
        time = clock.time(row, count)
        count += 1
        if repeated:
            _refuse_time(f"{path}, line {repeated}", count - 1, last_time, last_time)
        if not time >= last_time:
            _refuse_time(f"{path}, line {number}", count, time, last_time)
        if time == last_time:
            repeated = number
            continue
        last_time = time
        if not keep.start <= time <= keep.end:
            continue
        in_range += 1
        if (in_range - 1) % keep.every:
            continue
        block.append(row)
        wanted.append(number)
        if len(block) == _BLOCK_ROWS:
            if len(wanted) * width > MAX_NUMBERS:
                raise InputError(
                    f"{path}: too long: read a part of it, or every n-th frame "
                    "(start, end and every in a study, --start, --end and --every)"
                )
            kept.add(np.array(block))
            block = []
    kept.add(np.array(block, dtype=np.float64).reshape(-1, width))
    notes: tuple[str, ...] = ()
    if repeated:
        notes = (f"line {repeated}, the last one, repeats the time of the line before: left out",)
    return NumberRows(kept.done(), count, np.array(wanted, dtype=np.int64), notes)


def _parse_row(
    path: Path, number: int, words: list[str], width: int, rows: Sequence[str], blank: bool
) -> list[float]:
    """Return the numbers of a line; see `number_rows`."""
    if len(words) != width:
        raise InputError(f"{path}, line {number}: {len(words)} values where {width} are needed")
    try:
        row = [float(word) if word or not blank else math.nan for word in words]
    except ValueError:
        row = []
    if not row or not _finite(row, blank):
        _refuse_number(path, number, words, rows)
    return row


def _finite(row: list[float], blank: bool) -> bool:
    """Return whether a row holds only finite numbers up to `_MAX_VALUE`; some may be gaps."""
    given = [value for value in row if not math.isnan(value)] if blank else row
    if not all(map(math.isfinite, given)):
        return False
    return max(given, default=0.0) <= _MAX_VALUE and min(given, default=0.0) >= -_MAX_VALUE


def _refuse_time(here: str, frame: int, time: float, before: float) -> None:
    """Raise the error for a time that does not rise."""
    if math.isnan(time):
        raise InputError(f"{here}: frame {frame} has no time")
    raise InputError(
        f"{here}: frames are out of order: frame {frame} is at {time:g} s, after frame {frame - 1} at "
        f"{before:g} s"
    )


def _refuse_number(path: Path, number: int, words: Sequence[str], rows: Sequence[str]) -> None:
    """Raise the error for the first word that is no finite number."""
    for k, word in enumerate(words):
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not abs(value) <= _MAX_VALUE:
            where = f"column {k + 1}" + (f" ({rows[k]})" if k < len(rows) else "")
            what = (
                f"is too large (most: {_MAX_VALUE:g})"
                if math.isfinite(value)
                else "is not a finite number"
            )
            raise InputError(f"{path}, line {number}, {where}: {word[:60]!r} {what}")
