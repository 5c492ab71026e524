"""Pose pairs packed for continuous contact: the frames placed, how their joints turn, where a
sphere is on the way."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from workbench.body.forward import packed_chain, packed_skin, place
from workbench.body.kernels.forward import Chain, Skin, chain_transforms, place_spheres
from workbench.contact.kernels.motion_bounds import (
    Levers,
    PoseTurns,
    aim,
    bound_segments,
    chord_deviation,
    turn_on,
)
from workbench.errors import InputError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body, check_one, logical_window
from workbench.model.poses import Placed, Poses, check_joints
from workbench.model.quaternions import from_matrices, matrices
from workbench.model.skinning import blend_point, twist_shared

__all__ = [
    "BodyMotion",
    "centres_at",
    "check_times",
    "frames_of",
    "joint_discontinuities",
    "pack_motion",
    "ways",
]

MOST_PLACED = 1024
"""Bodies placed at a time on the way, to bound the memory."""


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """P pose pairs of a body, from frame first (P,) to frame second (P,) of F placed frames.

    rotations (F, J + 1, 4): unit quaternions, the reference segment's last; origin (F, 3): where
    that segment is [m].
    """

    placed: Placed
    reference: int
    rotations: Floats
    origin: Floats
    first: Ints
    second: Ints
    chain: Chain
    skin: Skin
    levers: Levers
    turns: PoseTurns

    @property
    def body(self) -> Body:
        """The body that moves."""
        return self.placed.body


def pack_motion(
    body: Body, frames: Poses, pairs: tuple[Ints, Ints], *, window: Iterable[str] | None = None
) -> BodyMotion:
    """Pose pairs first (P,), second (P,) of the frames (F) of a body; segments outside the window
    hold NaN."""
    check_one(body)
    check_joints(body, frames)
    shown = logical_window(body, window, frames.reference)
    turn = from_matrices(frames.world_from_reference[:, :, :3])
    world = np.concatenate([matrices(turn), frames.world_from_reference[:, :, 3:]], axis=2)
    joints = frames.rotations / np.linalg.norm(frames.rotations, axis=-1, keepdims=True)
    placed = place(body, Poses(joints, frames.reference, world), window=window)
    chain = packed_chain(body, frames.reference, shown)
    entry = np.zeros((len(body.segments), 3))
    entry[chain.to] = chain.at_to
    levers, twisted = _levers(body, entry)
    rotations = np.concatenate([joints, turn[:, None]], axis=1)
    origin = np.ascontiguousarray(world[:, :, 3])
    count = len(pairs[0])
    many = len(body.joints)
    turns = PoseTurns(
        goal=np.empty((count, many + 1, 4)),
        half=np.empty((count, many + 1)),
        bound=np.zeros((count, many + 1, 4)),
        twist=np.full((count, many + 1, 6), 2.0),
    )
    aim(rotations, *pairs, body.stops.axes[:, 2].copy(), twisted.astype(np.int64), turns)
    shift = np.linalg.norm(origin[pairs[1]] - origin[pairs[0]], axis=1)
    bound_segments(shift, turns.half, chain, entry, frames.reference, turns.bound)
    return BodyMotion(
        placed,
        frames.reference,
        rotations,
        origin,
        *pairs,
        chain,
        packed_skin(body, shown),
        levers,
        turns,
    )


def frames_of(start: Poses, end: Poses) -> tuple[Poses, tuple[Ints, Ints]]:
    """Start and end poses as one batch of frames, and the pairs."""
    rotations = np.concatenate([start.rotations, end.rotations])
    world = np.concatenate([start.world_from_reference, end.world_from_reference])
    count = np.arange(len(start))
    return Poses(rotations, start.reference, world), (count, count + len(start))


def check_times(motion: Poses) -> Floats:
    """(F,) [s] the times of a motion's frames, or their numbers where it has none; InputError where
    there are fewer than two frames, or their times do not rise."""
    if len(motion) < 2:
        raise InputError(f"a motion needs at least two frames, got {len(motion)}")
    time = motion.clock
    if not np.all(np.isfinite(time)) or not np.all(np.diff(time) > 0):
        raise InputError("the times of a motion's frames must be finite and rise")
    return time


def ways(mover: BodyMotion, pair: Ints, sphere: Ints, begin: Floats, end: Floats) -> Floats:
    """(M,) [m] how far the centre of each sphere may be from its chord between two times of its
    pose pair."""
    way = np.empty(len(pair))
    # in order in memory: the kernels are compiled for that, and anew for any other order
    columns = [np.ascontiguousarray(column) for column in (pair, sphere, begin, end)]
    chord_deviation(mover.turns, mover.levers, *columns, way)
    return way


def joint_discontinuities(mover: BodyMotion, pair: Ints, sphere: Ints) -> Floats:
    """(M,) the time at which a sphere jumps because the twist it shares passes half a turn; 2 where
    it does not."""
    joint = mover.levers.twist_joint[sphere]
    shares = mover.levers.twist[sphere] > 0
    return np.where(shares, mover.turns.twist[pair, joint, 5], 2.0)


def centres_at(mover: BodyMotion, pair: Ints, sphere: Ints, time: Floats) -> Floats:
    """(M, 3) [m] where spheres (M,) are at a time 0..1 of their pose pairs (M,)."""
    frame = np.where(time <= 0.0, mover.first[pair], mover.second[pair])
    out = mover.placed.centres[frame, sphere]
    rows = np.flatnonzero((time > 0.0) & (time < 1.0))
    if not len(rows):
        return out
    rows = rows[np.lexsort((time[rows], pair[rows]))]
    p = pair[rows]
    t = time[rows]
    fresh = np.concatenate([[True], (np.diff(p) != 0) | (np.diff(t) != 0)])
    at = np.cumsum(fresh) - 1
    starts = np.flatnonzero(fresh)
    for begin in range(0, len(starts), MOST_PLACED):
        some = starts[begin : begin + MOST_PLACED]
        mine = slice(
            int(some[0]),
            int(starts[begin + len(some)]) if begin + len(some) < len(starts) else len(rows),
        )
        shown = np.zeros(len(mover.body.segments), dtype=np.bool_)
        shown[mover.levers.segment[sphere[rows[mine]]]] = True
        centres = _placed_between(mover, p[some], t[some], shown)
        out[rows[mine]] = centres[at[mine] - begin, sphere[rows[mine]]]
    return out


def _placed_between(mover: BodyMotion, pair: Ints, time: Floats, shown: Bools) -> Floats:
    """(U, S, 3) the spheres of the segments shown (N,) at times (U,) of pairs (U,)."""
    body = mover.body
    joints = len(mover.body.joints)
    turned = np.empty((len(pair), joints + 1, 4))
    world = np.full((len(pair), len(body.segments), 3, 4), np.nan)
    frames = mover.first, mover.second
    turn_on(
        mover.rotations,
        mover.origin,
        frames,
        mover.turns,
        mover.reference,
        pair,
        time,
        turned,
        world,
    )
    rotations = np.ascontiguousarray(turned[:, :joints])
    chain_transforms(rotations, mover.chain, 0, world)
    centres = np.empty((len(pair), len(body.sphere_names), 3))
    skin = mover.skin._replace(shown=shown.astype(np.int64))
    place_spheres(rotations, world, skin, centres)
    return centres


def _levers(body: Body, entry: Floats) -> tuple[Levers, Bools]:
    """What makes each sphere stray, and the joints (J,) whose twist is shared."""
    segment = body.sphere_segment
    turns = (body.twist_joint[segment] >= 0) & (body.twist_share[0] > 0)
    axis = body.twist_axis[0, segment]
    point = body.twist_point[0, segment]
    foot = point + np.einsum("si,si->s", body.centre[0] - point, axis)[:, None] * axis
    off = np.linalg.norm(body.centre[0] - foot, axis=1)

    def farthest(at: Floats) -> Floats:
        circle = np.linalg.norm(foot - at, axis=1) + off
        return np.where(turns, circle, np.linalg.norm(body.centre[0] - at, axis=1))

    blends = (body.blend_joint >= 0) & (body.blend_share[0] > 0)
    joint = body.blend_joint
    point = blend_point(body)[0]
    shared = twist_shared(body)
    reach = np.where(
        blends,
        np.linalg.norm(point - entry[segment], axis=1) + farthest(point),
        farthest(entry[segment]),
    )
    blend_twist = np.where(blends & np.append(shared, False)[joint], joint, -1)
    twisted = np.zeros(len(body.joints), dtype=np.bool_)
    twisted[body.twist_joint[segment[turns]]] = True
    twisted[blend_twist[blend_twist >= 0]] = True
    levers = Levers(
        segment=segment,
        reach=reach,
        twist=np.where(turns, body.twist_share[0] * off, 0.0),
        twist_joint=body.twist_joint[segment],
        blend=np.where(blends, body.blend_share[0] * farthest(point), 0.0),
        blend_joint=joint,
        blend_twist=blend_twist,
    )
    return levers, twisted
