"""Read and write BVH (Biovision hierarchy): a tree of bones, then one line of channel values per frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.errors import InputError
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
from workbench.model.motion import Bones
from workbench.model.poses import Placed, Poses
from workbench.model.quaternions import (
    conjugate,
    exponential,
    from_matrices,
    matrices,
    multiply,
)

__all__ = ["bone_batches", "bvh_text", "own_poses"]

_AXES = {"X": 0, "Y": 1, "Z": 2}
_CHANNELS = {
    axis + kind: (kind, k) for axis, k in _AXES.items() for kind in ("position", "rotation")
}
_MAX_DEPTH = 200
_MAX_BONES = 5000
_OVERVIEW = 400
"""Frames at most, spread over the file, by which assumptions are judged."""
_MAX_TURN = 720.0
"""Angle [degrees] of a channel beyond which it is told."""
_RADIANS = 6.3
"""Angle [degrees] of all channels below which they may be radians."""
_Offset = tuple[float, float, float]


@dataclass
class _Bone:
    name: str
    parent: int
    offset: _Offset | None = None
    channels: list[str] = field(default_factory=list)
    end: _Offset | None = None
    """Offset of its end site."""


class _MotionHeader(NamedTuple):
    """The lines after the word MOTION."""

    frames: int
    step: float
    """Time between frames [s]."""
    line: int
    """Number of the line with the number of frames."""


def bone_batches(path: str | Path, *, keep: FrameRange = ALL_FRAMES) -> Iterator[Bones]:
    """Read the bones of a BVH file, in batches of frames.

    Angles are in degrees. Rotations are applied in the order of the channels, the first outermost.
    Position channels replace the OFFSET. The file states no unit and no upward axis.

    Parameters
    ----------
    path
        The file.
    keep
        The frames that are wanted.

    Raises
    ------
    InputError
        With the line, if the hierarchy is broken, a channel is unknown, a row has another length,
        the number of frames is another, or the frame time is not positive.
    """
    source = Path(path)
    lines = numbered_lines(source)
    hierarchy = _Hierarchy(source)
    last_line = hierarchy.read(lines)
    bones = hierarchy.bones
    header = _motion_header(source, lines, last_line)
    names = [f"{bone.name} {channel}" for bone in bones for channel in bone.channels]
    rest = ((number, line.split()) for number, line in lines if line.strip())
    clock = Clock(None, header.step)
    rows = number_rows(source, rest, len(names), rows=names, keep=keep, clock=clock)
    where = f"{source}, line {header.line}"
    notes = keep.frame_count_notes(where, header.frames, rows.total)
    time = _frame_times(source, header.step, rows, keep)
    notes += _odd_angles(names, rows.values)
    offset = np.array([bone.offset for bone in bones], dtype=np.float64)

    def some(frames: slice, overview: Bones | None) -> Bones:
        rotations, shift = _bone_transforms(bones, offset, rows.values[frames])
        return Bones(
            tuple(bone.name for bone in bones),
            np.array([bone.parent for bone in bones]),
            offset,
            rotations,
            shift,
            time[frames],
            {bone.name: bone.end for bone in bones if bone.end is not None},
            str(source),
            notes,
            overview,
        )

    overview = some(slice(None, None, -(-len(time) // _OVERVIEW)), None)
    for batch in pieces(len(time)):
        yield some(batch, overview)


def _odd_angles(names: Sequence[str], values: Floats) -> tuple[str, ...]:
    """Notes on rotation channels that are of many turns, or so small that they may be radians."""
    largest = np.array([np.abs(column).max(initial=0.0) for column in values.T])
    turns = np.array([name.endswith("rotation") for name in names], dtype=np.bool_)
    largest = np.where(turns, largest, 0.0)
    worst = int(np.argmax(largest))
    if largest[worst] > _MAX_TURN:
        frame = int(np.argmax(np.abs(values[:, worst])))
        return (
            f"{names[worst]} is {values[frame, worst]:g} degrees in frame {frame + 1} of those read, "
            f"{largest[worst] / 360:.1f} whole turns: does the person turn round so often?",
        )
    if 1e-3 < largest[worst] < _RADIANS:
        return (
            f"no rotation channel exceeds {largest[worst]:.3g} degrees: are these radians? A BVH file holds "
            "degrees; export it again",
        )
    return ()


def _frame_times(path: Path, step: float, rows: NumberRows, keep: FrameRange) -> Floats:
    """Return the times (P,) [s] of the frames that are kept."""
    if not len(rows.values):
        raise InputError(
            f"{path}: no frame between {keep.start:g} and {keep.end:g} s "
            f"(it lasts {(rows.total - 1) * step:g} s)"
        )
    first = max(0, int(np.ceil(keep.start / step - 1e-9))) if np.isfinite(keep.start) else 0
    frames = first + keep.every * np.arange(len(rows.values), dtype=np.float64)
    return frames * step


class _Hierarchy:
    """Reads the tree of bones, line by line."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.bones: list[_Bone] = []
        self.open: list[int | None] = []
        """Bones whose braces are open, outermost first; None for an end site."""

    def read(self, lines: Iterator[tuple[int, str]]) -> int:
        """Read the lines up to the word MOTION, and return the number of its line."""
        pending = False
        opening: int | None = None
        for number, line in lines:
            words = line.split()
            if not words or words[0] == "HIERARCHY":
                continue
            here = f"{self.path}, line {number}"
            word = words[0]
            if word in ("ROOT", "JOINT", "End"):
                opening = self._begin(here, words)
                pending = True
            elif word == "{" and pending:
                self.open.append(opening)
                pending = False
            elif word == "MOTION" and not self.open:
                self._check_complete()
                return number
            elif not self._field(here, words):
                raise InputError(
                    f"{here}: {line.strip()[:60]!r} is not expected here in a BVH hierarchy"
                )
        raise InputError(f"{self.path}: ends before the word MOTION: no BVH file, or cut short")

    def _field(self, here: str, words: list[str]) -> bool:
        """Read a line inside the braces of a bone; returns whether it belongs there."""
        if not self.open:
            return False
        if words[0] == "}":
            self.open.pop()
        elif words[0] == "OFFSET":
            self._set_offset(here, words)
        elif words[0] == "CHANNELS" and self.open[-1] is not None:
            self.bones[self.open[-1]].channels = _channels(here, words)
        else:
            return False
        return True

    def _begin(self, here: str, words: list[str]) -> int | None:
        """Begin a bone and return its index, or begin an end site and return None."""
        if len(self.open) > _MAX_DEPTH or len(self.bones) >= _MAX_BONES:
            raise InputError(
                f"{here}: more than {_MAX_DEPTH} bones deep, or {_MAX_BONES} bones in all"
            )
        inside_bone = bool(self.open) and self.open[-1] is not None
        if words[0] == "End":
            if not inside_bone:
                raise InputError(f"{here}: an end site outside a bone")
            return None
        if (words[0] == "ROOT") != (not self.open) or (self.open and not inside_bone):
            raise InputError(f"{here}: {words[0]} is not expected here in a BVH hierarchy")
        name = " ".join(words[1:])
        if not name:
            raise InputError(f"{here}: {words[0]} without a name")
        if any(bone.name == name for bone in self.bones):
            raise InputError(f"{here}: a second bone {name!r}")
        self.bones.append(_Bone(name, int(self.open[-1] or 0) if self.open else -1))
        return len(self.bones) - 1

    def _set_offset(self, here: str, words: list[str]) -> None:
        """Set the offset of the innermost bone, or of its end site."""
        given = " ".join(words[1:])
        try:
            x, y, z = (float(word) for word in words[1:])
        except ValueError:
            raise InputError(f"{here}: OFFSET needs three numbers, got {given!r}") from None
        if not np.all(np.isfinite([x, y, z])):
            raise InputError(f"{here}: OFFSET needs finite numbers, got {given!r}")
        bone = self.open[-1]
        if bone is not None:
            self.bones[bone].offset = (x, y, z)
        else:
            owner = next(k for k in reversed(self.open) if k is not None)
            self.bones[owner].end = (x, y, z)

    def _check_complete(self) -> None:
        if not self.bones:
            raise InputError(f"{self.path}: holds no bone")
        for bone in self.bones:
            if bone.offset is None:
                raise InputError(f"{self.path}: bone {bone.name!r} has no OFFSET")


