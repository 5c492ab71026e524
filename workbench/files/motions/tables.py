"""Motions as tables: the project's own CSV of joint angles, and CSV of single segments; units in
the header."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.motions.number_rows import ALL, Pick, number_rows, numbered
from workbench.files.schema import metres_in
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.motion import SegmentTrack, rising_time
from workbench.model.poses import Poses, stacked
from workbench.model.posing import angles_of, attitude_matrix, compose, motion_of
from workbench.model.quaternions import from_matrices, matrices
from workbench.model.spool import pieces

__all__ = ["angle_table_text", "read_angle_table", "segment_pieces", "table_kind"]

_SECONDS = {"s": 1.0, "ms": 1e-3}
_RADIANS = {"deg": float(np.pi / 180), "rad": 1.0}
_ATTITUDES = ("roll", "pitch", "yaw")
_QUATERNION = ("qw", "qx", "qy", "qz")
_MOST_TURNS = 13.0
"""[rad] An angle beyond two turns is no joint's: degrees taken for radians."""


@dataclass(frozen=True)
class _Column:
    name: str
    unit: str


@dataclass(frozen=True, eq=False)
class _Table:
    """A table's columns (without the clock), its numbers with all columns, and where each column
    stands in them."""

    path: Path
    about: dict[str, str]
    columns: tuple[_Column, ...]
    header_line: int
    values: Floats
    places: tuple[int, ...]
    time: Floats
    lines: Ints

    def rows(self, keep: slice) -> _Table:
        """The table of some frames."""
        return replace(self, values=self.values[keep], time=self.time[keep], lines=self.lines[keep])

    def column(self, k: int) -> Floats:
        """(P,) the numbers of a column."""
        return np.ascontiguousarray(self.values[:, self.places[k]])


def table_kind(path: str | Path) -> str:
    """ "angles" or "segments": which of the two a CSV file holds, by its header."""
    _, columns, _ = _head(Path(path), numbered(Path(path)))
    placed = {c.name.split(".")[1] for c in columns if "." in c.name} & {"x", "y", "z"}
    return "segments" if placed else "angles"


def read_angle_table(
    path: str | Path, body: Body, *, keep: Pick = ALL
) -> tuple[Poses, tuple[str, ...]]:
    """The project's own CSV as poses of a body, and what should be noticed.

    First lines `# key: value` (body, reference), then the header: `time [s]`, the placement of the
    reference segment `x [mm], y [mm], z [mm]` and `qw, qx, qy, qz` or `roll [deg], pitch [deg], yaw
    [deg]`, and joint angles as `LH.flexion [deg]`, or `LH.qw` ... `LH.qz`. What is not there is 0.
    InputError with file, line and column. A long motion is worked on in pieces and kept in a file.
    """
    table = _read(Path(path), keep)
    largest = max(
        (_largest(table, k) for k, c in enumerate(table.columns) if _is_angle(c)), default=0.0
    )
    poses = stacked(_angle_poses(table.rows(rows), body) for rows in pieces(len(table.time)))
    small = any(c.unit == "deg" for c in table.columns) and 1e-3 < largest < np.radians(3.2)
    return poses, ("no joint angle exceeds 3.2 degrees: are these radians?",) if small else ()


def _angle_poses(table: _Table, body: Body) -> Poses:
    reference = body.segment(table.about["reference"]) if "reference" in table.about else 0
    angles = np.zeros((len(table.time), len(body.joints), 3))
    quaternions: dict[int, Floats] = {}
    place: dict[str, Floats] = {}
    for k, column in enumerate(table.columns):
        values = table.column(k)
        head, _, tail = column.name.partition(".")
        if not tail:
            place[head] = values * _unit(table, column, head)
        elif tail in _QUATERNION:
            quaternions.setdefault(_joint(table, body, head), np.zeros((len(values), 4)))[
                :, _QUATERNION.index(tail)
            ] = values
        else:
            j = _joint(table, body, head)
            try:
                axis, sign = motion_of(body, j, tail)
            except InputError as error:
                raise InputError(
                    f"{table.path}, line {table.header_line}, {column.name}: {error}"
                ) from None
            angles[:, j, axis] += sign * values * _RADIANS[column.unit]
    rotations = compose(body, angles)
    for j, given in quaternions.items():
        rotations[:, j] = _unit_quaternions(table, body.joints[j], given)
    world = np.concatenate(
        [
            _attitude(table, place),
            np.stack([place.get(k, np.zeros(len(angles))) for k in "xyz"], -1)[..., None],
        ],
        -1,
    )
    return Poses(rotations, reference, world, table.time)


