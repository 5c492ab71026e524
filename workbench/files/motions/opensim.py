"""Read OpenSim motions (.mot, .sto): joint angles by the coordinate names of its body models.

Both dialects of the header are read: `nRows`, `nColumns`, `inDegrees`, `endheader` (storage and
motion files), and `datacolumns`, `datarows`, `range` (SIMM motion files, always degrees). x is
forward, y up, z to the right.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.motions.number_rows import (
    ALL_FRAMES,
    Clock,
    FrameRange,
    NumberRows,
    number_rows,
    numbered_lines,
    parse_count,
)
from workbench.model.arrays import Floats, pieces
from workbench.model.body import Body
from workbench.model.motion import rising_time
from workbench.model.poses import Poses
from workbench.model.quaternions import exponential, matrices, multiply

__all__ = ["Coordinates", "coordinate_batches", "coordinate_poses"]

_MAX_TURN = 13.0
"""Largest angle [rad] of the pelvis, about two turns. Beyond it degrees were taken for radians."""
_MAX_ANGLE = 4.0
"""Largest angle [rad] of a joint: none reaches it."""
_MIN_PLAUSIBLE_ANGLE = float(np.radians(3.2))
"""Largest angle [rad] of a file in degrees below which it may hold radians."""
_IDENTITY = [1.0, 0.0, 0.0, 0.0]
"""Quaternion of no rotation."""
_Rotations = tuple[tuple[str, tuple[float, float, float]], ...]
"""Coordinates of a joint in the order in which OpenSim rotates, each with its axis in x forward, y
left, z up. {s} stands for l or r."""
_PLACES = ("pelvis_tx", "pelvis_ty", "pelvis_tz")
_X = (1.0, 0.0, 0.0)
_Y = (0.0, 1.0, 0.0)
_Z = (0.0, 0.0, 1.0)
_RIGHT = (0.0, -1.0, 0.0)
_PELVIS = (("pelvis_tilt", _RIGHT), ("pelvis_list", _X), ("pelvis_rotation", _Z))
_TRUNK = (("lumbar_extension", _RIGHT), ("lumbar_bending", _X), ("lumbar_rotation", _Z))
_LIMBS = {
    "H": (("hip_flexion_{s}", _RIGHT), ("hip_adduction_{s}", _X), ("hip_rotation_{s}", _Z)),
    "K": (("knee_angle_{s}", _Y),),
    "A": (("ankle_angle_{s}", _RIGHT), ("subtalar_angle_{s}", _X)),
    "S": (("arm_flex_{s}", _RIGHT), ("arm_add_{s}", _X), ("arm_rot_{s}", _Z)),
    "E": (("elbow_flex_{s}", _RIGHT),),
    "W": (("pro_sup_{s}", _Z), ("wrist_flex_{s}", _X), ("wrist_dev_{s}", _Y)),
}
"""Of the right side; on the left, rotations about x and z have the other sign."""
_LIMB_ANGLES = {"hip_flexion_r", "hip_flexion_l", "arm_flex_r", "arm_flex_l"}
_KNOWN = {name for name, _ in (*_PELVIS, *_TRUNK)} | {
    *_PLACES,
    *(name.format(s=side) for limb in _LIMBS.values() for name, _ in limb for side in "lr"),
}
"""Coordinates that are used."""


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Named coordinates of a motion."""

    names: tuple[str, ...]
    values: Floats
    """(P, C) [rad]; pelvis_tx, _ty and _tz in metres."""
    time: Floats
    """(P,) [s]."""
    file: str
    negative: frozenset[str]
    """The knees that are negative in flexion."""
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Header:
    """The header of a file."""

    degrees: bool
    """Whether angles are degrees."""
    counts: dict[str, int]
    """Stated numbers of "rows" and "columns"."""
    names: list[str]
    """Names of all columns, the time among them."""

    def unit(self, k: int) -> float:
        """Return the unit of a column [rad], 1 of a length or of the time."""
        return np.pi / 180 if self.degrees and not _is_length(self.names[k]) else 1.0