def _channels(here: str, words: list[str]) -> list[str]:
    """Return the names of the channels of a bone."""
    named = words[2:]
    if len(words) < 2 or parse_count(words[1]) != len(named):
        stated = words[1] if len(words) > 1 else "nothing"
        raise InputError(f"{here}: CHANNELS says {stated}, {len(named)} are named")
    unknown = [name for name in named if name not in _CHANNELS]
    if unknown or len(set(named)) != len(named):
        what = f"no channel {unknown[0]!r}" if unknown else "a channel is named twice"
        raise InputError(f"{here}: {what}; valid: {', '.join(_CHANNELS)}")
    return named


def _motion_header(path: Path, lines: Iterator[tuple[int, str]], last_line: int) -> _MotionHeader:
    """Read 'Frames: N' and 'Frame Time: seconds'."""
    values: dict[str, float] = {}
    frames_line = last_line
    for number, line in lines:
        if not line.strip():
            continue
        key, _, value = line.partition(":")
        key = key.strip().lower()
        try:
            values[key] = float(value)
        except ValueError:
            raise InputError(
                f"{path}, line {number}: 'Frames: N' and 'Frame Time: seconds' are needed here, "
                f"got {line.strip()[:60]!r}"
            ) from None
        if key == "frames":
            frames_line = number
        if {"frames", "frame time"} <= values.keys():
            frames = values["frames"]
            step = values["frame time"]
            if not 1 <= frames <= 1e9 or frames % 1 or not 1e-7 < step < 1e4:
                raise InputError(
                    f"{path}, line {number}: {frames:g} frames every {step:g} s: both must be positive"
                )
            return _MotionHeader(int(frames), step, frames_line)
    raise InputError(f"{path}: ends before 'Frames:' and 'Frame Time:': cut short")


