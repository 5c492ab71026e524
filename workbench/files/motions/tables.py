"""Read and write motions as CSV tables: joint angles, or single segments; units in the header."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.motions.number_rows import (
    ALL_FRAMES,
    Clock,
    FrameRange,
    number_rows,
    numbered_lines,
)
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats, Ints, pieces
from workbench.model.body import Body
from workbench.model.joint_angles import (
    ContinuousAngles,
    angles_of,
    attitude_matrix,
    compose,
    motion_of,
)
from workbench.model.motion import SegmentTrack, rising_time
from workbench.model.poses import Poses, stacked
from workbench.model.quaternions import from_matrices, matrices
from workbench.model.stops import StopKind

__all__ = ["angle_table_text", "read_angle_table", "segment_batches", "table_kind"]

_SECONDS = {"s": 1.0, "ms": 1e-3}
_RADIANS = {"deg": float(np.pi / 180), "rad": 1.0}
_ATTITUDES = ("roll", "pitch", "yaw")
_QUATERNION = ("qw", "qx", "qy", "qz")
_MAX_ANGLE = 13.0
"""Largest angle [rad], about two turns. Beyond it degrees were taken for radians."""
_MIN_PLAUSIBLE_ANGLE = float(np.radians(3.2))
"""Largest angle [rad] of a table in degrees below which it may hold radians."""


@dataclass(frozen=True)
class _Column:
    name: str
    unit: str

    @property
    def head(self) -> str:
        """The joint or segment of "LH.flexion"; the whole name if there is no dot."""
        return self.name.partition(".")[0]

    @property
    def tail(self) -> str:
        """What of the joint or segment is given, "" if there is no dot."""
        return self.name.partition(".")[2]

    @property
    def is_angle(self) -> bool:
        """Whether it is an angle of a joint."""
        return bool(self.tail) and self.name.rpartition(".")[2] not in _QUATERNION


@dataclass(frozen=True)
class _Header:
    """The lines above the numbers of a table."""

    about: dict[str, str]
    """Lines "# key: value"."""
    columns: tuple[_Column, ...]
    line: int
    """Number of the line with the names of the columns."""


@dataclass(frozen=True, eq=False)
class _Table:
    """The numbers of a table, with its columns except the time."""

    path: Path
    about: dict[str, str]
    columns: tuple[_Column, ...]
    header_line: int
    values: Floats
    """(P, C + 1) all numbers, the time among them."""
    places: tuple[int, ...]
    """(C,) index of each column in the numbers."""
    time: Floats
    """(P,) [s]."""
    lines: Ints
    """(P,) line numbers."""
    notes: tuple[str, ...]

    def rows(self, keep: slice) -> _Table:
        """Return the table of some frames."""
        return replace(self, values=self.values[keep], time=self.time[keep], lines=self.lines[keep])

    def column(self, k: int) -> Floats:
        """Return the numbers (P,) of a column."""
        return np.ascontiguousarray(self.values[:, self.places[k]])

    def header_error(self, message: str) -> InputError:
        """Return an error about the names of the columns."""
        return InputError(f"{self.path}, line {self.header_line}{message}")


def table_kind(path: str | Path) -> str:
    """Return "angles" or "segments": which of the two a CSV file holds, by its header."""
    header = _read_header(Path(path), numbered_lines(Path(path)))
    placed = {column.name.split(".")[1] for column in header.columns if column.tail}
    return "segments" if placed & {"x", "y", "z"} else "angles"


def read_angle_table(
    path: str | Path, body: Body, *, keep: FrameRange = ALL_FRAMES
) -> tuple[Poses, tuple[str, ...]]:
    """Read the project's own CSV of joint angles as poses of a body.

    The file begins with lines `# key: value` (body, reference). Then come the names of the columns:
    `time [s]`; the placement of the reference segment, `x [mm], y [mm], z [mm]` and `qw, qx, qy,
    qz` or `roll [deg], pitch [deg], yaw [deg]`; joint angles as `LH.flexion [deg]`, or `LH.qw` ...
    `LH.qz`. What is not there is 0. A long motion is read in batches and kept in a file.

    Parameters
    ----------
    path, body
        The file, and the body that moves.
    keep
        The frames that are wanted.

    Returns
    -------
    tuple[Poses, tuple[str, ...]]
        The poses, and notes on what is odd.

    Raises
    ------
    InputError
        With file, line and column, for any error in the file.
    """
    table = _read_table(Path(path), keep)
    angles = [k for k, column in enumerate(table.columns) if column.is_angle]
    largest = max((_max_angle(table, k, body) for k in angles), default=0.0)
    poses = stacked(_angle_poses(table.rows(rows), body) for rows in pieces(len(table.time)))
    in_degrees = any(column.unit == "deg" for column in table.columns)
    if in_degrees and 1e-3 < largest < _MIN_PLAUSIBLE_ANGLE:
        return poses, (*table.notes, "no joint angle exceeds 3.2 degrees: are these radians?")
    return poses, table.notes


def _angle_poses(table: _Table, body: Body) -> Poses:
    """Return the poses of a table of joint angles."""
    reference = body.segment(table.about["reference"]) if "reference" in table.about else 0
    angles = np.zeros((len(table.time), len(body.joints), 3))
    quaternions: dict[int, Floats] = {}
    placement: dict[str, Floats] = {}
    for k, column in enumerate(table.columns):
        values = table.column(k)
        if not column.tail:
            placement[column.name] = values * _placement_unit(table, column, column.name)
            continue
        joint = _joint(table, body, column.head)
        if column.tail in _QUATERNION:
            given = quaternions.setdefault(joint, np.zeros((len(values), 4)))
            given[:, _QUATERNION.index(column.tail)] = values
        else:
            axis, sign = _joint_motion(table, body, joint, column)
            angles[:, joint, axis] += sign * values * _RADIANS[column.unit]
    rotations = compose(body, angles)
    for joint, given in quaternions.items():
        rotations[:, joint] = _unit_quaternions(table, body.joints[joint], given)
    return Poses(rotations, reference, _placed(table, placement), table.time)


def _placed(table: _Table, placement: Mapping[str, Floats]) -> Floats:
    """Return places (P, 3, 4) from the columns of a position and an attitude; 0 if not given."""
    zero = np.zeros(len(table.time))
    position = np.stack([placement.get(axis, zero) for axis in "xyz"], axis=-1)
    return np.concatenate([_attitude(table, placement), position[..., None]], axis=-1)


def _joint_motion(table: _Table, body: Body, joint: int, column: _Column) -> tuple[int, float]:
    """Return axis and sign of the motion of a joint that a column gives."""
    try:
        return motion_of(body, joint, column.tail)
    except InputError as error:
        raise table.header_error(f", {column.name}: {error}") from None


def segment_batches(path: str | Path, *, keep: FrameRange = ALL_FRAMES) -> Iterator[SegmentTrack]:
    """Read a table of single segments, in batches of frames.

    Columns: `time [ms]`; then for each segment the position of its centre of gravity, `H.x [mm],
    H.y [mm], H.z [mm]`, and its attitude, `H.qw ... H.qz` or `H.roll [deg], H.pitch [deg], H.yaw
    [deg]` about x, y, z in the order yaw, pitch, roll. x is forward, y left, z up.

    Parameters
    ----------
    path
        The file.
    keep
        The frames that are wanted.

    Raises
    ------
    InputError
        With file, line and column, for any error in the file.
    """
    table = _read_table(Path(path), keep)
    for rows in pieces(len(table.time)):
        yield _segment_track(table.rows(rows))


def _segment_track(table: _Table) -> SegmentTrack:
    """Return the places of the segments of a table."""
    given: dict[str, dict[str, Floats]] = {}
    for k, column in enumerate(table.columns):
        unit = _placement_unit(table, column, column.tail)
        given.setdefault(column.head, {})[column.tail] = table.column(k) * unit
    world = np.zeros((len(table.time), len(given), 3, 4))
    for n, (name, own) in enumerate(given.items()):
        has_attitude = set(_ATTITUDES) <= own.keys() or set(_QUATERNION) <= own.keys()
        if not (own.keys() >= set("xyz") and has_attitude):
            raise table.header_error(
                f": segment {name} needs columns {name}.x, .y, "
                ".z and .qw to .qz or .roll, .pitch, .yaw"
            )
        world[:, n] = _placed(table, own)
    return SegmentTrack(tuple(given), world, table.time, str(table.path), table.notes)


def angle_table_text(body: Body, poses: Poses) -> Iterator[str]:
    """Yield the lines of the project's own CSV for a motion.

    Angles go on from frame to frame without jumps by whole turns, with ten digits. They are read
    back by `read_angle_table`.
    """
    yield "# workbench motion\n"
    yield f"# body: {body.name}\n# reference: {body.segments[poses.reference]}\n"
    names = [
        f"{joint}.{motions[0]} [deg]"
        for joint, own in zip(body.joints, body.stops.motions, strict=True)
        for motions in own
    ]
    yield ", ".join(["time [s]", "x [mm]", "y [mm]", "z [mm]", *_QUATERNION, *names]) + "\n"
    continuous = ContinuousAngles()
    for rows in pieces(len(poses)):
        batch = poses.rows(rows)
        plain = angles_of(body, batch)
        angles = continuous.take(plain)
        # turns that would be refused when they are read (`_max_angle`) begin anew
        many = np.abs(angles).max(axis=-1) > _MAX_ANGLE
        refused = many & (np.asarray(body.stops.kind) != StopKind.FREE)
        angles = np.where(refused[..., None], plain, angles)
        yield from _angle_lines(batch, angles, poses.clock[rows])


def _angle_lines(poses: Poses, joint_angles: Floats, clock: Floats) -> Iterator[str]:
    """Yield a line for each frame. joint_angles: (P, J, 3) [rad]; clock: (P,) [s]."""
    world = poses.world_from_reference
    angles = np.degrees(joint_angles).reshape(len(poses), -1) + 0.0
    turns = from_matrices(world[:, :, :3])
    for p, time in enumerate(clock.tolist()):
        position = [f"{1000 * v:.6f}" for v in world[p, :, 3]]
        turn = [f"{v:.12f}" for v in turns[p]]
        row = [f"{time:.9g}", *position, *turn, *(f"{v:.10g}" for v in angles[p])]
        yield ", ".join(row) + "\n"


def _read_header(path: Path, lines: Iterator[tuple[int, str]]) -> _Header:
    """Read the lines up to the one with the names of the columns."""
    about: dict[str, str] = {}
    for number, line in lines:
        if line.startswith("#"):
            key, colon, value = line[1:].partition(":")
            about |= {key.strip().lower(): value.strip()} if colon else {}
        elif line.strip():
            here = f"{path}, line {number}"
            columns = tuple(_parse_column(here, word.strip()) for word in next(csv.reader([line])))
            names = Counter(column.name for column in columns)
            repeated = sorted(name for name, count in names.items() if count > 1)
            if repeated:
                raise InputError(f"{here}: column {repeated[0]} is there twice")
            return _Header(about, columns, number)
    raise InputError(f"{path}: holds no header")


def _parse_column(here: str, word: str) -> _Column:
    match = re.fullmatch(r"([\w.]+)\s*(?:\[\s*(\w+)\s*\])?", word)
    if not match:
        raise InputError(f"{here}: {word!r} is no column: name [unit] is needed")
    return _Column(match[1], match[2] or "")


def _read_table(path: Path, keep: FrameRange) -> _Table:
    """Read the frames of a table that are wanted."""
    lines = numbered_lines(path)
    header = _read_header(path, lines)
    columns = header.columns
    clock = _clock(path, header)
    words = (
        (number, [word.strip() for word in line.split(",")])
        for number, line in lines
        if line.strip() and not line.startswith("#")
    )
    names = [column.name for column in columns]
    rows = number_rows(path, words, len(columns), rows=names, keep=keep, clock=clock)
    if not rows.total:
        raise InputError(f"{path}: holds no frame")
    if not len(rows.values):
        raise InputError(f"{path}: no frame between {keep.start:g} and {keep.end:g} s")
    others = tuple(k for k in range(len(columns)) if k != clock.column)
    return _Table(
        path=path,
        about=header.about,
        columns=tuple(columns[k] for k in others),
        header_line=header.line,
        values=rows.values,
        places=others,
        time=rising_time(rows.values[:, clock.column] * clock.unit, str(path)),
        lines=rows.lines,
        notes=rows.notes,
    )


def _clock(path: Path, header: _Header) -> Clock:
    """Return where the time is, and its unit."""
    names = [column.name for column in header.columns]
    here = f"{path}, line {header.line}"
    if "time" not in names:
        raise InputError(f"{here}: a column 'time [s]' is needed")
    unit = header.columns[names.index("time")].unit
    if unit not in _SECONDS:
        raise InputError(f"{here}: time needs its unit, [s] or [ms], got [{unit}]")
    return Clock(names.index("time"), _SECONDS[unit])


def _placement_unit(table: _Table, column: _Column, what: str) -> float:
    """Return the unit of a column of a placement: of a length, an angle, or a quaternion."""
    valid: Mapping[str, float] = (
        metres_in if what in "xyz" else _RADIANS if what in _ATTITUDES else {"": 1.0}
    )
    if what not in ("x", "y", "z", *_ATTITUDES, *_QUATERNION):
        known = ["x", "y", "z", *_QUATERNION, *_ATTITUDES, "JOINT.motion"]
        raise table.header_error(f": no column {column.name!r}; {one_of(column.name, known)}")
    if column.unit not in valid:
        units = ", ".join(f"[{unit}]" for unit in valid)
        raise table.header_error(
            f": column {column.name} needs its unit: {units}; got [{column.unit}]"
        )
    return valid[column.unit]


def _joint(table: _Table, body: Body, name: str) -> int:
    try:
        return body.joint(name)
    except InputError as error:
        raise table.header_error(f": {error}") from None


def _max_angle(table: _Table, k: int, body: Body) -> float:
    """Return the largest angle [rad] of a column; refuse angles of many turns.

    A joint without stops may turn on and on in degrees: it is the whole body that turns.
    """
    column = table.columns[k]
    if column.unit not in _RADIANS:
        raise table.header_error(
            f": column {column.name} needs its unit, [deg] or [rad], got [{column.unit}]"
        )
    values = np.abs(table.column(k)) * _RADIANS[column.unit]
    worst = int(np.argmax(values))
    free = body.stops.kind[_joint(table, body, column.head)] == StopKind.FREE
    if values[worst] > _MAX_ANGLE and not (free and column.unit == "deg"):
        guess = ": is this column in degrees?" if column.unit == "rad" else ""
        turns = f"{values[worst] / (2 * np.pi):.0f} whole turns"
        raise InputError(
            f"{table.path}, line {table.lines[worst]}: {column.name} is {table.column(k)[worst]:g} "
            f"{column.unit} at {table.time[worst]:g} s, {turns}{guess}"
        )
    return float(values[worst])


def _attitude(table: _Table, given: Mapping[str, Floats]) -> Floats:
    """Return rotations (P, 3, 3) from quaternions or from roll, pitch and yaw; 0 if not given."""
    if set(_QUATERNION) <= given.keys():
        quaternions = np.stack([given[key] for key in _QUATERNION], axis=-1)
        return matrices(_unit_quaternions(table, "the placement", quaternions))
    zero = np.zeros(len(table.time))
    rows = zip(*(given.get(key, zero) for key in _ATTITUDES), strict=True)
    return np.array([attitude_matrix(roll=r, pitch=p, yaw=y) for r, p, y in rows])


def _unit_quaternions(table: _Table, what: str, given: Floats) -> Floats:
    """Normalize quaternions (P, 4); refuse those whose length is not 1 within a thousandth."""
    with np.errstate(over="ignore"):  # an overflow is infinite, and so not 1 either
        length = np.linalg.norm(given, axis=-1)
    wrong = np.flatnonzero(np.abs(length - 1.0) > 1e-3)
    if len(wrong):
        first = wrong[0]
        raise InputError(
            f"{table.path}, line {table.lines[first]}: the quaternion of {what} has length "
            f"{length[first]:.4g} at {table.time[first]:g} s; 1 is needed"
        )
    return np.asarray(given / length[:, None])
