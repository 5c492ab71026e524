"""Crash pulses as CSV: time and acceleration with their units in the header."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.motions.number_rows import Clock, number_rows, numbered_lines
from workbench.model.pulse import STANDARD_GRAVITY, Pulse, table_pulse

__all__ = ["read_pulse"]

_TIME = {"ms": 1e-3, "s": 1.0}
_LEVEL = {"g": STANDARD_GRAVITY, "m/s2": 1.0}
_UNITS = {"time": _TIME, "acceleration": _LEVEL}
_SMALL = 0.01


def read_pulse(path: Path, *, start: float = 0.0) -> Pulse:
    """A table `time [ms], acceleration [g]` (or [s], [m/s2]; lines with # are left out) as a pulse.

    InputError with the line where a value is no finite number or time goes back, and where the
    pulse does not begin and end at 0 (within 1 % of its peak).
    """
    lines = (
        (n, line)
        for n, line in numbered_lines(path)
        if line.strip() and not line.lstrip().startswith("#")
    )
    number, head = next(lines, (1, ""))
    scale = [
        _unit(path, number, word.strip(), name)
        for word, name in zip([*head.split(","), "", ""][:2], _UNITS, strict=True)
    ]
    rows = ((n, [word.strip() for word in line.split(",")]) for n, line in lines)
    values, _, numbers = number_rows(path, rows, 2, rows=list(_UNITS), clock=Clock(None, 1.0))
    if len(values) < 3:
        raise InputError(f"{path}: a pulse needs 3 samples or more, got {len(values)}")
    time = values[:, 0] * scale[0]
    level = values[:, 1] * scale[1]
    back = np.flatnonzero(np.diff(time) <= 0)
    if len(back):
        raise InputError(
            f"{path}, line {numbers[int(back[0]) + 1]}: time goes back or stands still, from "
            f"{values[back[0], 0]:g} to {values[back[0] + 1, 0]:g}"
        )
    most = np.abs(level).max()
    for which, k in (("begin", 0), ("end", -1)):
        if abs(level[k]) > _SMALL * most:
            unit = re.sub(r".*\[|\].*", "", head.split(",")[1])
            raise InputError(
                f"{path}, line {numbers[k]}: the pulse does not {which} at 0: {values[k, 1]:g} {unit} at "
                f"{1000 * time[k]:g} ms; give it whole"
            )
    return table_pulse(time, level, start=start)


def _unit(path: Path, number: int, word: str, name: str) -> float:
    found = re.fullmatch(rf"{name}\s*\[\s*(\S+)\s*\]", word)
    units = _UNITS[name]
    if not found or found[1] not in units:
        valid = " or ".join(f"'{name} [{unit}]'" for unit in units)
        raise InputError(f"{path}, line {number}: the header needs a column {valid}, got {word!r}")
    return units[found[1]]