def _bone_transforms(bones: list[_Bone], offset: Floats, table: Floats) -> tuple[Floats, Floats]:
    """Return the rotations (P, B, 4) and offsets (P, B, 3) of bones from channel values (P, C)."""
    rotations = np.zeros((len(table), len(bones), 4))
    rotations[..., 0] = 1.0
    shift = np.repeat(offset[None], len(table), axis=0)
    columns = iter(table.T)
    for b, bone in enumerate(bones):
        for name in bone.channels:
            kind, axis = _CHANNELS[name]
            values = next(columns)
            if kind == "position":
                shift[:, b, axis] = values
            else:
                vector = np.zeros((len(table), 3))
                vector[:, axis] = np.radians(values)
                rotations[:, b] = multiply(rotations[:, b], exponential(vector))
    return rotations, shift


_FILE_FROM_WORLD = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""Rotation from x forward, y left, z up to the usual BVH: x left, y up, z forward."""
_CENTIMETRES = 100.0
"""[1/m]."""
_ROUNDED = 1e-6
"""Change [cm] of an OFFSET that is written with six decimals."""


def bvh_text(body: Body, poses: Poses, placed: Iterable[Placed]) -> Iterator[str]:
    """Yield the lines of a BVH file.

    There is a bone for each segment below the stage. It is named as its segment and begins at its
    proximal joint; the zero pose is the rest pose. Lengths are centimetres, y up, z forward. Angles
    are degrees, channels Z, X, Y. The frames are those of the motion, at their mean rate.

    Parameters
    ----------
    body, poses
        The body and the P frames of its motion.
    placed
        The frames in the world, in batches.
    """
    root = _root(body)
    yield "HIERARCHY\n"
    yield from _bone_lines(body, root, 0)
    time = poses.clock
    step = float((time[-1] - time[0]) / (len(time) - 1)) if len(time) > 1 else 1.0
    yield f"MOTION\nFrames: {len(poses)}\nFrame Time: {step:.12g}\n"
    order = _depth_first(body, root)
    first = 0
    for batch in placed:
        table = _channel_values(body, order, poses.rows(slice(first, first + len(batch))), batch)
        first += len(batch)
        for row in table.tolist():
            yield " ".join(f"{value:.6f}" for value in row) + "\n"


def own_poses(body: Body, bones: Bones) -> Poses | None:
    """Return the motion of bones that `bvh_text` wrote of a body, None of any other skeleton.

    They are known by names, tree, and offsets in centimetres. Nothing is guessed of them: axes, unit
    and zero pose are those of `bvh_text`, and each joint turns as it is written.

    Parameters
    ----------
    body, bones
        The body that moves, and a skeleton in P frames.
    """
    order = _depth_first(body, _root(body))
    parents = [order.index(int(body.parent[n])) if k else -1 for k, n in enumerate(order)]
    if bones.names != tuple(body.segments[n] for n in order) or bones.parent.tolist() != parents:
        return None
    wanted = np.array([_bone_offset(body, segment) for segment in order])
    inner = [bones.offset, bones.shift[:, 1:], (bones.overview or bones).shift[:, 1:]]
    if any(
        np.abs(given - wanted[-given.shape[-2] :]).max(initial=0.0) > _ROUNDED for given in inner
    ):
        return None
    # a turn T in the file's axes is F' T F in the world's, F the file's axes from the world's
    axes = from_matrices(_FILE_FROM_WORLD[None])[0]
    turns = multiply(conjugate(axes), multiply(bones.rotations, axes))
    rotations = np.zeros((len(bones.time), len(body.joints), 4))
    rotations[..., 0] = 1.0
    for k, segment in enumerate(order):
        if segment:
            rotations[:, segment - 1] = turns[:, k]
    world = np.zeros((len(bones.time), 3, 4))
    world[:, :, :3] = matrices(turns[:, 0])
    world[:, :, 3] = bones.shift[:, 0] @ _FILE_FROM_WORLD / _CENTIMETRES
    world[:, :, 3] -= world[:, :, :3] @ _bone_origin(body, order[0])
    return Poses(rotations, order[0], world, bones.time)


def _root(body: Body) -> int:
    """Return the segment whose bone is the first: the one on the stage, which is no part of a body."""
    return 1 if body.segments[0] == "STG" and len(body.segments) > 1 else 0


def _channel_values(body: Body, order: list[int], poses: Poses, placed: Placed) -> Floats:
    """Return the channels (P, C) of some frames: position of the root, then angles of each bone."""
    root = order[0]
    turns = matrices(poses.rotations)
    world = placed.world_from_segment
    offset = np.einsum("pij,j->pi", world[:, root, :, :3], _bone_origin(body, root))
    begin = world[:, root, :, 3] + offset
    columns = [_CENTIMETRES * np.einsum("ij,pj->pi", _FILE_FROM_WORLD, begin)]
    for segment in order:
        turn = world[:, segment, :, :3] if segment == root else turns[:, segment - 1]
        columns.append(_euler_angles(_FILE_FROM_WORLD @ turn @ _FILE_FROM_WORLD.T))
    return np.concatenate(columns, axis=1) + 0.0  # -0 becomes 0


def _depth_first(body: Body, root: int) -> list[int]:
    """Return the segments from `root` on, each before its children."""
    order = [root]
    for child in np.flatnonzero(body.parent == root).tolist():
        order += _depth_first(body, child)
    return order


def _bone_origin(body: Body, segment: int) -> Floats:
    """Return the point (3,) [m] where a segment's bone begins, in the frame of the segment."""
    return np.asarray(body.joint_in_child[0, segment - 1]) if segment else np.zeros(3)


