"""A motion of a body as BVH, for programs that read nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.poses import Placed, Poses
from workbench.model.quaternions import matrices

__all__ = ["bvh_text"]

_TO_FILE = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""World x forward, y left, z up to the usual BVH: x left, y up, z forward."""
_EVEN = 1e-3


def bvh_text(body: Body, poses: Poses, placed: Iterable[Placed]) -> Iterator[str]:
    """Lines of a BVH file: a bone for each segment below the stage, in centimetres, y up, z
    forward; angles in degrees, channels Z, X, Y. The frames are those of the motion, at their mean
    rate.

    placed: all frames of the motion in the world, in pieces. Each bone is named as its segment and
    begins at its proximal joint; the zero pose is the rest pose.
    """
    root = 1 if body.segments[0] == "STG" and len(body.segments) > 1 else 0
    yield "HIERARCHY\n"
    yield from _bone(body, root, 0)
    time = poses.clock
    step = float((time[-1] - time[0]) / (len(time) - 1)) if len(time) > 1 else 1.0
    yield f"MOTION\nFrames: {len(poses)}\nFrame Time: {step:.9g}\n"
    order = _depth_first(body, root)
    at = 0
    for some in placed:
        turns = matrices(poses.rotations[at : at + len(some)])
        at += len(some)
        world = some.world_from_segment
        begin = world[:, root, :, 3] + np.einsum(
            "pij,j->pi", world[:, root, :, :3], _origin(body, root)
        )
        rows = [100.0 * np.einsum("ij,pj->pi", _TO_FILE, begin)]
        for n in order:
            turn = world[:, n, :, :3] if n == root else turns[:, n - 1]
            rows.append(_angles(_TO_FILE @ turn @ _TO_FILE.T))
        table = np.concatenate(rows, axis=1) + 0.0
        for row in table.tolist():
            yield " ".join(f"{value:.6f}" for value in row) + "\n"


def _depth_first(body: Body, root: int) -> list[int]:
    found = [root]
    for child in np.flatnonzero(body.parent == root).tolist():
        found += _depth_first(body, child)
    return found


def _origin(body: Body, n: int) -> Floats:
    """(3,) [m] where a segment's bone begins, in its frame."""
    return np.asarray(body.joint_in_child[0, n - 1]) if n else np.zeros(3)


def _bone(body: Body, n: int, depth: int) -> Iterator[str]:
    pad = "\t" * depth
    parent = int(body.parent[n])
    offset = np.zeros(3) if depth == 0 else body.joint_in_parent[0, n - 1] - _origin(body, parent)
    x, y, z = 100.0 * _TO_FILE @ offset + 0.0
    yield f"{pad}{'ROOT' if depth == 0 else 'JOINT'} {body.segments[n]}\n{pad}{{\n"
    yield f"{pad}\tOFFSET {x:.6f} {y:.6f} {z:.6f}\n"
    yield f"{pad}\tCHANNELS {'6 Xposition Yposition Zposition' if depth == 0 else '3'} Zrotation Xrotation Yrotation\n"
    children = np.flatnonzero(body.parent == n).tolist()
    for child in children:
        yield from _bone(body, child, depth + 1)
    if not children:
        x, y, z = (
            100.0 * _TO_FILE @ (-_origin(body, n)) + 0.0
        )  # to the centre of gravity: a direction to draw
        yield f"{pad}\tEnd Site\n{pad}\t{{\n{pad}\t\tOFFSET {x:.6f} {y:.6f} {z:.6f}\n{pad}\t}}\n"
    yield f"{pad}}}\n"


def _angles(turn: Floats) -> Floats:
    """(P, 3) degrees about z, x and y whose product, in that order, is a rotation (P, 3, 3)."""
    x = np.arcsin(np.clip(turn[:, 2, 1], -1.0, 1.0))
    plain = np.abs(turn[:, 2, 1]) < 1.0 - 1e-12
    z = np.where(
        plain, np.arctan2(-turn[:, 0, 1], turn[:, 1, 1]), np.arctan2(turn[:, 1, 0], turn[:, 0, 0])
    )
    y = np.where(plain, np.arctan2(-turn[:, 2, 0], turn[:, 2, 2]), 0.0)
    return np.asarray(np.degrees(np.stack([z, x, y], axis=-1)))
