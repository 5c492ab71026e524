"""Recorded motion before it belongs to a body: bones that turn, markers that move, segments that
are told one by one.

A motion of a body is no noun of its own: it is Poses whose `time` rises.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.model.arrays import Floats, Ints, read_only

__all__ = ["Bones", "Markers", "SegmentTrack", "rising_time"]


@dataclass(frozen=True, eq=False, repr=False)
class Bones:
    """Motion of a skeleton of B bones in P frames.

    names: of the bones, each after its parent; parent (B,): -1 for roots; offset (B, 3): from the
    parent's joint in the rest pose, in units of the file; rotations (P, B, 4): quaternions w, x, y,
    z against the parent; shift (P, B, 3): the joint's place against the parent in each frame, in
    units of the file; time (P,) [s]; ends: where bones without children end, by bone; file: its
    name, for messages; overview: frames from the whole motion of which these are a piece, by which
    assumptions are judged, None if these are the whole.
    """

    names: tuple[str, ...]
    parent: Ints
    offset: Floats
    rotations: Floats
    shift: Floats
    time: Floats
    ends: dict[str, tuple[float, float, float]]
    file: str
    notes: tuple[str, ...] = ()
    overview: Bones | None = None

    def __repr__(self) -> str:
        return f"Bones({len(self.names)} bones, {len(self.time)} frames)"

    def __post_init__(self) -> None:
        bones = len(self.names)
        frames = len(self.time)
        object.__setattr__(
            self, "parent", read_only(self.parent, np.int64, (bones,), "bones.parent")
        )
        object.__setattr__(
            self, "offset", read_only(self.offset, np.float64, (bones, 3), "bones.offset")
        )
        for name, width in (("rotations", 4), ("shift", 3)):
            given = read_only(
                getattr(self, name), np.float64, (frames, bones, width), f"bones.{name}"
            )
            object.__setattr__(self, name, given)
        object.__setattr__(self, "time", rising_time(self.time, self.file))


@dataclass(frozen=True, eq=False, repr=False)
class Markers:
    """Markers on a subject: position (P, M, 3) [m], x forward, y left, z up, NaN where one was not
    seen; time (P,) [s]; file: its name, for messages."""

    names: tuple[str, ...]
    position: Floats
    time: Floats
    file: str
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Markers({len(self.names)} markers, {len(self.time)} frames)"

    def __post_init__(self) -> None:
        shape = (len(self.time), len(self.names), 3)
        object.__setattr__(
            self, "position", read_only(self.position, np.float64, shape, "markers.position")
        )
        object.__setattr__(self, "time", rising_time(self.time, self.file))


@dataclass(frozen=True, eq=False, repr=False)
class SegmentTrack:
    """Segments of a body told one by one, as crash simulators print them: world_from_segment (P, K,
    3, 4) [m] of the K named segments; time (P,) [s]."""

    segments: tuple[str, ...]
    world_from_segment: Floats
    time: Floats
    file: str
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"SegmentTrack({len(self.segments)} segments, {len(self.time)} frames)"

    def __post_init__(self) -> None:
        shape = (len(self.time), len(self.segments), 3, 4)
        world = read_only(
            self.world_from_segment, np.float64, shape, "segment_track.world_from_segment"
        )
        object.__setattr__(self, "world_from_segment", world)
        object.__setattr__(self, "time", rising_time(self.time, self.file))


def rising_time(time: Floats, file: str) -> Floats:
    """(P,) [s] read-only; InputError where times are not finite or do not rise, naming the first
    wrong frame."""
    checked: Floats = read_only(time, np.float64, (None,), f"{file}: time")
    if len(checked) == 0:
        raise InputError(f"{file}: holds no frame")
    if not np.all(np.isfinite(checked)):
        raise InputError(
            f"{file}: frame {int(np.flatnonzero(~np.isfinite(checked))[0]) + 1} has no finite time"
        )
    back = np.flatnonzero(np.diff(checked) <= 0)
    if len(back):
        k = int(back[0])
        raise InputError(
            f"{file}: frames are out of order: frame {k + 2} is at {checked[k + 1]:g} s, after "
            f"frame {k + 1} at {checked[k]:g} s"
        )
    return checked
