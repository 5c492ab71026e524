"""Marker files: TRC (tabs or commas) and C3D, as markers in metres, z up."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.files.motions.c3d import read_points
from workbench.files.motions.number_rows import ALL, Pick, count_in, number_rows, numbered
from workbench.files.names import unique_names
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats
from workbench.model.motion import Markers

__all__ = ["read_c3d", "read_trc"]

_MOST_NUMBERS = 100_000_000
"""Numbers of markers that are held in memory at most (0.8 GB, a few times over)."""
_LOW = re.compile(r"heel|hee|hel|ank|toe|mt\d|foo|calc|malleol")
_HIGH = re.compile(
    r"asi|psi|head|fhd|bhd|c7|t10|shoulder|sho|fsh|acrom|clav|strn|stern|iliac|wt$|gtr|hip|sacr"
)


def read_trc(path: str | Path, *, up: str | None = None, keep: Pick = ALL) -> Markers:
    """Markers of a TRC file; empty cells are gaps. up: the file's upward axis; where None, the one
    along which hips and head are above the feet.

    InputError with the line for a broken header, counts that are not so, rows of another length.
    """
    source = Path(path)
    lines = numbered(source)
    about, names = _trc_head(source, lines)
    unit = str(about.get("units", ""))
    if unit not in metres_in:
        raise InputError(
            f"{source}, line 3: unit {unit!r} is not known; valid: {', '.join(metres_in)}"
        )
    width = 2 + 3 * len(names)
    rows = ((number, _padded(line, width)) for number, line in lines if line.strip())
    columns = ["frame", "time", *(f"{name} {axis}" for name in names for axis in "XYZ")]
    table, count, _ = number_rows(
        source, rows, width, rows=columns, blank=True, keep=keep, clock=(1, 1.0)
    )
    if table.size > _MOST_NUMBERS:
        raise InputError(
            f"{source}: too long to solve at once: read a part of it (start, end) or every n-th frame"
        )
    said = about.get("numframes", str(count))
    if count_in(said) != count:
        raise InputError(f"{source}, line 3: says {said[:20]} frames, {count} are there")
    if not len(table):
        raise InputError(f"{source}: no frame between {keep.start:g} and {keep.end:g} s")
    position = table[:, 2:].reshape(len(table), len(names), 3) * metres_in[unit]
    position[np.isnan(position).any(axis=-1)] = (
        np.nan
    )  # a marker without one of its coordinates is a gap
    return _markers(source, names, position, (table[:, 1], up, ""))


def read_c3d(path: str | Path, *, up: str | None = None, keep: Pick = ALL) -> Markers:
    """Markers of a C3D file; what was not seen is a gap, repeated labels are numbered.

    up as in `read_trc`; the file's own Y_SCREEN goes before the guess. InputError for a broken file
    or one without markers.
    """
    source = Path(path)
    found = read_points(source)
    if found.count == 0 or len(found.frames) == 0:
        raise InputError(f"{source}: holds no marker")
    if found.unit not in metres_in or not found.rate > 0:
        raise InputError(
            f"{source}: POINT:UNITS is {found.unit!r}, POINT:RATE is {found.rate:g}: a unit of length and "
            "a rate are needed"
        )
    time = (found.first + np.arange(len(found.frames))) / found.rate
    rows = np.flatnonzero((time >= keep.start) & (time <= keep.end))[:: keep.every]
    if not len(rows):
        raise InputError(f"{source}: no frame between {keep.start:g} and {keep.end:g} s")
    if len(rows) * found.count * 3 > _MOST_NUMBERS:
        raise InputError(
            f"{source}: too long to solve at once: read a part of it (start, end) or every n-th frame"
        )
    labels = [*found.labels, *(f"marker {k + 1}" for k in range(len(found.labels), found.count))][
        : found.count
    ]
    position = found.position(rows) * metres_in[found.unit]
    made = _markers(source, labels, position, (time[rows], up, found.screen.lower().lstrip("+")))
    return replace(made, notes=(*found.notes, *made.notes))


def _trc_head(path: Path, lines: Iterator[tuple[int, str]]) -> tuple[dict[str, str], list[str]]:
    """What the header says, by its names in lower case, and the markers' names; the line of X1 Y1
    Z1 is passed."""
    head: list[list[str]] = []
    for number, line in lines:
        head.append([word.strip() for word in _cells(line)])
        if len(head) == 1 and not line.startswith("PathFileType"):
            raise InputError(f"{path}, line {number}: a TRC file begins with PathFileType")
        if len(head) == 5:
            break
    if len(head) < 5:
        raise InputError(f"{path}: ends within its header: cut short")
    about = {key.lower(): value for key, value in zip(head[1], head[2], strict=False)}
    names = [word for word in head[3][2:] if word]
    said = about.get("nummarkers", "")
    if not names or count_in(said) != len(names):
        raise InputError(f"{path}, line 3: says {said or 'no'} markers, line 4 names {len(names)}")
    return about, names


def _cells(line: str) -> list[str]:
    return line.split("\t" if "\t" in line else ",")


def _padded(line: str, width: int) -> list[str]:
    """The cells of a row, with those that are empty at its end filled up or left off."""
    cells = [cell.strip() for cell in _cells(line)]
    while len(cells) > width and not cells[-1]:
        cells.pop()
    return cells + [""] * (width - len(cells)) if len(cells) >= 2 else cells


def _markers(
    path: Path, labels: list[str], position: Floats, about: tuple[Floats, str | None, str]
) -> Markers:
    time, up, told = about
    names = unique_names(labels, "marker")
    notes = []
    twice = [label for label, count in Counter(labels).items() if count > 1]
    if twice:
        notes.append(f"markers of the same name are numbered: {', '.join(twice)}")
    axis = up or told or _upward(names, position)
    if not up:
        notes.append(f"up is {axis} of the file" + ("" if told else ", as the markers lie"))
    return Markers(tuple(names), position @ _turn(axis).T, time, str(path), tuple(notes))


def _upward(names: list[str], position: Floats) -> str:
    """The axis along which the markers of head and hips lie above those of the feet."""
    middle = np.array(
        [
            np.nanmedian(p, axis=0) if np.isfinite(p).any() else np.full(3, np.nan)
            for p in position.swapaxes(0, 1)
        ]
    )
    plain = [re.sub(r"[^a-z0-9]", "", name.rsplit(":", 1)[-1].lower()) for name in names]
    known = np.isfinite(middle[:, 0])
    low = np.array([bool(_LOW.search(name)) for name in plain]) & known
    high = np.array([bool(_HIGH.search(name)) for name in plain]) & known & ~low
    if not low.any() or not high.any():
        raise InputError(
            "the upward axis cannot be told from the markers' names: state it (up: x, y, z, -x, -y or -z)"
        )
    rise = middle[high].mean(axis=0) - middle[low].mean(axis=0)
    k = int(np.argmax(np.abs(rise)))
    return ("-" if rise[k] < 0 else "") + "xyz"[k]


def _turn(up: str) -> Floats:
    """(3, 3) the turn that lays the file's upward axis along z, by the shortest way."""
    if up.lstrip("-") not in ("x", "y", "z"):
        raise UsageError(f"up: {up!r} is not an axis; valid: x, y, z, -x, -y, -z")
    axis = (-1.0 if up.startswith("-") else 1.0) * np.eye(3)["xyz".index(up[-1])]
    if axis[2]:
        return np.diag([1.0, axis[2], axis[2]])
    side = np.cross(axis, [0.0, 0.0, 1.0])
    before = np.array([side, np.cross(axis, side), axis])
    return np.asarray(np.array([side, np.cross([0.0, 0.0, 1.0], side), [0.0, 0.0, 1.0]]).T @ before)
