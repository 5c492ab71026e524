"""Forward kinematics: poses in, placed bodies out."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from workbench.errors import InputError
from workbench.kernels.forward import Chain, Skin, chain_transforms, place_spheres
from workbench.model.arrays import Bools, Floats
from workbench.model.blend import blend_point, distal, twist_shared
from workbench.model.body import Body
from workbench.model.poses import Placed, Poses, check_joints, check_rows
from workbench.model.window import logical_window, walk
from workbench.solve.threads import in_pieces

__all__ = ["packed_chain", "packed_skin", "place", "rereference", "update"]

PIECE = 256
"""Poses a thread takes at a time."""


def place(
    body: Body, poses: Poses, *, window: Iterable[str] | None = None, reference: str | None = None
) -> Placed:
    """Place a body: chain the transforms from the reference segment and put all spheres into the
    world.

    window: mnemonics of the segments wanted; they and those on their paths to the reference segment
    are placed, the rest holds NaN and costs nothing. reference: the segment that stands at
    `poses.world_from_reference`; the poses' own where None. Raises InputError where the poses are
    of another body or a name is unknown.
    """
    check_joints(body, poses)
    root = poses.reference if reference is None else body.segment(reference)
    shown = logical_window(body, window, root)
    world = _empty((len(poses), len(body.segments), 3, 4), shown)
    world[:, root] = poses.world_from_reference
    return _followed(body, poses, (world, shown), (packed_chain(body, root, shown), 0))


def update(placed: Placed, poses: Poses, *, first_changed: str) -> Placed:
    """Place again after a change that begins at joint `first_changed` in the walk from the
    reference segment.

    Only what lies at or behind that joint in the walk is computed; the numbers equal a full `place`
    to the last bit. The placement of the reference segment and all joints before this one must be
    as they were.
    """
    body = placed.body
    check_joints(body, poses)
    check_rows(poses, len(placed), "placed poses")
    joint = body.joint(first_changed)
    chain = packed_chain(body, poses.reference, placed.window)
    steps = np.flatnonzero(chain.joint == joint)
    world = placed.world_from_segment.copy()
    first = int(steps[0]) if len(steps) else len(chain.joint)
    return _followed(body, poses, (world, placed.window), (chain, first))


def rereference(placed: Placed, segment: str) -> Placed:
    """The same placed bodies seen from a segment: one left-multiplication makes its frame the
    world's."""
    n = placed.body.segment(segment)
    if not placed.window[n]:
        raise InputError(f"segment {segment!r} is outside the logical window")
    frame = placed.world_from_segment[:, n]
    turn = frame[:, :, :3].transpose(0, 2, 1)
    shift = -np.einsum("pij,pj->pi", turn, frame[:, :, 3])
    world = np.einsum("pij,pnjk->pnik", turn, placed.world_from_segment)
    world[..., 3] += shift[:, None, :]
    centres = np.einsum("pij,psj->psi", turn, placed.centres) + shift[:, None, :]
    return Placed(placed.body, world, centres, placed.window)


def packed_chain(body: Body, reference: int, shown: Bools) -> Chain:
    """The steps of the walk from the reference segment to all that is shown (N,), for the
    kernels."""
    return _chain(body, reference, shown.tobytes())


@lru_cache(maxsize=64)
def _chain(body: Body, reference: int, window: bytes) -> Chain:
    """The steps, made once for a body, reference segment and window."""
    shown = np.frombuffer(window, dtype=np.bool_)
    steps = [step for step in walk(body, reference) if shown[step[0]]]
    to, came, joint, upward = (
        (np.array(column, dtype=np.int64) for column in zip(*steps, strict=True))
        if steps
        else (np.zeros(0, np.int64),) * 4
    )
    below = body.joint_in_child[joint].reshape(-1, 3)
    above = body.joint_in_parent[joint].reshape(-1, 3)
    up = upward[:, None] == 1
    return Chain(to, came, joint, upward, np.where(up, below, above), np.where(up, above, below))


def packed_skin(body: Body, shown: Bools) -> Skin:
    """The spheres of a body and which segments are shown (N,), for the kernels."""
    return _skin(body)._replace(shown=shown.astype(np.int64))


@lru_cache(maxsize=64)
def _skin(body: Body) -> Skin:
    """The body's spheres as the kernel wants them, once a body (nouns are frozen and compare by
    identity)."""
    segment = body.sphere_segment
    line = body.twist_axis[segment]
    arm = body.centre - body.twist_point[segment]
    out = arm - np.einsum("si,si->s", arm, line)[:, None] * line
    blended = np.flatnonzero((body.blend_joint >= 0) & (body.blend_share > 0))
    blended = blended[np.lexsort((body.blend_joint[blended], segment[blended]))]
    return Skin(
        centre=np.ascontiguousarray(body.centre.T),
        out=np.ascontiguousarray(out.T),
        across=np.ascontiguousarray(np.cross(line, out).T),
        start=body.start,
        twist_joint=body.twist_joint,
        joint_axis=body.stops.axes[:, 2].copy() if len(body.joints) else np.zeros((1, 3)),
        twist_axis=body.twist_axis,
        twist_share=body.twist_share,
        shown=np.ones(len(body.segments), dtype=np.int64),
        blend_joint=body.blend_joint,
        blend_share=body.blend_share,
        blend_point=blend_point(body),
        blended=blended,
        blend_start=np.searchsorted(segment[blended], np.arange(len(body.segments) + 1)),
        distal=distal(body).astype(np.int64),
        twist_shared=twist_shared(body).astype(np.int64),
    )


def _empty(shape: tuple[int, ...], shown: Bools) -> Floats:
    """An array to fill; NaN where the window leaves gaps."""
    return np.empty(shape) if shown.all() else np.full(shape, np.nan)


def _followed(
    body: Body, poses: Poses, placed: tuple[Floats, Bools], walk: tuple[Chain, int]
) -> Placed:
    """The body placed: the transforms of a walk from one of its steps on, and all spheres."""
    world, shown = placed
    chain, step = walk
    skin = packed_skin(body, shown)
    centres = _empty((len(poses), len(body.sphere_names), 3), shown)

    def work(begin: int, end: int) -> None:
        some = slice(begin, end)
        chain_transforms(poses.rotations[some], chain, step, world[some])
        place_spheres(poses.rotations[some], world[some], skin, centres[some])

    in_pieces(work, len(poses), PIECE)
    world.flags.writeable = centres.flags.writeable = False
    return Placed(body, world, centres, shown)
