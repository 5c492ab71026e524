"""OpenSim motions (.mot, .sto): joint angles by the coordinate names of the gait and full-body
models.

Both dialects of the header are read: `nRows`, `nColumns`, `inDegrees`, `endheader` (storage and
motion files), and `datacolumns`, `datarows`, `range` (SIMM motion files, always degrees). x is
forward, y up, z to the right.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.motions.number_rows import ALL, Pick, count_in, number_rows, numbered
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.motion import rising_time
from workbench.model.poses import Poses
from workbench.model.quaternions import exponential, matrices, multiply
from workbench.model.spool import pieces

__all__ = ["Coordinates", "coordinate_pieces", "coordinate_poses"]

_MOST_TURNS = 13.0
# joint -> (coordinate, axis in x forward y left z up), in the order in which OpenSim turns; {s}: l
# or r
_Rows = tuple[tuple[str, tuple[float, float, float]], ...]
_PLACES = ("pelvis_tx", "pelvis_ty", "pelvis_tz")
_X = (1.0, 0.0, 0.0)
_Y = (0.0, 1.0, 0.0)
_Z = (0.0, 0.0, 1.0)
_RIGHT = (0.0, -1.0, 0.0)
_PELVIS = (("pelvis_tilt", _RIGHT), ("pelvis_list", _X), ("pelvis_rotation", _Z))
_TRUNK = (("lumbar_extension", _RIGHT), ("lumbar_bending", _X), ("lumbar_rotation", _Z))
# of the right side; on the left the turns about x and z have the other sign
_LIMBS = {
    "H": (("hip_flexion_{s}", _RIGHT), ("hip_adduction_{s}", _X), ("hip_rotation_{s}", _Z)),
    "K": (("knee_angle_{s}", _Y),),
    "A": (("ankle_angle_{s}", _RIGHT), ("subtalar_angle_{s}", _X)),
    "S": (("arm_flex_{s}", _RIGHT), ("arm_add_{s}", _X), ("arm_rot_{s}", _Z)),
    "E": (("elbow_flex_{s}", _RIGHT),),
    "W": (("pro_sup_{s}", _Z), ("wrist_flex_{s}", _X), ("wrist_dev_{s}", _Y)),
}


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Named coordinates of a motion: values (P, C) in radians, pelvis_tx, _ty, _tz in metres; time
    (P,) [s]; negative: the knees that are negative in flexion."""

    names: tuple[str, ...]
    values: Floats
    time: Floats
    file: str
    negative: frozenset[str]


def coordinate_pieces(path: str | Path, *, keep: Pick = ALL) -> Iterator[Coordinates]:
    """Coordinates of a .mot or .sto file, some frames at a time.

    InputError with the line for a broken header, rows of another length, wrong counts, or angles of
    many turns (degrees taken for radians).
    """
    source = Path(path)
    lines = numbered(source)
    degrees, said, names = _header(source, lines)
    rest = ((number, line.split()) for number, line in lines if line.strip())
    clock = names.index("time")
    found = number_rows(source, rest, len(names), rows=names, keep=keep, clock=(clock, 1.0))
    for word, have in (("rows", found.total), ("columns", len(names))):
        if word in said and said[word] != have:
            raise InputError(f"{source}: the header says {said[word]} {word}, {have} are there")
    if not len(found.values):
        raise InputError(f"{source}: no frame between {keep.start:g} and {keep.end:g} s")
    others = [k for k, name in enumerate(names) if name != "time"]
    time = rising_time(found.values[:, clock], str(source))
    scale = np.array([np.pi / 180 if degrees and not _is_place(names[k]) else 1.0 for k in others])
    negative = set()
    for column, k in enumerate(others):
        values = found.values[:, k] * scale[column]
        worst = int(np.argmax(np.abs(values)))
        if not _is_place(names[k]) and abs(values[worst]) > _MOST_TURNS:
            guess = (
                "" if degrees else ": the header says radians; are these degrees (inDegrees=yes)?"
            )
            raise InputError(
                f"{source}, line {found.lines[worst]}: {names[k]} is {found.values[worst, k]:g} at "
                f"{time[worst]:g} s, {abs(values[worst]) / (2 * np.pi):.0f} whole turns"
                f"{guess}"
            )
        if names[k].startswith("knee_angle") and np.median(values) < 0:
            negative.add(names[k])
    called = tuple(names[k] for k in others)
    for rows in pieces(len(time)):
        angles = found.values[rows][:, others] * scale
        yield Coordinates(called, angles, time[rows], str(source), frozenset(negative))


