"""Motion files read whole: the pieces that commands read, joined."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.files.motions.bvh import bone_batches
from workbench.files.motions.number_rows import ALL_FRAMES, FrameRange
from workbench.files.motions.opensim import Coordinates, coordinate_batches
from workbench.files.motions.tables import segment_batches
from workbench.model.motion import Bones, SegmentTrack


def joined(parts, *names):
    """The first of some pieces with arrays of these names from all of them."""
    parts = list(parts)
    return replace(
        parts[0],
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in names},
    )


def read_bvh(path: str | Path, *, keep: FrameRange = ALL_FRAMES) -> Bones:
    """All bones of a BVH file."""
    return joined(bone_batches(path, keep=keep), "rotations", "shift", "time")


def read_coordinates(path: str | Path, *, keep: FrameRange = ALL_FRAMES) -> Coordinates:
    """All coordinates of a .mot or .sto file."""
    return joined(coordinate_batches(path, keep=keep), "values", "time")


def read_segment_table(path: str | Path, *, keep: FrameRange = ALL_FRAMES) -> SegmentTrack:
    """All frames of a table of segments."""
    return joined(segment_batches(path, keep=keep), "world_from_segment", "time")
