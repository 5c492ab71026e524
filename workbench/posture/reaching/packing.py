"""Limbs of a body packed for the kernels: their chains of joints, and the spheres that they carry."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from workbench.body.forward import packed_chain, packed_skin
from workbench.body.kernels.forward import Chain, Skin
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body, logical_window
from workbench.model.kept import kept_by_row
from workbench.model.skinning import blend_point
from workbench.posture.kernels.chain_kinematics import Linkage
from workbench.posture.kernels.limb_contacts import Limbs
from workbench.posture.reaching.limbs import Limb
from workbench.posture.reaching.linkage import joints_between, linkage

__all__ = ["packed_limbs", "packed_links"]

_LINK_ROWS = ("at_parent", "at_child", "tip", "pointing")
"""The fields of a `Linkage` with a row for each body; the others are of the topology."""
_LIMB_ROWS = (
    "centre",
    "out",
    "across",
    "radius",
    "twist_axis",
    "twist_share",
    "blend_share",
    "blend_point",
    "at_came",
    "at_to",
    "solid",
    "grip",
    "grip_arm",
    "tip",
)
"""The same of `Limbs`."""


def _link_rows(link: Linkage, rows: Ints) -> Linkage:
    return link._replace(**{name: getattr(link, name)[rows] for name in _LINK_ROWS})


def _limb_rows(limbs: Limbs, rows: Ints) -> Limbs:
    return limbs._replace(**{name: getattr(limbs, name)[rows] for name in _LIMB_ROWS})


@kept_by_row(_link_rows)
def packed_links(body: Body, limb: Limb) -> Linkage:
    """Pack the chain of a limb, with the lengths of all rows of the body."""
    return linkage(body, limb.base, limb.end, limb.free, limb.tip, limb.pointing)


@kept_by_row(_limb_rows)
def packed_limbs(body: Body, limb: Limb) -> Limbs:
    """Pack the segments that move with a limb, and their spheres, for all B rows of the body."""
    shown = logical_window(body, [body.segments[n] for n in limb.moving], limb.base)
    chain = packed_chain(body, limb.base, shown)
    moving = np.isin(np.arange(len(body.segments)), limb.moving)
    sphere = np.flatnonzero(moving[body.sphere_segment])
    segment = body.sphere_segment[sphere]
    joints = joints_between(body, limb.base, limb.end)
    link, carrier = _carriers(body, limb, joints)
    out, across = _twist_arms(body, sphere)
    grip, grip_arm = _grips(body, limb, sphere)
    came, to = _joint_points(body, chain)
    return Limbs(
        skin=_skin(body, sphere, moving),
        chain=chain,
        centre=_columns(body.centre[:, sphere]),
        out=_columns(out),
        across=_columns(across),
        radius=np.ascontiguousarray(body.radius[:, sphere]),
        twist_axis=np.array(body.twist_axis),
        twist_share=np.ascontiguousarray(body.twist_share[:, sphere]),
        blend_share=np.ascontiguousarray(body.blend_share[:, sphere]),
        blend_point=np.ascontiguousarray(blend_point(body)[:, sphere]),
        at_came=came,
        at_to=to,
        solid=np.ascontiguousarray(limb.solid[:, sphere].astype(np.int64)),
        segment=segment,
        link=link[segment],
        carrier=carrier[segment],
        joint=np.array(joints, dtype=np.int64),
        free=np.isin(joints, limb.free).astype(np.int64),
        axes=np.array(body.stops.axes),
        base=limb.base,
        grip=grip,
        grip_arm=grip_arm,
        tip=np.array(limb.tip),
        rigid=np.flatnonzero(_rigid(body, limb, sphere).all(axis=0)),
    )


def _grips(body: Body, limb: Limb, sphere: Ints) -> tuple[Ints, Floats]:
    """Of each row of the body the place (B,) in `sphere` of the solid sphere that is rigid in the
    segment that arrives and has the greatest r - d, with its radius r and its centre d (B,) [m]
    from the tip; -1 where there is none."""
    arm = np.linalg.norm(body.centre[:, sphere] - limb.tip[:, None], axis=2)
    counts = _rigid(body, limb, sphere)
    best = np.argmax(np.where(counts, body.radius[:, sphere] - arm, -np.inf), axis=1)
    rows = np.arange(len(body))
    return np.where(counts[rows, best], best, -1), arm[rows, best]


def _rigid(body: Body, limb: Limb, sphere: Ints) -> Bools:
    """(B, S) which of some spheres are solid and rigid in the segment that arrives."""
    rigid = (body.blend_share[:, sphere] == 0) & (body.twist_share[:, sphere] == 0)
    found: Bools = rigid & limb.solid[:, sphere] & (body.sphere_segment[sphere] == limb.end)
    return found


def _twist_arms(body: Body, sphere: Ints) -> tuple[Floats, Floats]:
    """Arms (B, S, 3) [m] of spheres from the axis of their segment's twist, and axis x arm.

    A turn by t about the axis moves the end of an arm a to a cos t + (axis x a) sin t.
    """
    segment = body.sphere_segment[sphere]
    arm = body.centre[:, sphere] - body.twist_point[:, segment]
    line = body.twist_axis[:, segment]
    out: Floats = arm - np.einsum("bsi,bsi->bs", arm, line)[..., None] * line
    return out, np.cross(line, out)


def _joint_points(body: Body, chain: Chain) -> tuple[Floats, Floats]:
    """Joints (B, M, 3) [m] in the frames of the segments before and after them, from the held one.

    A joint that is passed inward, against the body's tree, has the two exchanged.
    """
    inward = chain.upward[:, None] == 1
    below = body.joint_in_child[:, chain.joint]
    above = body.joint_in_parent[:, chain.joint]
    came = np.ascontiguousarray(np.where(inward, below, above))
    return came, np.ascontiguousarray(np.where(inward, above, below))


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