def coordinate_batches(
    path: str | Path, *, names: Mapping[str, str] | None = None, keep: FrameRange = ALL_FRAMES
) -> Iterator[Coordinates]:
    """Read the coordinates of a .mot or .sto file, in batches of frames.

    Parameters
    ----------
    path
        The file.
    names
        The usual name of columns with unusual ones ({"HipFlexR": "hip_flexion_r"}), "" to leave a
        column out.
    keep
        The frames that are wanted.

    Raises
    ------
    InputError
        With the line, if the header is broken, a row has another length, a count is wrong, or a
        column that is used is there twice, has a gap, or an angle that no joint reaches (degrees
        taken for radians).
    """
    source = Path(path)
    lines = numbered_lines(source)
    header = _read_header(source, lines)
    labels = header.names
    words = ((number, line.split()) for number, line in lines if line.strip())
    rows = number_rows(
        source, words, len(labels), rows=labels, blank=True, keep=keep, clock=Clock(0)
    )
    notes = _check_counts(source, header, rows, keep)
    time = rising_time(rows.values[:, 0], str(source))
    columns, unused = _used_columns(source, labels, names or {}, rows)
    largest = max((_check_angle(source, header, rows, k) for k in columns.values()), default=0.0)
    if header.degrees and 1e-3 < largest < _MIN_PLAUSIBLE_ANGLE:
        notes += (
            "no joint angle exceeds 3.2 degrees: are these radians (inDegrees=no in the header)?",
        )
    scale = np.array([header.unit(k) for k in columns.values()])
    negative = frozenset(
        name
        for name, k in columns.items()
        if name.startswith("knee_angle") and np.median(rows.values[:, k]) < 0
    )
    for batch in pieces(len(time)):
        values = rows.values[batch][:, list(columns.values())] * scale
        yield Coordinates(
            tuple(columns), values, time[batch], str(source), negative, (*notes, *unused)
        )


def _used_columns(
    path: Path, labels: Sequence[str], names: Mapping[str, str], rows: NumberRows
) -> tuple[dict[str, int], tuple[str, ...]]:
    """The columns that are used, by coordinate; and a note on the others.

    A label may be a path of OpenSim 4, `/jointset/hip_r/hip_flexion_r/value`.
    """
    wrong = next((label for label in names if label not in labels), None)
    if wrong is not None:
        raise InputError(f"{path}: no column {wrong!r}; {one_of(wrong, labels)}")
    found: dict[str, int] = {}
    unused = []
    for k, label in enumerate(labels[1:], start=1):
        name = names.get(label, label.removesuffix("/value").rpartition("/")[2])
        if name not in _KNOWN or label.endswith("/speed"):
            unused.append(label)
        elif name not in found:
            found[name] = k
        elif not np.array_equal(rows.values[:, found[name]], rows.values[:, k]):
            raise InputError(
                f"{path}: columns {found[name] + 1} and {k + 1} are both {name}, and differ: leave one out "
                f"(map in a study, --names FILE: a line \"{label}: ''\")"
            )
    if not found.keys() & _LIMB_ANGLES:
        some = ", ".join(labels[1:21])
        raise InputError(
            f"{path}: holds no joint angles of a person (hip_flexion_r, ...): {some}; say which they are "
            "(map in a study, --names FILE with lines such as 'HipR: hip_flexion_r')"
        )
    more = f" and {len(unused) - 20} more" if len(unused) > 20 else ""
    return found, (f"not used: {', '.join(unused[:20])}{more}",) if unused else ()


def _check_counts(
    path: Path, header: _Header, rows: NumberRows, keep: FrameRange
) -> tuple[str, ...]:
    """Refuse a file that has not the rows and columns that its header states, or no frames.

    Returns a note on a number of rows that is wrong and accepted.
    """
    count = len(header.names)
    stated = header.counts.get("columns", count)
    if stated != count:
        raise InputError(f"{path}: the header says {stated} columns, {count} are there")
    stated = header.counts.get("rows", rows.total)
    notes = rows.notes + keep.frame_count_notes(f"{path}, header", stated, rows.total)
    if not len(rows.values):
        raise InputError(f"{path}: no frame between {keep.start:g} and {keep.end:g} s")
    return notes


def _check_angle(path: Path, header: _Header, rows: NumberRows, k: int) -> float:
    """Refuse a used column with a gap, or with an angle that no joint reaches.

    Returns its largest angle [rad], 0 of a length.
    """
    column = rows.values[:, k]
    gaps = np.flatnonzero(np.isnan(column))
    if len(gaps):
        raise InputError(
            f"{path}, line {rows.lines[gaps[0]]}: {header.names[k]} has no number; read a part of the file "
            "without gaps (start and end in a study, --start and --end)"
        )
    if _is_length(header.names[k]):
        return 0.0
    values = column * header.unit(k)
    worst = int(np.argmax(np.abs(values)))
    largest = float(abs(values[worst]))
    if largest <= (_MAX_TURN if "pelvis" in header.names[k] else _MAX_ANGLE):
        return largest
    guess = (
        "" if header.degrees else ": the header says radians; are these degrees (inDegrees=yes)?"
    )
    raise InputError(
        f"{path}, line {rows.lines[worst]}: {header.names[k]} is {column[worst]:g} at "
        f"{rows.values[worst, 0]:g} s, {largest / (2 * np.pi):.1f} whole turns{guess}"
    )


