"""Write the motion of a body as BVH, for programs that read nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.poses import Placed, Poses
from workbench.model.quaternions import matrices

__all__ = ["bvh_text"]

_FILE_FROM_WORLD = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""Rotation from x forward, y left, z up to the usual BVH: x left, y up, z forward."""
_CENTIMETRES = 100.0
"""[1/m]."""


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
    root = 1 if body.segments[0] == "STG" and len(body.segments) > 1 else 0
    yield "HIERARCHY\n"
    yield from _bone_lines(body, root, 0)
    time = poses.clock
    step = float((time[-1] - time[0]) / (len(time) - 1)) if len(time) > 1 else 1.0
    yield f"MOTION\nFrames: {len(poses)}\nFrame Time: {step:.9g}\n"
    order = _depth_first(body, root)
    first = 0
    for batch in placed:
        table = _channel_values(body, order, poses.rows(slice(first, first + len(batch))), batch)
        first += len(batch)
        for row in table.tolist():
            yield " ".join(f"{value:.6f}" for value in row) + "\n"


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


def _offset_text(offset: Floats) -> str:
    x, y, z = _CENTIMETRES * _FILE_FROM_WORLD @ offset + 0.0
    return f"OFFSET {x:.6f} {y:.6f} {z:.6f}"


def _bone_lines(body: Body, segment: int, depth: int) -> Iterator[str]:
    """Yield the lines of a bone and its children."""
    pad = "\t" * depth
    kind = "JOINT" if depth else "ROOT"
    channels = "3" if depth else "6 Xposition Yposition Zposition"
    offset = np.zeros(3)
    if depth:
        parent = int(body.parent[segment])
        offset = body.joint_in_parent[0, segment - 1] - _bone_origin(body, parent)
    yield f"{pad}{kind} {body.segments[segment]}\n{pad}{{\n"
    yield f"{pad}\t{_offset_text(offset)}\n"
    yield f"{pad}\tCHANNELS {channels} Zrotation Xrotation Yrotation\n"
    children = np.flatnonzero(body.parent == segment).tolist()
    for child in children:
        yield from _bone_lines(body, child, depth + 1)
    if not children:  # the bone ends at the centre of gravity, so that it has a direction
        end = _offset_text(-_bone_origin(body, segment))
        yield f"{pad}\tEnd Site\n{pad}\t{{\n{pad}\t\t{end}\n{pad}\t}}\n"
    yield f"{pad}}}\n"


def _euler_angles(turn: Floats) -> Floats:
    """Return the angles (P, 3) [degrees] about z, x and y whose rotations, multiplied in this
    order, give rotations (P, 3, 3)."""
    sine = turn[:, 2, 1]
    x = np.arcsin(np.clip(sine, -1.0, 1.0))
    regular = np.abs(sine) < 1.0 - 1e-12  # otherwise gimbal lock: y is set to 0
    z = np.where(
        regular, np.arctan2(-turn[:, 0, 1], turn[:, 1, 1]), np.arctan2(turn[:, 1, 0], turn[:, 0, 0])
    )
    y = np.where(regular, np.arctan2(-turn[:, 2, 0], turn[:, 2, 2]), 0.0)
    return np.asarray(np.degrees(np.stack([z, x, y], axis=-1)))