def coordinate_poses(body: Body, found: Coordinates) -> tuple[Poses, tuple[str, ...]]:
    """Poses of a body with the paper's joints from OpenSim coordinates, and what was assumed or
    left out.

    The turn of the one lumbar joint is shared by waist and solar plexus. InputError where neither
    hips nor arms are there.
    """
    reader = _Reader(found)
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(found.time), len(body.joints), 1))
    pelvis = reader.turn(_PELVIS)
    trunk = reader.turn(_TRUNK)
    rotations[:, body.joint("PV")] = pelvis
    half = trunk + np.array([1.0, 0.0, 0.0, 0.0]) * np.where(trunk[:, :1] < 0, -1.0, 1.0)
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    rotations[:, body.joint("W")] = rotations[:, body.joint("SP")] = half
    for limb, rows in _LIMBS.items():
        for side in "lr":
            rotations[:, body.joint(side.upper() + limb)] = reader.turn(rows, side)
    notes = reader.told()
    zero = np.zeros(len(found.time))
    x, y, z = (reader.known.get(name, zero) for name in _PLACES)
    place = np.zeros((len(found.time), 3, 4))
    place[:, :, :3] = matrices(pelvis)
    place[:, :, 3] = np.stack([x, -z, y], axis=-1)
    return Poses(rotations, body.segment("LT"), place, found.time), notes


class _Reader:
    """Turns from coordinates, with a record of which were used and what was assumed."""

    def __init__(self, found: Coordinates) -> None:
        self.found = found
        self.known = dict(zip(found.names, found.values.T, strict=True))
        self.used: set[str] = set()
        self.notes: list[str] = []

    def turn(self, rows: _Rows, side: str = "r") -> Floats:
        """(P, 4) the turns of coordinates one after another; what is not there does not turn."""
        mirror = np.array([-1.0, 1.0, -1.0]) if side == "l" else np.ones(3)
        q = np.tile([1.0, 0.0, 0.0, 0.0], (len(self.found.time), 1))
        for name, axis in rows:
            key = name.format(s=side)
            if key in self.known:
                self.used.add(key)
                q = multiply(q, exponential(self._value(key)[:, None] * np.array(axis) * mirror))
        return q

    def told(self) -> tuple[str, ...]:
        """What was assumed, and which columns were not used; InputError where no limb was found."""
        if not self.used & {"hip_flexion_r", "hip_flexion_l", "arm_flex_r", "arm_flex_l"}:
            some = ", ".join(self.found.names[:20])
            raise InputError(
                f"{self.found.file}: holds no joint angles of a person (hip_flexion_r, ...): {some}"
            )
        left = [name for name in self.found.names if name not in self.used and name not in _PLACES]
        more = f" and {len(left) - 20} more" if len(left) > 20 else ""
        return tuple(
            dict.fromkeys(
                self.notes + ([f"not used: {', '.join(left[:20])}{more}"] if left else [])
            )
        )

    def _value(self, key: str) -> Floats:
        values = np.asarray(self.known[key])
        if key in self.found.negative:
            self.notes.append(f"{key} is negative in flexion, as in the gait2392 model")
            return -values
        if key.startswith("pro_sup"):
            self.notes.append(f"{key}: 90 degrees is taken as palms toward the thighs")
            return values - np.pi / 2
        return values


def _is_place(name: str) -> bool:
    return name.endswith(("_tx", "_ty", "_tz")) or name == "time"


def _header(path: Path, lines: Iterator[tuple[int, str]]) -> tuple[bool, dict[str, int], list[str]]:
    """Whether angles are degrees, what the header says of rows and columns, the names of the
    columns."""
    degrees: bool | None = None
    said: dict[str, int] = {}
    ended = False
    for number, line in lines:
        words = line.replace("=", " ").split()
        if not words:
            continue
        key = words[0].lower()
        if key == "endheader":
            ended = True
        elif key == "time":
            break
        elif key in ("nrows", "datarows", "ncolumns", "datacolumns"):
            count = count_in(words[1]) if len(words) > 1 else None
            if count is None:
                raise InputError(f"{path}, line {number}: {line.strip()[:60]!r}: a count is needed")
            said["rows" if "row" in key else "columns"] = count
            degrees = True if key.startswith("data") and degrees is None else degrees
        elif key == "indegrees":
            if len(words) < 2 or words[1].lower() not in ("yes", "no"):
                raise InputError(f"{path}, line {number}: inDegrees must be yes or no")
            degrees = words[1].lower() == "yes"
        elif ended:
            raise InputError(
                f"{path}, line {number}: the column 'time' must come first, got {words[0]!r}"
            )
    else:
        raise InputError(
            f"{path}: no line of column names beginning with 'time': no OpenSim motion, or cut short"
        )
    names = line.split()
    if len(set(names)) != len(names):
        raise InputError(f"{path}, line {number}: a column is there twice")
    if degrees is None:
        raise InputError(
            f"{path}: the header does not say whether angles are degrees: state inDegrees=yes or no"
        )
    return degrees, said, names