def _bone_offset(body: Body, segment: int) -> Floats:
    """Return the OFFSET (3,) [cm] of a segment's bone, 0 for the first one."""
    if segment == _root(body):
        return np.zeros(3)
    parent = int(body.parent[segment])
    offset = body.joint_in_parent[0, segment - 1] - _bone_origin(body, parent)
    return _CENTIMETRES * _FILE_FROM_WORLD @ offset


def _offset_text(offset: Floats) -> str:
    x, y, z = offset + 0.0
    return f"OFFSET {x:.6f} {y:.6f} {z:.6f}"


def _bone_lines(body: Body, segment: int, depth: int) -> Iterator[str]:
    """Yield the lines of a bone and its children."""
    pad = "\t" * depth
    kind = "JOINT" if depth else "ROOT"
    channels = "3" if depth else "6 Xposition Yposition Zposition"
    yield f"{pad}{kind} {body.segments[segment]}\n{pad}{{\n"
    yield f"{pad}\t{_offset_text(_bone_offset(body, segment))}\n"
    yield f"{pad}\tCHANNELS {channels} Zrotation Xrotation Yrotation\n"
    children = np.flatnonzero(body.parent == segment).tolist()
    for child in children:
        yield from _bone_lines(body, child, depth + 1)
    if not children:  # the bone ends at the centre of gravity, so that it has a direction
        end = _offset_text(-_CENTIMETRES * _FILE_FROM_WORLD @ _bone_origin(body, segment))
        yield f"{pad}\tEnd Site\n{pad}\t{{\n{pad}\t\t{end}\n{pad}\t}}\n"
    yield f"{pad}}}\n"


def _euler_angles(turn: Floats) -> Floats:
    """Return the angles (P, 3) [degrees] about z, x and y whose rotations, multiplied in this
    order, give rotations (P, 3, 3)."""
    # z from the second column; what is left of it along the turned x is the sine of y, so that y takes
    # up what rounding adds to z where x is near a right angle and only their sum or difference counts
    z = np.arctan2(-turn[:, 0, 1], turn[:, 1, 1])
    cosine = np.cos(z)
    sine = np.sin(z)
    x = np.arctan2(turn[:, 2, 1], np.hypot(turn[:, 0, 1], turn[:, 1, 1]))
    y = np.arctan2(
        cosine * turn[:, 0, 2] + sine * turn[:, 1, 2], cosine * turn[:, 0, 0] + sine * turn[:, 1, 0]
    )
    return np.asarray(np.degrees(np.stack([z, x, y], axis=-1)))
