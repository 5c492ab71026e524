"""Compute forward kinematics: place bodies in poses, each pose with the row of the body that it names."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from workbench.body.kernels.forward import Chain, Rows, Skin, place_bodies
from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body, Topology, logical_window, walk
from workbench.model.kept import kept_with_body
from workbench.model.poses import Placed, Poses, check_joints, check_rows, people_of
from workbench.model.quaternions import matrices
from workbench.model.skinning import blend_point, distal, twist_shared
from workbench.threads import run_in_threads

__all__ = ["packed_chain", "packed_skin", "place", "rereference", "segment_frames", "update"]

_BATCH = 256
"""Poses that a thread places at a time."""


def place(
    body: Body, poses: Poses, *, window: Iterable[str] | None = None, reference: str | None = None
) -> Placed:
    """Place a body: chain the transforms from the reference segment, and place all spheres.

    The numbers of a pose do not depend on what other rows or poses there are.

    Parameters
    ----------
    body, poses
        The body, and P poses; each is placed with the row of the body that it names.
    window
        Mnemonics of the wanted segments. They and those on their paths to the reference segment are
        placed, the rest holds NaN and costs nothing. All segments if None.
    reference
        The segment that stands at `poses.world_from_reference`; the poses' own if None.

    Raises
    ------
    InputError
        If the poses are of another body, or a name is unknown.
    UsageError
        If it is not known which rows the poses are of.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> standing = wb.place(body, wb.pose(body, {}))
    >>> head = body.segments.index("H")
    >>> standing.world_from_segment[0, head, :3, 3].round(3)  # [m] its centre of gravity
    array([0.015, 0.   , 1.652])
    """
    person = people_of(body, poses)
    root = poses.reference if reference is None else body.segment(reference)
    shown = logical_window(body, window, root)
    world = _empty((len(poses), len(body.segments), 3, 4), shown)
    world[:, root] = poses.world_from_reference
    chain = _chain(body.topology, root, shown.tobytes())
    return _place_from(body, poses, person, shown, chain, 0, world)


def update(placed: Placed, poses: Poses, *, first_changed: str) -> Placed:
    """Place again after a change of joint `first_changed` and of what lies behind it.

    Only what lies at or behind that joint, in the walk from the reference segment, is computed. The
    numbers equal those of a full `place` to the last bit.

    Parameters
    ----------
    placed, poses
        What was placed, and the changed poses. The placement of the reference segment and all
        joints before this one must be as they were.
    first_changed
        Mnemonic of the joint.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> standing = wb.place(body, wb.pose(body, {}))
    >>> raised = wb.pose(body, {"RS": {"flexion": 90}})
    >>> again = wb.update(standing, raised, first_changed="RS")
    >>> bool((again.centres == wb.place(body, raised).centres).all())
    True
    """
    body = placed.body
    check_joints(body, poses)
    check_rows(poses, len(placed), "placed poses")
    joint = body.joint(first_changed)
    chain = _chain(body.topology, poses.reference, placed.window.tobytes())
    steps = np.flatnonzero(chain.joint == joint)
    world = placed.world_from_segment.copy()
    first = int(steps[0]) if len(steps) else len(chain.joint)
    return _place_from(body, poses, placed.person, placed.window, chain, first, world)


def rereference(placed: Placed, segment: str) -> Placed:
    """Return the same placed bodies in the frame of a segment.

    Raises
    ------
    InputError
        If the segment is unknown or outside the logical window.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> standing = wb.place(body, wb.pose(body, {}))
    >>> head = body.segments.index("H")
    >>> wb.rereference(standing, "H").world_from_segment[0, head, :3, 3]
    array([0., 0., 0.])
    """
    # one multiplication from the left: segment_from_world
    n = placed.body.segment(segment)
    if not placed.window[n]:
        raise InputError(f"segment {segment!r} is outside the logical window")
    frame = placed.world_from_segment[:, n]
    turn = frame[:, :, :3].transpose(0, 2, 1)
    shift = -np.einsum("pij,pj->pi", turn, frame[:, :, 3])
    world = np.einsum("pij,pnjk->pnik", turn, placed.world_from_segment)
    world[..., 3] += shift[:, None, :]
    centres = np.einsum("pij,psj->psi", turn, placed.centres) + shift[:, None, :]
    return Placed(placed.body, world, centres, placed.window, placed.person)


def segment_frames(body: Body, poses: Poses, segment: int) -> Floats:
    """Return world-from-segment transforms (P, 3, 4) without placing what is not on the path."""
    rows = people_of(body, poses)
    turn = poses.world_from_reference[:, :, :3]
    at = poses.world_from_reference[:, :, 3]
    for joint, upward in _path(body.topology, poses.reference, segment):
        one = body.joint_in_child if upward else body.joint_in_parent
        other = body.joint_in_parent if upward else body.joint_in_child
        rotation = matrices(poses.rotations[:, joint])
        after = turn @ (rotation.transpose(0, 2, 1) if upward else rotation)
        before = np.einsum("bij,bj->bi", turn, one[rows, joint])
        at = at + before - np.einsum("bij,bj->bi", after, other[rows, joint])
        turn = after
    return np.ascontiguousarray(np.concatenate([turn, at[:, :, None]], axis=2))


@lru_cache(maxsize=256)
def _path(topology: Topology, reference: int, segment: int) -> tuple[tuple[int, bool], ...]:
    """The joints on the way from the reference segment to another, and whether each is passed upward."""
    came = {to: (at, joint, upward) for to, at, joint, upward in walk(topology, reference)}
    path = []
    while segment != reference:
        segment, joint, upward = came[segment]
        path.append((joint, upward))
    return tuple(path[::-1])


def packed_chain(body: Body, reference: int, shown: Bools) -> Chain:
    """Pack the steps from the reference segment to all segments that are shown, for the kernels.

    Parameters
    ----------
    body, reference
        The body, whose first row gives the joints, and the number of the reference segment.
    shown
        (N,) which segments are placed.
    """
    chain = _chain(body.topology, reference, shown.tobytes())
    below = body.joint_in_child[0, chain.joint]
    above = body.joint_in_parent[0, chain.joint]
    up = chain.upward[:, None] == 1
    return chain._replace(at_came=np.where(up, below, above), at_to=np.where(up, above, below))


@lru_cache(maxsize=64)
def _chain(topology: Topology, reference: int, window: bytes) -> Chain:
    """The steps for a topology, reference segment and window, made once; joint coordinates are empty."""
    shown = np.frombuffer(window, dtype=np.bool_)
    steps = [step for step in walk(topology, reference) if shown[step[0]]]
    to, came, joint, upward = (
        (np.array(column, dtype=np.int64) for column in zip(*steps, strict=True))
        if steps
        else (np.zeros(0, np.int64),) * 4
    )
    return Chain(to, came, joint, upward, np.empty((0, 3)), np.empty((0, 3)))


def packed_skin(body: Body, shown: Bools) -> Skin:
    """Pack the spheres of a body's first row, and which segments are shown (N,), for the kernels."""
    return _first_skin(body)._replace(shown=shown.astype(np.int64))