def coordinate_poses(body: Body, found: Coordinates) -> tuple[Poses, tuple[str, ...]]:
    """Turn OpenSim coordinates into poses of a body with the paper's joints.

    Waist and solar plexus share the rotation of the one lumbar joint.

    Parameters
    ----------
    body
        The body.
    found
        Coordinates of P frames.

    Returns
    -------
    tuple[Poses, tuple[str, ...]]
        The poses, and notes on what was assumed or left out.
    """
    reader = _Reader(found)
    count = len(found.time)
    pelvis = reader.rotation(_PELVIS)
    half = _half_rotation(reader.rotation(_TRUNK))
    turns = {"PV": pelvis, "W": half, "SP": half}
    for limb, coordinates in _LIMBS.items():
        for side in "lr":
            turns[side.upper() + limb] = reader.rotation(coordinates, side)
    rotations = np.tile(_IDENTITY, (count, len(body.joints), 1))
    for joint, turn in turns.items():
        rotations[:, body.joint(joint)] = turn
    notes = found.notes + tuple(dict.fromkeys(reader.notes))
    x, y, z = (reader.known.get(name, np.zeros(count)) for name in _PLACES)
    position = np.stack([x, -z, y], axis=-1)
    world = np.concatenate([matrices(pelvis), position[:, :, None]], axis=-1)
    return Poses(rotations, body.segment("LT"), world, found.time), notes


def _half_rotation(quaternions: Floats) -> Floats:
    """Return the rotations (P, 4) by half the angle, on the shorter way."""
    half = quaternions + np.array(_IDENTITY) * np.where(quaternions[:, :1] < 0, -1.0, 1.0)
    return np.asarray(half / np.linalg.norm(half, axis=-1, keepdims=True))


class _Reader:
    """Computes rotations from coordinates; records what was assumed."""

    def __init__(self, found: Coordinates) -> None:
        self.found = found
        self.known = dict(zip(found.names, found.values.T, strict=True))
        self.notes: list[str] = []

    def rotation(self, coordinates: _Rotations, side: str = "r") -> Floats:
        """Return the product (P, 4) of the rotations of coordinates; absent ones do not rotate."""
        mirror = np.array([-1.0, 1.0, -1.0]) if side == "l" else np.ones(3)
        q = np.tile(_IDENTITY, (len(self.found.time), 1))
        for name, axis in coordinates:
            key = name.format(s=side)
            if key in self.known:
                q = multiply(q, exponential(self._value(key)[:, None] * np.array(axis) * mirror))
        return q

    def _value(self, key: str) -> Floats:
        values = np.asarray(self.known[key])
        if key in self.found.negative:
            self.notes.append(f"{key} is negative in flexion, as in the gait2392 model")
            return -values
        if key.startswith("pro_sup"):
            self.notes.append(f"{key}: 90 degrees is taken as palms toward the thighs")
            return values - np.pi / 2
        return values


def _is_length(name: str) -> bool:
    return name.endswith(("_tx", "_ty", "_tz")) or name == "time"


def _read_header(path: Path, lines: Iterator[tuple[int, str]]) -> _Header:
    """Read the lines up to the one with the names of the columns."""
    degrees: bool | None = None
    counts: dict[str, int] = {}
    ended = False
    for number, line in lines:
        where = f"{path}, line {number}"
        words = line.replace("=", " ").split()
        key = words[0].lower() if words else ""
        if key == "time":
            names = line.split()
            if names[0].lower() != "time":
                raise InputError(f"{where}: the first column is 'time', got {names[0]!r}")
            return _finish_header(path, ["time", *names[1:]], counts, degrees)
        if key == "endheader":
            ended = True
        elif key in ("nrows", "datarows", "ncolumns", "datacolumns"):
            counts["rows" if "row" in key else "columns"] = _stated_count(where, line, words)
            if key.startswith("data") and degrees is None:  # SIMM files are always in degrees
                degrees = True
        elif key == "indegrees":
            if len(words) < 2 or words[1].lower() not in ("yes", "no"):
                raise InputError(f"{where}: inDegrees must be yes or no")
            degrees = words[1].lower() == "yes"
        elif key and ended:
            raise InputError(f"{where}: the column 'time' must come first, got {words[0]!r}")
    raise InputError(
        f"{path}: no line of column names beginning with 'time': no OpenSim motion, or cut short"
    )


def _stated_count(where: str, line: str, words: list[str]) -> int:
    """Return the count that a line of the header states after its key."""
    count = parse_count(words[1]) if len(words) > 1 else None
    if count is None:
        raise InputError(f"{where}: {line.strip()[:60]!r}: a count is needed")
    return count


def _finish_header(
    path: Path, names: list[str], counts: dict[str, int], degrees: bool | None
) -> _Header:
    """Check that the unit of angles is stated."""
    if degrees is None:
        raise InputError(
            f"{path}: the header does not say whether angles are degrees: state inDegrees=yes or no"
        )
    return _Header(degrees, counts, names)
