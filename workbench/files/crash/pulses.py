"""Crash pulses as CSV: time and acceleration with their units in the header."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.motions.number_rows import Clock, number_rows, numbered_lines
from workbench.model.arrays import Floats, Ints
from workbench.model.pulse import STANDARD_GRAVITY, Pulse, table_pulse

__all__ = ["read_pulse"]

_TIME = {"ms": 1e-3, "s": 1.0}
_LEVEL = {"g": STANDARD_GRAVITY, "m/s2": 1.0}
_UNITS = {"time": _TIME, "acceleration": _LEVEL}
_SMALL = 0.01


def read_pulse(path: Path, *, start: float = 0.0) -> Pulse:
    """Read a table `time [ms], acceleration [g]` (or [s], [m/s2]) as a pulse.

    Lines with # are left out.

    Raises
    ------
    InputError
        With the line where a value is no finite number or time goes back, and where the pulse does
        not begin and end at 0 (within 1 % of its peak).
    """
    lines = _data_lines(path)
    number, head = next(lines, (1, ""))
    words = [word.strip() for word in [*head.split(","), "", ""][:2]]
    seconds, metres = (
        _unit(path, number, word, name) for word, name in zip(words, _UNITS, strict=True)
    )
    rows = ((n, [word.strip() for word in line.split(",")]) for n, line in lines)
    table = number_rows(path, rows, 2, rows=list(_UNITS), clock=Clock(None, 1.0))
    values = table.values
    numbers = table.lines
    if len(values) < 3:
        raise InputError(f"{path}: a pulse needs 3 samples or more, got {len(values)}")
    _check_time(path, values[:, 0], numbers)
    time = values[:, 0] * seconds
    level = values[:, 1] * metres
    for which, k in (("begin", 0), ("end", -1)):
        if abs(level[k]) > _SMALL * np.abs(level).max():
            unit = re.sub(r".*\[|\].*", "", words[1])
            raise InputError(
                f"{path}, line {numbers[k]}: the pulse does not {which} at 0: {values[k, 1]:g} {unit} at "
                f"{1000 * time[k]:g} ms; give it whole"
            )
    return table_pulse(time, level, start=start)


def _data_lines(path: Path) -> Iterator[tuple[int, str]]:
    """The lines of a file with their numbers, but for empty ones and those with #."""
    for number, line in numbered_lines(path):
        if line.strip() and not line.lstrip().startswith("#"):
            yield number, line


def _check_time(path: Path, time: Floats, numbers: Ints) -> None:
    """Raise where the time (T,) of a table does not rise. numbers: the line of each sample."""
    back = np.flatnonzero(np.diff(time) <= 0)
    if len(back):
        k = int(back[0])
        raise InputError(
            f"{path}, line {numbers[k + 1]}: time goes back or stands still, from "
            f"{time[k]:g} to {time[k + 1]:g}"
        )


def _unit(path: Path, number: int, word: str, name: str) -> float:
    found = re.fullmatch(rf"{name}\s*\[\s*(\S+)\s*\]", word)
    units = _UNITS[name]
    if not found or found[1] not in units:
        valid = " or ".join(f"'{name} [{unit}]'" for unit in units)
        raise InputError(f"{path}, line {number}: the header needs a column {valid}, got {word!r}")
    return units[found[1]]
