"""Standing people who lean, bend, squat and step so that their hands come to their targets.

The posture is the most comfortable one in which both feet stand flat, the hands are on their targets,
every joint is within its stops and the centre of mass is over the soles (`posture.balance`). Hips,
knees, ankles, trunk and arms are found together. What is asked is the posture of a person who takes
time; nothing leans on anything, and obstacles do not count.

Discomfort is that of `reach`: the sum of squared distances from comfort modes in units of half the
comfortable range. Here the modes of legs and trunk are the angles of the posture that the person
stands in, since the published modes of legs are those of drivers. A step counts as an angle at the
end of its range every 250 mm: this project's choice.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from workbench.body.forward import place, segment_frames
from workbench.errors import InputError, UsageError, one_of
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.joint_angles import angles_of, attitude_matrix, compose, motion_of
from workbench.model.kept import kept_with_topology
from workbench.model.poses import Placed, Poses, check_rows, people_of
from workbench.model.stops import StopKind
from workbench.posture.balance import (
    balance,
    centre_of_mass,
    edges_of,
    sole_points,
    support_polygon,
)
from workbench.posture.kernels.limit_violation import StopPack
from workbench.posture.kernels.standing import NUMBERS, STEPS, Stander, StandingRows, solve_standing
from workbench.posture.reaching.comfort import comfort_modes
from workbench.posture.reaching.limbs import HANDS, limb
from workbench.posture.reaching.reach_solver import on_grid
from workbench.posture.stops import packed_stops
from workbench.threads import run_in_threads

__all__ = ["BALANCE_MARGIN", "STANDS_AT", "StandingPosture", "standing_posture"]

BALANCE_MARGIN = 0.01
"""How far [m] the centre of mass is to stay within the support polygon."""
STANDS_AT = 1e-3
"""A foot, or the centre of mass, that is off by less [m] is where it is to be."""
REACHED_AT = 1e-4
"""A hand that is off by less [m] is where it is to be."""
STEP_UNIT = 0.25
"""A step [m] that counts as much as an angle at the end of its comfortable range."""
EASY = 10.0
"""Discomfort up to which the first posture that is found is taken: no other kind is easier then."""
DRAWN_IN = 2e-3
"""[rad, m] Stops and borders are drawn in by this, since they hold as penalties."""
PIECE = 4
"""Rows that a thread takes at a time."""
_LEGS = ("LH", "LK", "LA", "RH", "RK", "RA")
_TRUNK = ("W", "SP")
_ARM = ("C", "S", "E", "W")
_FEET = ("RF", "LF")
_STARTS: tuple[Mapping[str, Mapping[str, float]], ...] = (
    {},
    {"LH": {"flexion": 50}, "RH": {"flexion": 50}, "W": {"flexion": 20}, "SP": {"flexion": 10}},
    {
        "LH": {"flexion": 80},
        "RH": {"flexion": 80},
        "LK": {"flexion": 80},
        "RK": {"flexion": 80},
        "LA": {"dorsiflexion": 20},
        "RA": {"dorsiflexion": 20},
        "W": {"flexion": 15},
    },
)
"""What legs and trunk begin at beyond the posture [degrees]: upright, bent forward, squatting."""


@dataclass(frozen=True, eq=False)
class StandingPosture:
    """P standing postures."""

    poses: Poses
    """(P,) in the world."""
    stepped: Floats
    """(P, 2) [m] how far the feet have stepped, forward and to the left."""
    miss: Mapping[str, Floats]
    """(P,) [m] by hand: its distance from its target."""
    discomfort: Floats
    """(P,)."""
    margin: Floats
    """(P,) [m] how far the centre of mass is within the support polygon."""
    stands: Bools
    """(P,) whether feet, stops and balance are kept. Where they are not, no posture was found and
    the pose is the one that was given."""


def standing_posture(
    body: Body,
    poses: Poses,
    hands: Mapping[str, tuple[str, ArrayLike]],
    *,
    area: ArrayLike = ((0.0, 0.0), (0.0, 0.0)),
    heading: float = 0.0,
    margin: float = BALANCE_MARGIN,
    threads: int | None = None,
) -> StandingPosture:
    """Predict the postures of P people who stand, from the targets of their hands.

    Each row is found by itself. What is found is the best of three descents, from upright, bent and
    squatting postures. A target that is not reached is missed by the distance of the posture that
    was found, which need not be the least.

    Parameters
    ----------
    body, poses
        P poses of the rows of a body, standing flat: of one person, of each row in their order, or
        of the rows that `poses.person` names. Head, and arms without a target, stay as they are.
    hands
        By "left hand" or "right hand" the grip, and the target (3,) or (P, 3) [m].
    area
        (2, 2), or (P, 2, 2), [m] least and greatest step, forward and to the left; the feet stay if
        nothing.
    heading
        [rad] the way that is forward, from x to y.
    margin
        How far [m] the centre of mass is to stay within the support polygon.
    threads
        All cores if None. No answer depends on it.

    Raises
    ------
    UsageError
        If the numbers of rows do not match, or an area does not rise.
    InputError
        If the body has no mass, no feet or no such hand, or lacks the landmark of a grip.
    """
    check_rows(poses, len(poses), "poses")
    wrong = [name for name in hands if name not in HANDS]
    if wrong:
        raise InputError(f"no hand {wrong[0]!r}; {one_of(wrong[0], HANDS)}")
    ends = np.asarray(area, dtype=np.float64)
    if ends.shape[-2:] != (2, 2) or not np.all(ends[..., 0] <= ends[..., 1]):
        raise UsageError(
            f"area: expected two pairs of a least and a greatest step [m], got {area!r}"
        )
    count = len(poses)
    turn = attitude_matrix(yaw=heading)
    own = _in_own_axes(poses, turn)
    placed = place(body, own)
    centre_of_mass(placed)  # refuses a body without mass
    stander = _stander(body, tuple((name, grip) for name, (grip, _) in hands.items()))
    goals = np.array(
        [np.broadcast_to(np.asarray(at, dtype=np.float64), (count, 3)) for _, at in hands.values()]
    )
    goals = np.ascontiguousarray(goals.reshape(len(hands), count, 3).swapaxes(0, 1))
    origin = poses.world_from_reference[:, None, :, 3]
    standing = StandingRows(
        who=people_of(body, poses),
        foot=_frames(placed, _FEET[0]),
        other=_frames(placed, _FEET[1]),
        edges=_edges(placed, margin),
        area=np.array(np.broadcast_to(ends, (count, 2, 2))),
        goal=on_grid((goals - origin) @ turn),
        mode=_modes(body, own, stander),
    )
    unknown, numbers = _solved(body, own, stander, standing, threads)
    stands = _stands(numbers)
    moved = _moved(body, own, placed, stander, unknown)
    world = turn @ moved.world_from_reference
    world[:, :, 3] += origin[:, 0]
    kept = replace(
        poses,
        rotations=np.where(stands[:, None, None], moved.rotations, poses.rotations),
        world_from_reference=np.where(stands[:, None, None], world, poses.world_from_reference),
    )
    after = place(body, kept)
    miss = {
        name: np.linalg.norm(_tips(after, stander, h) - goals[:, h], axis=1)
        for h, name in enumerate(hands)
    }
    stepped = np.where(stands[:, None], unknown[:, :STEPS], 0.0)
    discomfort = numbers[:, 0]
    return StandingPosture(kept, stepped, miss, discomfort, balance(after).margin, stands)


def _solved(
    body: Body, poses: Poses, stander: Stander, standing: StandingRows, threads: int | None
) -> tuple[Floats, Floats]:
    """Unknowns (P, 2 + n) and NUMBERS (P, 6) of the best descent of each row. Rows that come to an
    easy posture from upright begin at no other."""
    starts = _starts(body, stander, standing.mode)
    count = len(starts)
    found = np.zeros(starts.shape)
    numbers = np.full((*starts.shape[:2], NUMBERS), np.inf)
    rotations = np.ascontiguousarray(poses.rotations)
    rows = np.arange(count)
    for some in (slice(0, 1), slice(1, len(_STARTS))):
        asked = StandingRows(
            who=standing.who[rows],
            foot=standing.foot[rows],
            other=standing.other[rows],
            edges=standing.edges[rows],
            area=standing.area[rows],
            goal=standing.goal[rows],
            mode=standing.mode[rows],
        )
        first = np.ascontiguousarray(starts[rows, some])
        unknown = np.zeros(first.shape)
        told = np.zeros((*first.shape[:2], NUMBERS))
        work = partial(solve_standing, stander, asked, rotations[rows], first, unknown, told)
        run_in_threads(work, len(rows), PIECE, threads=threads)
        found[rows, some] = unknown
        numbers[rows, some] = told
        easy = _stands(told[:, 0]) & (told[:, 0, 1] < REACHED_AT) & (told[:, 0, 0] < EASY)
        rows = rows[~easy]
        if not len(rows):
            break
    best = np.array([_best(row) for row in numbers])
    return found[np.arange(count), best], numbers[np.arange(count), best]


def _in_own_axes(poses: Poses, turn: Floats) -> Poses:
    """The poses in axes of each row at its reference segment, turned (3, 3) against the world, rounded:
    so the last digits, which are others elsewhere, choose no posture."""
    world = np.zeros((len(poses), 3, 4))
    world[:, :, :3] = on_grid(turn.T @ poses.world_from_reference[:, :, :3])
    return replace(poses, world_from_reference=world)


def _frames(placed: Placed, segment: str) -> Floats:
    """(P, 3, 4) [m] the frames of a segment."""
    return np.ascontiguousarray(placed.world_from_segment[:, placed.body.segment(segment)])


def _edges(placed: Placed, margin: float) -> Floats:
    """(P, E, 3) the edges of the support polygons, drawn in by a margin [m]; see `StandingRows`."""
    each = [edges_of(support_polygon(points)) for points in sole_points(placed)]
    most = max((len(offset) for _, offset in each), default=0)
    edges = np.zeros((len(placed), most, 3))
    edges[:, :, 2] = -np.inf
    for row, (inward, offset) in enumerate(each):
        edges[row, : len(offset), :2] = inward
        edges[row, : len(offset), 2] = offset + margin
    return edges


def _stander(body: Body, hands: tuple[tuple[str, str], ...]) -> Stander:
    """Bodies for the kernel, with what they are free to turn."""
    limbs = [limb(body, name, grip=grip, zone=2) for name, grip in hands]
    joint, axis = _free_angles(body, tuple(name for name, _ in hands))
    total = body.mass.sum(axis=1, keepdims=True)
    half = np.array([comfort_modes(body, j)[1][a] for j, a in zip(joint, axis, strict=True)])
    tips = np.array([one.tip for one in limbs]).reshape(len(limbs), len(body), 3)
    return Stander(
        parent=np.ascontiguousarray(body.parent),
        root=np.array([body.segment("LT")]),
        feet=np.array([body.segment(name) for name in _FEET]),
        at_parent=np.ascontiguousarray(body.joint_in_parent),
        at_child=np.ascontiguousarray(body.joint_in_child),
        mass=body.mass / total,
        axes=np.ascontiguousarray(body.stops.axes),
        stops=_drawn_in(packed_stops(body), joint),
        joint=joint,
        axis=axis,
        weight=1.0 / half,
        step=np.full(STEPS, 1.0 / STEP_UNIT),
        hands=np.array([one.end for one in limbs], dtype=np.int64),
        tips=np.ascontiguousarray(tips.swapaxes(0, 1)),
    )


@kept_with_topology
def _free_angles(body: Body, hands: tuple[str, ...]) -> tuple[Ints, Ints]:
    """The joints (n,) that turn, one after the other, and which (n,) of their angles."""
    arms = [name[0].upper() + letter for name in hands for letter in _ARM]
    found = []
    for name in (*_LEGS, *_TRUNK, *arms):
        joint = body.joint(name)
        range_ = body.stops.limits[joint].sum(axis=1)
        # a straight knee does not twist: how far it may follows its flexion
        axes = [a for a in range(3) if range_[a] > 2.0 * DRAWN_IN and (name[1:] != "K" or a < 2)]
        found += [(joint, axis) for axis in axes]
    pairs = np.array(found, dtype=np.int64)
    return pairs[:, 0].copy(), pairs[:, 1].copy()


def _drawn_in(pack: StopPack, turned: Ints) -> StopPack:
    """Stops whose limits are reached a little earlier by the joints that turn.

    A knee that may not be bent backward at all is bent forward that little.
    """
    mine = np.zeros(len(pack.kind), dtype=np.bool_)
    mine[turned] = True
    moves = pack.limits.sum(axis=2, keepdims=True) > 2.0 * DRAWN_IN
    hinge = (pack.kind == StopKind.HINGE)[:, None, None]
    some = mine[:, None, None] & moves & (hinge | (pack.limits > DRAWN_IN))
    coupling = pack.coupling.copy()
    own = mine[coupling[:, 0].astype(np.int64)]
    coupling[own, 7:9] = np.maximum(coupling[own, 7:9] - DRAWN_IN, 0.0)
    return pack._replace(
        limits=np.where(some, pack.limits - DRAWN_IN, pack.limits), coupling=coupling
    )


def _modes(body: Body, poses: Poses, stander: Stander) -> Floats:
    """(P, n) [rad] where each angle is most comfortable: of arms the published modes, of legs and
    trunk as they stand."""
    angles = angles_of(body, poses)[:, stander.joint, stander.axis]
    modes = np.array(
        [
            comfort_modes(body, j)[0][a]
            for j, a in zip(stander.joint.tolist(), stander.axis.tolist(), strict=True)
        ]
    )
    own = [body.joint(name) for name in (*_LEGS, *_TRUNK)]
    return np.where(np.isin(stander.joint, own), angles, modes)


def _starts(body: Body, stander: Stander, mode: Floats) -> Floats:
    """(P, S, 2 + n) the unknowns that descents begin at."""
    starts = np.zeros((len(mode), len(_STARTS), STEPS + mode.shape[1]))
    starts[:, :, STEPS:] = mode[:, None]
    for s, turned in enumerate(_STARTS):
        for name, motions in turned.items():
            joint = body.joint(name)
            for motion, degrees in motions.items():
                axis, sign = motion_of(body, joint, motion)
                at = np.flatnonzero((stander.joint == joint) & (stander.axis == axis))
                starts[:, s, STEPS + at] += sign * np.radians(degrees)
    return starts


def _stands(numbers: Floats) -> Bools:
    """Whether postures keep feet, balance and stops; numbers (..., NUMBERS)."""
    return (
        (numbers[..., 2] < STANDS_AT)
        & (numbers[..., 3] > -STANDS_AT)
        & (numbers[..., 4] < DRAWN_IN)
    )


def _best(numbers: Floats) -> int:
    """The best of some descents (S, NUMBERS): one that stands, then that of the least miss, then the
    most comfortable."""
    falls = ~_stands(numbers)
    miss = np.where(numbers[:, 1] < REACHED_AT, 0.0, np.round(numbers[:, 1], 4))
    return int(np.lexsort((numbers[:, 0], miss, falls))[0])


def _moved(body: Body, poses: Poses, placed: Placed, stander: Stander, unknown: Floats) -> Poses:
    """Poses in their own axes with unknowns (P, 2 + n) as they were found, placed by the segment that poses had."""
    angles = angles_of(body, poses)
    angles[:, stander.joint, stander.axis] = unknown[:, STEPS:]
    rotations = poses.rotations.copy()
    turned = np.unique(stander.joint)
    rotations[:, turned] = compose(body, angles)[:, turned]
    foot = _frames(placed, _FEET[0]).copy()
    foot[:, :STEPS, 3] += unknown[:, :STEPS]
    by_foot = Poses(rotations, body.segment(_FEET[0]), foot, person=poses.person)
    world = segment_frames(body, by_foot, poses.reference)
    return Poses(rotations, poses.reference, world, poses.time, poses.person)


def _tips(placed: Placed, stander: Stander, hand: int) -> Floats:
    """(P, 3) [m] where the point of a hand that arrives is."""
    frame = placed.world_from_segment[:, stander.hands[hand]]
    tip = stander.tips[placed.person, hand]
    return np.einsum("pij,pj->pi", frame[:, :, :3], tip) + frame[:, :, 3]
