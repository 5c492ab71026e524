"""Bodies of one family packed for the kernels: what differs between them as arrays, a row a
body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from workbench.errors import UsageError
from workbench.kernels.forward import Skin
from workbench.kernels.limbs.contacts import Limbs
from workbench.kernels.limbs.linkage import Linkage
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.poses import Poses, check_joints
from workbench.model.quaternions import matrices
from workbench.model.window import logical_window, walk
from workbench.solve.forward import packed_chain, packed_skin
from workbench.solve.reaching.limbs import Limb, landmarks, solids
from workbench.solve.reaching.linkage import joints_between, linkage

__all__ = ["Family", "family_of", "frames", "packed_limbs", "packed_links"]


@dataclass(frozen=True, eq=False)
class Family:
    """B bodies with the same segments, joints and stops. in_parent, in_child (B, J, 3): joints in
    both frames; centre (B, S, 3), radius (B, S): spheres; twist_point, twist_axis (B, N, 3),
    twist_share, blend_share (B, S)."""

    bodies: tuple[Body, ...]
    in_parent: Floats
    in_child: Floats
    centre: Floats
    radius: Floats
    twist_point: Floats
    twist_axis: Floats
    twist_share: Floats
    blend_share: Floats

    def __len__(self) -> int:
        return len(self.bodies)


@lru_cache(maxsize=4)
def family_of(bodies: tuple[Body, ...]) -> Family:
    """Pack bodies; UsageError where they are not of one family."""
    first = bodies[0]
    known = {id(bodies[0].stops)}
    for body in bodies:
        same = body.joints == first.joints and len(body.centre) == len(first.centre)
        if same and id(body.stops) not in known:
            ours = first.stops
            theirs = body.stops
            same = all(
                np.array_equal(getattr(ours, name), getattr(theirs, name))
                for name in ("kind", "limits", "axes")
            )
            known.add(id(body.stops))
        if not same:
            raise UsageError(
                f"bodies of one family have the same joints, stops and spheres: {first.name}, {body.name}"
            )
    return Family(
        bodies,
        *(
            _stacked(bodies, name)
            for name in (
                "joint_in_parent",
                "joint_in_child",
                "centre",
                "radius",
                "twist_point",
                "twist_axis",
                "twist_share",
                "blend_share",
            )
        ),
    )


def _stacked(bodies: Sequence[Body], name: str) -> Floats:
    """One array of all bodies (B, ...); those read back from disk are maps of a file, which are
    slow to stack."""
    return np.stack([np.asarray(getattr(body, name)) for body in bodies])


def packed_links(family: Family, limb: Limb) -> Linkage:
    """The chain of a limb (that of the first body) with the lengths of all."""
    one = _link(family.bodies[0], limb)
    joints = joints_between(family.bodies[0], limb.base, limb.end)
    if len(family) == 1:
        return one
    tip, pointing = landmarks(family.bodies, (family.centre, family.radius), limb)
    parent, child = (
        np.ascontiguousarray(at[:, joints]) for at in (family.in_parent, family.in_child)
    )
    return one._replace(at_parent=parent, at_child=child, tip=tip, pointing=pointing)


@lru_cache(maxsize=64)
def _link(body: Body, limb: Limb) -> Linkage:
    return linkage(body, (limb.base, limb.end), limb.free, (limb.tip, limb.pointing))


def frames(family: Family, poses: Poses, segment: int, who: Ints | None = None) -> Floats:
    """(P, 3, 4) where a segment stands in each row of the poses, row p being body who[p]'s, or that
    of body p."""
    body = family.bodies[0]
    rows = np.arange(len(poses)) % len(family) if who is None else who
    check_joints(body, poses)
    came = {to: (at, joint, upward) for to, at, joint, upward in walk(body, poses.reference)}
    path = []
    while segment != poses.reference:
        path.append(came[segment])
        segment = came[segment][0]
    turn = poses.world_from_reference[:, :, :3]
    at = poses.world_from_reference[:, :, 3]
    for _, joint, upward in path[::-1]:
        one, other = (
            (family.in_child, family.in_parent) if upward else (family.in_parent, family.in_child)
        )
        rotation = matrices(poses.rotations[:, joint])
        after = turn @ (rotation.transpose(0, 2, 1) if upward else rotation)
        at = (
            at
            + np.einsum("bij,bj->bi", turn, one[rows, joint])
            - np.einsum("bij,bj->bi", after, other[rows, joint])
        )
        turn = after
    return np.ascontiguousarray(np.concatenate([turn, at[:, :, None]], axis=2))


@lru_cache(maxsize=8)
def packed_limbs(family: Family, limb: Limb) -> Limbs:
    """The segments that go along with a limb and their spheres, of all bodies of a family."""
    body = family.bodies[0]
    shown = logical_window(body, [body.segments[n] for n in limb.moving], limb.base)
    chain = packed_chain(body, limb.base, shown)
    moving = np.isin(np.arange(len(body.segments)), limb.moving)
    sphere = np.flatnonzero(moving[body.sphere_segment])
    segment = body.sphere_segment[sphere]
    joints = joints_between(body, limb.base, limb.end)
    link, carrier = _carriers(body, limb, joints)
    arm = family.centre[:, sphere] - family.twist_point[:, segment]
    line = family.twist_axis[:, segment]
    out = arm - np.einsum("bsi,bsi->bs", arm, line)[..., None] * line
    up = chain.upward[:, None] == 1
    below = family.in_child[:, chain.joint]
    above = family.in_parent[:, chain.joint]
    return Limbs(
        skin=_skin(body, sphere, moving),
        chain=chain,
        centre=_columns(family.centre[:, sphere]),
        out=_columns(out),
        across=_columns(np.cross(line, out)),
        radius=np.ascontiguousarray(family.radius[:, sphere]),
        twist_axis=family.twist_axis,
        twist_share=np.ascontiguousarray(family.twist_share[:, sphere]),
        blend_share=np.ascontiguousarray(family.blend_share[:, sphere]),
        blend_point=_blend_points(family, sphere, segment),
        at_came=np.ascontiguousarray(np.where(up, below, above)),
        at_to=np.ascontiguousarray(np.where(up, above, below)),
        solid=np.ascontiguousarray(
            solids(family.bodies, family.centre, limb)[:, sphere].astype(np.int64)
        ),
        segment=segment,
        link=link[segment],
        carrier=carrier[segment],
        joint=np.array(joints, dtype=np.int64),
        free=np.isin(joints, limb.free).astype(np.int64),
        axes=np.array(body.stops.axes),
        base=limb.base,
    )


def _carriers(body: Body, limb: Limb, joints: Sequence[int]) -> tuple[Ints, Ints]:
    """(N,) the link of the chain that each moving segment goes along with, and that link's segment:
    what hangs on the chain without being in it (the head) goes with the last link before it."""
    link = np.zeros(len(body.segments), dtype=np.int64)
    carrier = np.full(len(body.segments), limb.base)
    own = {joint + 1: k + 1 for k, joint in enumerate(joints)}
    for n in range(len(body.segments)):
        if n in own:
            link[n] = own[n]
            carrier[n] = n
        elif body.parent[n] >= 0:
            link[n] = link[body.parent[n]]
            carrier[n] = carrier[body.parent[n]]
    return link, carrier


def _columns(values: Floats) -> Floats:
    return np.ascontiguousarray(values.transpose(0, 2, 1))


def _blend_points(family: Family, sphere: Ints, segment: Ints) -> Floats:
    """(B, S, 3) the joint that a sphere is blended across, in its own segment's frame; zero where
    it is rigid."""
    joint = family.bodies[0].blend_joint[sphere]
    own = np.where(
        (joint == segment - 1)[:, None], family.in_child[:, joint], family.in_parent[:, joint]
    )
    return np.ascontiguousarray(np.where((joint >= 0)[:, None], own, 0.0))


def _skin(body: Body, sphere: Ints, moving: Bools) -> Skin:
    """The skin of one body with only these spheres in it, numbered anew."""
    whole = packed_skin(body, moving)
    place = np.full(len(body.sphere_names), -1)
    place[sphere] = np.arange(len(sphere))
    start = np.concatenate(
        [[0], np.cumsum(np.bincount(body.sphere_segment[sphere], minlength=len(body.segments)))]
    )
    blended = whole.blended[place[whole.blended] >= 0]
    counts = np.bincount(body.sphere_segment[blended], minlength=len(body.segments))
    # copies, so that kernels see arrays of one kind, however the body was made: each other kind is
    # compiled anew
    return whole._replace(
        twist_axis=np.array(whole.twist_axis),
        twist_share=np.array(whole.twist_share),
        blend_share=np.array(whole.blend_share),
        twist_joint=np.array(whole.twist_joint),
        start=start.astype(np.int64),
        blend_joint=np.ascontiguousarray(whole.blend_joint[sphere]),
        blended=place[blended],
        blend_start=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        distal=np.ascontiguousarray(whole.distal[sphere]),
    )