@kept_with_body
def _first_skin(body: Body) -> Skin:
    """The spheres of the first row, packed for the kernels."""
    line = body.twist_axis[0, body.sphere_segment]
    arm = body.centre[0] - body.twist_point[0, body.sphere_segment]
    out = arm - np.einsum("si,si->s", arm, line)[:, None] * line
    return _skin(body.topology)._replace(
        centre=np.ascontiguousarray(body.centre[0].T),
        out=np.ascontiguousarray(out.T),
        across=np.ascontiguousarray(np.cross(line, out).T),
        twist_axis=body.twist_axis[0],
        twist_share=body.twist_share[0],
        blend_share=body.blend_share[0],
        blend_point=blend_point(body)[0],
    )


@lru_cache(maxsize=64)
def _skin(topology: Topology) -> Skin:
    """How the spheres of a topology share twists and are blended; what rows differ in is empty."""
    segment = topology.sphere_segment
    blended = np.flatnonzero(topology.blend_joint >= 0)
    blended = blended[np.lexsort((topology.blend_joint[blended], segment[blended]))]
    flat = np.empty((3, 0))
    none = np.empty(0)
    none.flags.writeable = False  # as rows of a body: the kernels are compiled for this
    rows = np.empty((0, 3))
    rows.flags.writeable = False
    return Skin(
        centre=flat,
        out=flat,
        across=flat,
        start=topology.start,
        twist_joint=topology.twist_joint,
        joint_axis=topology.stops.axes[:, 2].copy() if topology.joints else np.zeros((1, 3)),
        twist_axis=rows,
        twist_share=none,
        shown=np.ones(len(topology.segments), dtype=np.int64),
        blend_joint=topology.blend_joint,
        blend_share=none,
        blend_point=np.empty((0, 3)),
        blended=blended,
        blend_start=np.searchsorted(segment[blended], np.arange(len(topology.segments) + 1)),
        distal=distal(topology).astype(np.int64),
        twist_shared=twist_shared(topology).astype(np.int64),
    )


@kept_with_body
def _rows(body: Body) -> Rows:
    """What the rows of a body differ in, for the kernels."""
    return Rows(*(getattr(body, name) for name in Rows._fields))


def _empty(shape: tuple[int, ...], shown: Bools) -> Floats:
    """An array to fill, NaN where the window leaves gaps."""
    return np.empty(shape) if shown.all() else np.full(shape, np.nan)


def _place_from(
    body: Body,
    poses: Poses,
    person: Ints,
    shown: Bools,
    chain: Chain,
    first: int,
    world: Floats,
) -> Placed:
    """Place a body from step `first` of a chain on, and all its spheres.

    world: (P, N, 3, 4), filled in place; what earlier steps reach is placed already.
    """
    skin = _skin(body.topology)._replace(shown=shown.astype(np.int64))
    rows = _rows(body)
    centres = _empty((len(poses), len(body.sphere_names), 3), shown)
    person = person.view()
    person.flags.writeable = False  # the kernel is compiled for read-only arrays alone

    def work(begin: int, end: int) -> None:
        some = slice(begin, end)
        place_bodies(
            poses.rotations[some],
            person[some],
            chain,
            first,
            skin,
            body.topology.sphere_segment,
            rows,
            world[some],
            centres[some],
        )

    run_in_threads(work, len(poses), _BATCH)
    world.flags.writeable = centres.flags.writeable = False
    return Placed(body, world, centres, shown, person)
