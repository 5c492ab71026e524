"""Read marker files, TRC (tabs or commas) and C3D, as markers in metres with z up."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError, UsageError
from workbench.files.motions.c3d import Points, read_points
from workbench.files.motions.number_rows import (
    ALL_FRAMES,
    Clock,
    FrameRange,
    number_rows,
    numbered_lines,
    parse_count,
)
from workbench.files.names import unique_names
from workbench.files.schema import metres_in
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.motion import Markers

__all__ = ["read_c3d", "read_trc", "without_missing"]

_MAX_NUMBERS = 100_000_000
"""Largest number of marker coordinates held in memory (0.8 GB, a few times over)."""
_LOW = re.compile(r"heel|hee|hel|ank|toe|mt\d|foo|calc|malleol")
"""Parts of the names of markers on the feet."""
_HIGH = re.compile(
    r"asi|psi|head|fhd|bhd|c7|t10|shoulder|sho|fsh|acrom|clav|strn|stern|iliac|wt$|gtr|hip|sacr"
)
"""Parts of the names of markers on hips, trunk and head."""


def read_trc(
    path: str | Path,
    *,
    up: str | None = None,
    metres: float | None = None,
    keep: FrameRange = ALL_FRAMES,
) -> Markers:
    """Read the markers of a TRC file; empty cells, NaN and 0, 0, 0 are gaps.

    Parameters
    ----------
    path
        The file.
    up
        Upward axis of the file. If None, the axis along which hips and head are above the feet.
    metres
        One unit of the file [m]; if None it is the stated one.
    keep
        The frames that are wanted.

    Raises
    ------
    InputError
        With the line, if the header is broken, a count is wrong, or a row has another length.
    """
    source = Path(path)
    lines = numbered_lines(source)
    header, names = _trc_header(source, lines)
    unit = metres or _stated_unit(f"{source}, line 3: Units", header.get("units", ""))
    table, notes = _trc_numbers(source, lines, header, names, keep)
    position = table[:, 2:].reshape(len(table), len(names), 3) * unit
    position[np.isnan(position).any(axis=-1)] = np.nan  # one coordinate missing: a gap
    markers = _markers(source, names, position, table[:, 1], up=up, stated_up="")
    return replace(markers, notes=(*notes, *markers.notes))


def _trc_numbers(
    path: Path,
    lines: Iterator[tuple[int, str]],
    header: dict[str, str],
    names: list[str],
    keep: FrameRange,
) -> tuple[Floats, tuple[str, ...]]:
    """Read the frame, the time and the coordinates (P, 2 + 3 M) of the frames that are kept, NaN in
    empty cells; and a note on a number of frames that is wrong and accepted."""
    width = 2 + 3 * len(names)
    cells = ((number, _padded(line, width)) for number, line in lines if line.strip())
    columns = ["frame", "time", *(f"{name} {axis}" for name in names for axis in "XYZ")]
    rows = number_rows(path, cells, width, rows=columns, blank=True, keep=keep, clock=Clock(1, 1.0))
    table = rows.values
    count = rows.total
    stated = parse_count(header.get("numframes", str(count)))
    notes = rows.notes + keep.frame_count_notes(f"{path}, line 3", stated, count)
    _check_frames(path, len(table), table.size, keep)
    return table, notes


def read_c3d(
    path: str | Path,
    *,
    up: str | None = None,
    metres: float | None = None,
    keep: FrameRange = ALL_FRAMES,
) -> Markers:
    """Read the markers of a C3D file; what was not seen is a gap, repeated labels are numbered.

    Parameters
    ----------
    path
        The file.
    up
        Upward axis of the file. If None, the file's Y_SCREEN, otherwise as in `read_trc`.
    metres
        One unit of the file [m]; if None it is the stated one.
    keep
        The frames that are wanted.

    Raises
    ------
    InputError
        If the file is broken or has no markers.
    """
    source = Path(path)
    points = read_points(source, as_read=keep.as_read)
    _check_points(source, points)
    time = (points.first + np.arange(len(points.frames))) / points.rate
    rows = np.flatnonzero((time >= keep.start) & (time <= keep.end))[:: keep.every]
    _check_frames(source, len(rows), len(rows) * points.count * 3, keep)
    unnamed = (f"marker {k + 1}" for k in range(len(points.labels), points.count))
    labels = [*points.labels, *unnamed][: points.count]
    unit = metres or _stated_unit(f"{source}: POINT:UNITS", points.unit)
    position = points.position(rows) * unit
    screen = points.screen.lower().lstrip("+")
    markers = _markers(source, labels, position, time[rows], up=up, stated_up=screen)
    return replace(markers, notes=(*points.notes, *markers.notes))


def _check_points(path: Path, points: Points) -> None:
    """Refuse a file without markers or without a rate."""
    if points.count == 0 or len(points.frames) == 0:
        raise InputError(f"{path}: holds no marker")
    if not points.rate > 0:
        raise InputError(
            f"{path}: POINT:RATE is {points.rate:g}: a rate is needed (frames a second); write the "
            "markers as TRC, where the times of all frames are stated"
        )


def _stated_unit(where: str, unit: str) -> float:
    """The unit of length [m] that a file states."""
    if unit.lower() not in metres_in:
        raise InputError(
            f"{where} is {unit!r}, no unit of length ({', '.join(metres_in)}): state it "
            "(unit: 1 mm in a study, --unit '1 mm')"
        )
    return metres_in[unit.lower()]


def _check_frames(path: Path, frames: int, numbers: int, keep: FrameRange) -> None:
    """Refuse a file of which no frame is kept, or too many."""
    if numbers > _MAX_NUMBERS:
        raise InputError(
            f"{path}: too long to solve at once: read a part of it, or every n-th frame "
            "(start, end and every in a study, --start, --end and --every)"
        )
    if not frames:
        raise InputError(f"{path}: no frame between {keep.start:g} and {keep.end:g} s")


def _trc_header(path: Path, lines: Iterator[tuple[int, str]]) -> tuple[dict[str, str], list[str]]:
    """Read the header, up to the line of X1 Y1 Z1.

    Returns
    -------
    tuple[dict[str, str], list[str]]
        The values of the header by their names in lower case, and the names of the markers.
    """
    head: list[list[str]] = []
    for number, line in lines:
        words = [word for word in _cells(line) if word]  # padded with empty cells, spaces or lines
        if not words:
            continue
        head.append(words)
        if len(head) == 1 and words[0] != "PathFileType":
            raise InputError(f"{path}, line {number}: a TRC file begins with PathFileType")
        if len(head) == 5:
            break
    if len(head) < 5:
        raise InputError(f"{path}: ends within its header: cut short")
    header = {key.lower(): value for key, value in zip(head[1], head[2], strict=False)}
    names = head[3][2:]
    stated = header.get("nummarkers", "")
    count = parse_count(stated)
    if count and len(names) == 3 * count and names[::3] == names[1::3] == names[2::3]:
        names = names[::3]  # one name over each of X, Y and Z
    if not names or count != len(names):
        raise InputError(
            f"{path}, line 3: says {stated or 'no'} markers, line 4 names {len(names)}"
        )
    return header, names


def _cells(line: str) -> list[str]:
    """The cells of a line, without what pads and quotes them."""
    separator = next((sign for sign in "\t,;" if sign in line), None)
    return [cell.strip(' "') for cell in line.split(separator)]


def _padded(line: str, width: int) -> list[str]:
    """Return the cells of a row; empty ones at its end are added or removed."""
    cells = _cells(line)
    while len(cells) > width and not cells[-1]:
        cells.pop()
    return cells + [""] * (width - len(cells)) if len(cells) >= 2 else cells


def _markers(
    path: Path,
    labels: list[str],
    position: Floats,
    time: Floats,
    *,
    up: str | None,
    stated_up: str,
) -> Markers:
    """Build markers with z up.

    Parameters
    ----------
    path, labels, position, time
        The file, M labels, positions (P, M, 3) [m] in its axes, and times (P,) [s].
    up, stated_up
        Upward axis that the user gives, and that the file states, "" if none.
    """
    names = unique_names(labels, "marker")
    notes = []
    repeated = [label for label, count in Counter(labels).items() if count > 1]
    if repeated:
        notes.append(f"markers of the same name are numbered: {', '.join(repeated)}")
    position, missing = without_missing(names, position)
    notes += missing
    axis = up or stated_up or _upward_axis(path, names, position)
    if not up:
        notes.append(f"up is {axis} of the file" + ("" if stated_up else ", as the markers lie"))
    return Markers(tuple(names), position @ _rotation_to_z(axis).T, time, str(path), tuple(notes))


def _upward_axis(path: Path, names: list[str], position: Floats) -> str:
    """Return the axis along which the markers of head and hips lie above those of the feet."""
    median = np.array(
        [
            np.nanmedian(p, axis=0) if np.isfinite(p).any() else np.full(3, np.nan)
            for p in position.swapaxes(0, 1)
        ]
    )
    seen = np.isfinite(median[:, 0])
    low = _named(names, _LOW) & seen
    high = _named(names, _HIGH) & seen & ~low
    if not low.any() or not high.any():
        raise InputError(
            f"{path}: the upward axis cannot be told from the markers' names: state it (up in a study, --up: x, "
            "y, z, -x, -y or -z)"
        )
    rise = median[high].mean(axis=0) - median[low].mean(axis=0)
    axis = int(np.argmax(np.abs(rise)))
    return ("-" if rise[axis] < 0 else "") + "xyz"[axis]


def _named(names: list[str], pattern: re.Pattern[str]) -> Bools:
    """Return which markers (M,) have a name that holds a pattern, whatever stands before ':'."""
    plain = (re.sub(r"[^a-z0-9]", "", name.rsplit(":", 1)[-1].lower()) for name in names)
    return np.array([bool(pattern.search(name)) for name in plain])


def _rotation_to_z(up: str) -> Floats:
    """Return the smallest rotation (3, 3) that takes the file's upward axis to z."""
    if up.lstrip("-") not in ("x", "y", "z"):
        raise UsageError(f"up: {up!r} is not an axis; valid: x, y, z, -x, -y, -z")
    axis = (-1.0 if up.startswith("-") else 1.0) * np.eye(3)["xyz".index(up[-1])]
    if axis[2]:
        return np.diag([1.0, axis[2], axis[2]])
    side = np.cross(axis, [0.0, 0.0, 1.0])
    before = np.array([side, np.cross(axis, side), axis])
    return np.asarray(np.array([side, np.cross([0.0, 0.0, 1.0], side), [0.0, 0.0, 1.0]]).T @ before)