def segment_pieces(path: str | Path, *, keep: Pick = ALL) -> Iterator[SegmentTrack]:
    """Segments that are given one by one, some frames at a time.

    Columns: `time [ms]`, then for each segment `H.x [mm], H.y [mm], H.z [mm]` of its centre of
    gravity and its attitude, `H.qw ... H.qz` or `H.roll [deg], H.pitch [deg], H.yaw [deg]` about x,
    y, z in the order yaw, pitch, roll. x forward, y left, z up. InputError with file, line and
    column.
    """
    table = _read(Path(path), keep)
    for rows in pieces(len(table.time)):
        yield _track(table.rows(rows))


def _track(table: _Table) -> SegmentTrack:
    names = list(dict.fromkeys(c.name.partition(".")[0] for c in table.columns))
    world = np.zeros((len(table.time), len(names), 3, 4))
    for n, name in enumerate(names):
        own: dict[str, Floats] = {}
        for k, column in enumerate(table.columns):
            head, _, tail = column.name.partition(".")
            if head == name:
                own[tail] = table.column(k) * _unit(table, column, tail)
        lacking = [k for k in "xyz" if k not in own]
        if lacking or not (set(_ATTITUDES) <= own.keys() or set(_QUATERNION) <= own.keys()):
            raise InputError(
                f"{table.path}, line {table.header_line}: segment {name} needs columns {name}.x, .y, "
                f".z and .qw to .qz or .roll, .pitch, .yaw"
            )
        world[:, n, :, :3] = _attitude(table, own)
        world[:, n, :, 3] = np.stack([own[k] for k in "xyz"], axis=-1)
    return SegmentTrack(tuple(names), world, table.time, str(table.path))


def angle_table_text(body: Body, poses: Poses) -> Iterator[str]:
    """Lines of the project's own CSV for a motion: what `read_angle_table` gives back within 1e-6
    degrees."""
    yield "# workbench motion\n"
    yield f"# body: {body.name}\n# reference: {body.segments[poses.reference]}\n"
    names = [
        f"{joint}.{body.stops.motions[j][axis][0]} [deg]"
        for j, joint in enumerate(body.joints)
        for axis in range(3)
    ]
    yield ", ".join(["time [s]", "x [mm]", "y [mm]", "z [mm]", *_QUATERNION, *names]) + "\n"
    for rows in pieces(len(poses)):
        some = poses.rows(rows)
        angles = np.degrees(angles_of(body, some)).reshape(len(some), -1) + 0.0
        place = some.world_from_reference
        time = poses.clock[rows]
        turn = from_matrices(place[:, :, :3])
        for p in range(len(some)):
            row = [
                f"{time[p]:.9g}",
                *(f"{1000 * v:.6f}" for v in place[p, :, 3]),
                *(f"{v:.12f}" for v in turn[p]),
            ]
            yield ", ".join([*row, *(f"{v:.7g}" for v in angles[p])]) + "\n"


def _head(
    path: Path, lines: Iterator[tuple[int, str]]
) -> tuple[dict[str, str], list[_Column], int]:
    about: dict[str, str] = {}
    for number, line in lines:
        if line.startswith("#"):
            key, colon, value = line[1:].partition(":")
            about |= {key.strip().lower(): value.strip()} if colon else {}
        elif line.strip():
            words = [word.strip() for word in next(csv.reader([line]))]
            columns = []
            for word in words:
                found = re.fullmatch(r"([\w.]+)\s*(?:\[\s*(\w+)\s*\])?", word)
                if not found:
                    raise InputError(
                        f"{path}, line {number}: {word!r} is no column: name [unit] is needed"
                    )
                columns.append(_Column(found[1], found[2] or ""))
            twice = [name for name, count in Counter(c.name for c in columns).items() if count > 1]
            if twice:
                raise InputError(f"{path}, line {number}: column {sorted(twice)[0]} is there twice")
            return about, columns, number
    raise InputError(f"{path}: holds no header")


