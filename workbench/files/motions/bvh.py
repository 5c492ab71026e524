"""BVH (Biovision hierarchy): a tree of bones with channels in any order, then one line of numbers a
frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.motions.number_rows import ALL, Pick, count_in, number_rows, numbered
from workbench.model.arrays import Floats
from workbench.model.motion import Bones
from workbench.model.quaternions import exponential, multiply
from workbench.model.spool import pieces

__all__ = ["bone_pieces"]

_AXES = {"X": 0, "Y": 1, "Z": 2}
_CHANNELS = {
    axis + kind: (kind, k) for axis, k in _AXES.items() for kind in ("position", "rotation")
}
_DEEPEST = 200
_MOST_BONES = 5000


@dataclass
class _Bone:
    name: str
    parent: int
    offset: tuple[float, float, float] | None = None
    channels: list[str] = field(default_factory=list)
    end: tuple[float, float, float] | None = None


def bone_pieces(path: str | Path, *, keep: Pick = ALL) -> Iterator[Bones]:
    """Bones of a BVH file, some frames at a time.

    Angles are in degrees, turns in the order of the channels, the first outermost. Position
    channels stand in place of the OFFSET. The file says no unit and no upward axis. InputError,
    with the line, for a broken hierarchy, unknown channels, rows of another length, frames missing
    or too many, a frame time that is not positive.
    """
    source = Path(path)
    lines = numbered(source)
    bones, at = _hierarchy(source, lines)
    frames, step, at = _motion_head(source, lines, at)
    names = [f"{bone.name} {channel}" for bone in bones for channel in bone.channels]
    rest = ((number, line.split()) for number, line in lines if line.strip())
    found = number_rows(source, rest, len(names), rows=names, keep=keep, clock=(None, step))
    if found.total != frames:
        raise InputError(f"{source}, line {at}: says {frames} frames, {found.total} are there")
    if not len(found.values):
        raise InputError(
            f"{source}: no frame between {keep.start:g} and {keep.end:g} s (it lasts {(found.total - 1) * step:g} s)"
        )
    first = max(0, int(np.ceil(keep.start / step - 1e-9))) if np.isfinite(keep.start) else 0
    time: Floats = np.float64(1.0) * (first + keep.every * np.arange(len(found.values))) * step
    ends = {bone.name: bone.end for bone in bones if bone.end is not None}
    offset = np.array([bone.offset for bone in bones], dtype=np.float64)
    parent = np.array([bone.parent for bone in bones])
    called = tuple(bone.name for bone in bones)
    for rows in pieces(len(time)):
        rotations, shift = _turned(bones, found.values[rows])
        yield Bones(
            called,
            parent,
            offset,
            rotations,
            shift,
            time[rows],
            ends,
            float("nan"),
            "",
            str(source),
        )


def _hierarchy(path: Path, lines: Iterator[tuple[int, str]]) -> tuple[list[_Bone], int]:
    """The bones, depth first, and the line of the word MOTION."""
    bones: list[_Bone] = []
    stack: list[int | None] = []  # None: an end site
    pending: tuple[str, int] | None = None
    for number, line in lines:
        words = line.split()
        if not words or (number == 1 and words == ["HIERARCHY"]):
            continue
        here = f"{path}, line {number}"
        word = words[0]
        if word == "HIERARCHY":
            continue
        if word in ("ROOT", "JOINT", "End"):
            pending = _begun(here, words, (bones, stack))
        elif word == "{" and pending is not None:
            stack.append(pending[1] if pending[0] else None)
            pending = None
        elif word == "}" and stack:
            stack.pop()
        elif word == "OFFSET" and stack:
            _offset(here, words, (bones, stack))
        elif word == "CHANNELS" and stack and stack[-1] is not None:
            bones[stack[-1]].channels = _channels(here, words)
        elif word == "MOTION" and not stack:
            return _complete(path, bones), number
        else:
            raise InputError(
                f"{here}: {line.strip()[:60]!r} is not expected here in a BVH hierarchy"
            )
    raise InputError(f"{path}: ends before the word MOTION: no BVH file, or cut short")


def _begun(
    here: str, words: list[str], tree: tuple[list[_Bone], list[int | None]]
) -> tuple[str, int]:
    bones, stack = tree
    if len(stack) > _DEEPEST or len(bones) >= _MOST_BONES:
        raise InputError(f"{here}: more than {_DEEPEST} bones deep, or {_MOST_BONES} bones in all")
    if words[0] == "End":
        if not stack or stack[-1] is None:
            raise InputError(f"{here}: an end site outside a bone")
        return "", stack[-1]
    if (words[0] == "ROOT") != (not stack) or (stack and stack[-1] is None):
        raise InputError(f"{here}: {words[0]} is not expected here in a BVH hierarchy")
    name = " ".join(words[1:])
    if not name or any(bone.name == name for bone in bones):
        raise InputError(
            f"{here}: " + (f"a second bone {name!r}" if name else f"{words[0]} without a name")
        )
    bones.append(_Bone(name, -1 if not stack else int(stack[-1] or 0)))
    return name, len(bones) - 1


def _offset(here: str, words: list[str], tree: tuple[list[_Bone], list[int | None]]) -> None:
    bones, stack = tree
    try:
        x, y, z = (float(word) for word in words[1:])
    except ValueError:
        raise InputError(
            f"{here}: OFFSET needs three numbers, got {' '.join(words[1:])!r}"
        ) from None
    if not np.all(np.isfinite([x, y, z])):
        raise InputError(f"{here}: OFFSET needs finite numbers, got {' '.join(words[1:])!r}")
    if stack[-1] is not None:
        bones[stack[-1]].offset = (x, y, z)
    else:
        owner = next(k for k in reversed(stack) if k is not None)
        bones[owner].end = (x, y, z)


def _channels(here: str, words: list[str]) -> list[str]:
    named = words[2:]
    if len(words) < 2 or count_in(words[1]) != len(named):
        raise InputError(
            f"{here}: CHANNELS says {words[1] if len(words) > 1 else 'nothing'}, {len(named)} are named"
        )
    wrong = [name for name in named if name not in _CHANNELS]
    if wrong or len(set(named)) != len(named):
        what = f"no channel {wrong[0]!r}" if wrong else "a channel is named twice"
        raise InputError(f"{here}: {what}; valid: {', '.join(_CHANNELS)}")
    return named


def _complete(path: Path, bones: list[_Bone]) -> list[_Bone]:
    if not bones:
        raise InputError(f"{path}: holds no bone")
    bare = [bone.name for bone in bones if bone.offset is None]
    if bare:
        raise InputError(f"{path}: bone {bare[0]!r} has no OFFSET")
    return bones


def _motion_head(path: Path, lines: Iterator[tuple[int, str]], at: int) -> tuple[int, float, int]:
    """Frames, the time between them [s], and the line that says how many there are."""
    found: dict[str, float] = {}
    where = at
    for number, line in lines:
        if not line.strip():
            continue
        key, _, value = line.partition(":")
        try:
            found[key.strip().lower()] = float(value)
        except ValueError:
            raise InputError(
                f"{path}, line {number}: 'Frames: N' and 'Frame Time: seconds' are needed here, "
                f"got {line.strip()[:60]!r}"
            ) from None
        where = number if key.strip().lower() == "frames" else where
        if {"frames", "frame time"} <= found.keys():
            frames = found["frames"]
            step = found["frame time"]
            if not 1 <= frames <= 1e9 or frames % 1 or not 1e-7 < step < 1e4:
                raise InputError(
                    f"{path}, line {number}: {frames:g} frames every {step:g} s: both must be positive"
                )
            return int(frames), step, where
    raise InputError(f"{path}: ends before 'Frames:' and 'Frame Time:': cut short")


def _turned(bones: list[_Bone], table: Floats) -> tuple[Floats, Floats]:
    rotations = np.zeros((len(table), len(bones), 4))
    rotations[..., 0] = 1.0
    shift = np.repeat(
        np.array([bone.offset for bone in bones], dtype=np.float64)[None], len(table), axis=0
    )
    column = 0
    for b, bone in enumerate(bones):
        for name in bone.channels:
            kind, axis = _CHANNELS[name]
            values = table[:, column]
            column += 1
            if kind == "position":
                shift[:, b, axis] = values
                continue
            vector = np.zeros((len(table), 3))
            vector[:, axis] = np.radians(values)
            rotations[:, b] = multiply(rotations[:, b], exponential(vector))
    return rotations, shift