_MIN_HELD_FRAMES = 20
"""Least number of frames in which a measured marker does not repeat one number exactly."""


def without_missing(names: Sequence[str], position: Floats) -> tuple[Floats, tuple[str, ...]]:
    """Replace the positions of missing markers by gaps.

    Some programs write 0, 0, 0 for a marker that was not seen. Others write one constant position
    in all frames; it counts as missing if the marker has 20 frames or more, and another one moves.

    Parameters
    ----------
    names
        M markers.
    position
        (P, M, 3) in the file's own axes, NaN in gaps.

    Returns
    -------
    tuple
        Positions (P, M, 3), and notes that name the missing markers with their frames.
    """
    at_origin = np.all(position == 0.0, axis=-1)
    cleaned = np.where(at_origin[..., None], np.nan, position)
    zeros = at_origin.sum(axis=0)
    seen = np.isfinite(cleaned).all(axis=-1).sum(axis=0)
    with np.errstate(invalid="ignore"):
        first = np.fmin.reduce(cleaned, axis=0)
        last = np.fmax.reduce(cleaned, axis=0)
        still = np.all(first == last, axis=-1)
    held = still & (seen >= _MIN_HELD_FRAMES)
    if not np.any(~still & (seen > 1)):
        held[:] = False  # nobody moves: a posture
    cleaned[:, held] = np.nan
    found = (
        ("markers written as 0, 0, 0 are missing there", zeros),
        ("markers that never move are missing", np.where(held, seen, 0)),
    )
    return cleaned, tuple(
        f"{what}: {_counted(names, frames, len(position))}" for what, frames in found if any(frames)
    )


def _counted(names: Sequence[str], frames: Ints, total: int) -> str:
    """Name the markers with any frames, and how many they are."""
    pairs = zip(names, frames.tolist(), strict=True)
    return ", ".join(f"{name} ({count} of {total} frames)" for name, count in pairs if count)