def _read(path: Path, keep: Pick) -> _Table:
    lines = numbered(path)
    about, columns, number = _head(path, lines)
    clock = next((k for k, c in enumerate(columns) if c.name == "time"), None)
    if clock is None:
        raise InputError(f"{path}, line {number}: a column 'time [s]' is needed")
    unit = columns[clock].unit
    if unit not in _SECONDS:
        raise InputError(f"{path}, line {number}: time needs its unit, [s] or [ms], got [{unit}]")
    rows = (
        (at, [w.strip() for w in line.split(",")])
        for at, line in lines
        if line.strip() and not line.startswith("#")
    )
    names = [c.name for c in columns]
    found = number_rows(
        path, rows, len(columns), rows=names, keep=keep, clock=(clock, _SECONDS[unit])
    )
    if not len(found.values):
        raise InputError(
            f"{path}: "
            + (
                "holds no frame"
                if not found.total
                else f"no frame between {keep.start:g} and {keep.end:g} s"
            )
        )
    others = tuple(k for k in range(len(columns)) if k != clock)
    time = rising_time(found.values[:, clock] * _SECONDS[unit], str(path))
    kept = tuple(columns[k] for k in others)
    return _Table(path, about, kept, number, found.values, others, time, found.lines)


def _is_angle(column: _Column) -> bool:
    return "." in column.name and column.name.rpartition(".")[2] not in _QUATERNION


def _unit(table: _Table, column: _Column, what: str) -> float:
    """Factor to SI of a placement column."""
    valid: Mapping[str, float] = (
        metres_in if what in "xyz" else _RADIANS if what in _ATTITUDES else {"": 1.0}
    )
    if what not in ("x", "y", "z", *_ATTITUDES, *_QUATERNION):
        known = ["x", "y", "z", *_QUATERNION, *_ATTITUDES, "JOINT.motion"]
        raise InputError(
            f"{table.path}, line {table.header_line}: no column {column.name!r}; {one_of(column.name, known)}"
        )
    if column.unit not in valid:
        raise InputError(
            f"{table.path}, line {table.header_line}: column {column.name} needs its unit: "
            f"{', '.join(f'[{u}]' for u in valid)}; got [{column.unit}]"
        )
    return valid[column.unit]


def _joint(table: _Table, body: Body, name: str) -> int:
    try:
        return body.joint(name)
    except InputError as error:
        raise InputError(f"{table.path}, line {table.header_line}: {error}") from None


def _largest(table: _Table, k: int) -> float:
    """The largest angle [rad] of a column. InputError, with its line, where it is of many turns."""
    column = table.columns[k]
    if column.unit not in _RADIANS:
        raise InputError(
            f"{table.path}, line {table.header_line}: column {column.name} needs its unit, [deg] or "
            f"[rad], got [{column.unit}]"
        )
    values = np.abs(table.column(k)) * _RADIANS[column.unit]
    worst = int(np.argmax(values))
    if values[worst] > _MOST_TURNS:
        guess = ": is this column in degrees?" if column.unit == "rad" else ""
        raise InputError(
            f"{table.path}, line {table.lines[worst]}: {column.name} is {table.column(k)[worst]:g} "
            f"{column.unit} at {table.time[worst]:g} s, {values[worst] / (2 * np.pi):.0f} whole turns"
            f"{guess}"
        )
    return float(values[worst])


def _attitude(table: _Table, given: Mapping[str, Floats]) -> Floats:
    frames = len(table.time)
    if set(_QUATERNION) <= given.keys():
        given_turn = _unit_quaternions(
            table, "the placement", np.stack([given[k] for k in _QUATERNION], axis=-1)
        )
        return matrices(given_turn)
    zero = np.zeros(frames)
    rows = zip(*(given.get(k, zero) for k in _ATTITUDES), strict=True)
    return np.array([attitude_matrix(roll=r, pitch=p, yaw=y) for r, p, y in rows])


def _unit_quaternions(table: _Table, what: str, given: Floats) -> Floats:
    with np.errstate(
        over="ignore"
    ):  # a length too large for a number is infinite, and not 1 either
        length = np.linalg.norm(given, axis=-1)
    wrong = np.flatnonzero(np.abs(length - 1.0) > 1e-3)
    if len(wrong):
        raise InputError(
            f"{table.path}, line {table.lines[wrong[0]]}: the quaternion of {what} has length "
            f"{length[wrong[0]]:.4g} at {table.time[wrong[0]]:g} s; 1 is needed"
        )
    return np.asarray(given / length[:, None])
