"""Standing postures: the most comfortable angles of a whole body whose feet stand flat, whose hands
are on their targets and whose centre of mass is over the soles.

The unknowns are how far the feet step, and angles of joints. The right foot is where it stands by
construction; the chain from it over the pelvis to the left foot is closed by six equations. Discomfort
is a sum of squares, so a step is Gauss and Newton's on the sum of the squares of all residuals,
damped after Levenberg and Marquardt ([1]_ chapter 10). Derivatives are differences. Targets, the left
foot and balance are held by the method of multipliers ([1]_ chapter 17): the residual of an equation
c = 0 is sqrt(w) (c + s), and the shift s grows by c after each descent. Joint stops, and the borders
of the area to step in, are stiff penalties within their true places.

A hand that cannot come to its target pulls with a force that does not grow with the distance, so that
it wins neither over the stops nor over the balance.

References
----------
.. [1] J. Nocedal and S. J. Wright (2006), Numerical Optimization, 2nd edition, Springer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.rotation import product, quaternion_matrix, swing_twist_quaternion
from workbench.compiled import inlined, inner, njit
from workbench.geometry.vectors import (
    add,
    matvec,
    norm,
    rotation_part,
    scale,
    store,
    subtract,
    vector,
)
from workbench.posture.kernels.cholesky import LEAST_PIVOT, factorise, substitute
from workbench.posture.kernels.limit_violation import StopPack, past_stops

__all__ = ["NUMBERS", "STEPS", "Stander", "StandingRows", "solve_standing"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

STEPS = 2
"""The first unknowns: steps [m] forward and to the left."""
NUMBERS = 6
"""What is told of a posture: discomfort, the greatest miss of a hand [m], that of the left foot [m],
how far the centre of mass is within what is asked [m], the greatest excess past a stop that was
drawn in [rad], and descents."""

_ROUNDS = 24
"""Descents at most; multipliers are renewed between them."""
_INNER = 12
"""Steps of a descent."""
_TRIES = 7
"""Dampings that are tried for a step."""
_NUDGE = 1e-7
"""Change [rad, m] of an unknown by which derivatives are taken."""
_MOST = 0.5
"""Largest change [rad, m] of an unknown in a step."""
_DONE = 1e-6
"""Miss [m] at which equations are met."""
_DONE_LOST = 1e-4
"""The same where a hand is lost: how far it stays off is known to no better than that."""
_SMALL = 1e-7
"""A step [rad, m] that is none."""
_HAND = 1e5
"""Weight [1/m2] of a hand's miss."""
_HAND_LIMIT = 0.02
"""Miss [m] beyond which a hand pulls no harder."""
_LOST = 3e5
_LOST_LIMIT = 0.002
"""The same of a hand that cannot come to its target: its comfort counts for little."""
_FOOT = 1e5
"""Weight [1/m2] of the left foot's miss."""
_FOOT_LEVER = 0.3
"""Distance [m] that a radian of the left foot counts as."""
_EDGE = 1e5
"""Weight [1/m2] of the centre of mass beyond an edge."""
_STOP = 1e6
"""Weight [1/rad2, 1/m2] of an excess past a stop or a border."""
_FROZEN = 1e-3
_GAIN = 0.8
"""A hand is lost that stays farther from its target than this [m], and than this share of its
distance a round before, after _PATIENCE rounds."""
_PATIENCE = 5


class Stander(NamedTuple):
    """Who stands: B bodies of N segments and J joints, with n unknown angles and H hands."""

    parent: Ints
    """(N,) the segment that each hangs on."""
    root: Ints
    """(1,) the pelvis, from which the others are placed."""
    feet: Ints
    """(2,) the right foot, which stands, and the left one."""
    at_parent: Floats
    """(B, J, 3) [m] joints in the frame of the parent."""
    at_child: Floats
    """(B, J, 3) [m] and of the segment itself."""
    mass: Floats
    """(B, N) the shares of the mass, 1 together."""
    axes: Floats
    """(J, 3, 3) two swing axes and the twist axis."""
    stops: StopPack
    """Stops of all joints, drawn in a little."""
    joint: Ints
    """(n,) the joint of each unknown angle."""
    axis: Ints
    """(n,) and which of its three angles."""
    weight: Floats
    """(n,) [1/rad] one over half its comfortable range."""
    step: Floats
    """(2,) [1/m] the same for steps forward and to the left."""
    hands: Ints
    """(H,) segments of the hands that have a target."""
    tips: Floats
    """(B, H, 3) [m] the points of theirs that arrive."""


class StandingRows(NamedTuple):
    """What is asked of P rows, in axes of each, x ahead and z up."""

    who: Ints
    """(P,) the row of the body."""
    foot: Floats
    """(P, 3, 4) [m] the right foot before any step."""
    other: Floats
    """(P, 3, 4) [m] the left one."""
    edges: Floats
    """(P, E, 3) inward normal and offset [m] of the edges within which the centre of mass is to
    stay, before any step; the offset of no edge is minus infinity."""
    area: Floats
    """(P, 2, 2) [m] least and greatest step forward and to the left."""
    goal: Floats
    """(P, H, 3) [m] targets of the hands."""
    mode: Floats
    """(P, n) [rad] where each angle is most comfortable."""


class _Workspace(NamedTuple):
    """Working arrays: n unknowns, R residuals."""

    rotations: Floats
    """(J, 4) joint rotations."""
    angles: Floats
    """(J, 3) [rad] all joint angles."""
    world: Floats
    """(N, 3, 4) [m] segments as the pelvis stands at the origin, then where they are."""
    residual: Floats
    """(R,) at the unknowns."""
    other: Floats
    """(R,) at changed unknowns."""
    jacobian: Floats
    """(R, n)."""
    normal: Floats
    """(n, n)."""
    slope: Floats
    """(n,)."""
    factor: Floats
    """(n, n)."""
    step: Floats
    """(n,)."""
    trial: Floats
    """(n,) changed unknowns."""
    shift: Floats
    """(3 H + 6 + E,) shifts of the equations and edges."""
    value: Floats
    """(3 H + 6 + E,) misses of the equations, and distances within edges."""
    lost: Ints
    """(H,) 1 for a hand that cannot come to its target."""
    limits: Floats
    """(J, 3, 2) [rad]."""
    measured: Floats
    """(J, 3) [rad]."""
    past: Floats
    """(J, 3) [rad] excess past the stops."""


@inlined
def _store_frame(rotation, origin, out):  # type: ignore[no-untyped-def]
    """Write a rotation (nine numbers) and an origin into a frame (3, 4)."""
    for i in range(3):
        for j in range(3):
            out[i, j] = rotation[3 * i + j]
        out[i, 3] = origin[i]


@inlined
def _origin(frame):  # type: ignore[no-untyped-def]
    """Read the origin of a frame (3, 4)."""
    return frame[0, 3], frame[1, 3], frame[2, 3]


@inner
def _place(unknown, who, stander, standing, p, work):  # type: ignore[no-untyped-def]
    """Turn the joints as the unknowns say and place all segments, the right foot where it stands."""
    for k in range(stander.joint.shape[0]):
        work.angles[stander.joint[k], stander.axis[k]] = unknown[STEPS + k]
    for k in range(stander.joint.shape[0]):
        j = stander.joint[k]
        if k == 0 or stander.joint[k - 1] != j:
            a = work.angles[j]
            q = swing_twist_quaternion(stander.axes, j, a[0], a[1], a[2])
            for i in range(4):
                work.rotations[j, i] = q[i]
    root = stander.root[0]
    world = work.world
    _store_frame((1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0), world[root])
    for n in range(root + 1, stander.parent.shape[0]):
        j = n - 1
        above = world[stander.parent[n]]
        q = work.rotations[j]
        turned = rotation_part(above)
        own = product(turned, quaternion_matrix(q[0], q[1], q[2], q[3]))
        at = add(_origin(above), matvec(turned, vector(stander.at_parent[who, j])))
        _store_frame(own, subtract(at, matvec(own, vector(stander.at_child[who, j]))), world[n])
    # the axes from the pelvis's: where the right foot stands, times the inverse of where it is
    foot = standing.foot[p]
    here = world[stander.feet[0]]
    back = rotation_part(here)
    inverse = (back[0], back[3], back[6], back[1], back[4], back[7], back[2], back[5], back[8])
    turn = product(rotation_part(foot), inverse)
    at = add(_origin(foot), (unknown[0], unknown[1], 0.0))
    move = subtract(at, matvec(turn, _origin(here)))
    for n in range(root, stander.parent.shape[0]):
        own = product(turn, rotation_part(world[n]))
        _store_frame(own, add(move, matvec(turn, _origin(world[n]))), world[n])


@inner
def _measure(unknown, who, stander, standing, p, work):  # type: ignore[no-untyped-def]
    """Fill the misses of the equations, the distances within the edges, and the excess past the
    stops."""
    _place(unknown, who, stander, standing, p, work)
    hands = stander.hands.shape[0]
    value = work.value
    for h in range(hands):
        frame = work.world[stander.hands[h]]
        tip = add(_origin(frame), matvec(rotation_part(frame), vector(stander.tips[who, h])))
        store(subtract(tip, vector(standing.goal[p, h])), value[3 * h :])
    x = unknown[0]
    y = unknown[1]
    left = work.world[stander.feet[1]]
    wanted = standing.other[p]
    gap = subtract(_origin(left), add(_origin(wanted), (x, y, 0.0)))
    store(gap, value[3 * hands :])
    # half the difference of the off-diagonal entries of R wanted': the sine of the turn, and its axis
    m = rotation_part(left)
    w = rotation_part(wanted)
    inverse = (w[0], w[3], w[6], w[1], w[4], w[7], w[2], w[5], w[8])
    d = product(m, inverse)
    half = 0.5 * _FOOT_LEVER
    turn = (half * (d[7] - d[5]), half * (d[2] - d[6]), half * (d[3] - d[1]))
    store(turn, value[3 * hands + 3 :])
    cx = 0.0
    cy = 0.0
    for n in range(stander.root[0], stander.parent.shape[0]):
        cx += stander.mass[who, n] * work.world[n, 0, 3]
        cy += stander.mass[who, n] * work.world[n, 1, 3]
    for e in range(standing.edges.shape[1]):
        edge = standing.edges[p, e]
        value[3 * hands + 6 + e] = edge[0] * (cx - x) + edge[1] * (cy - y) - edge[2]
    past_stops(work.rotations, stander.stops, work.measured, work.limits, work.past)


@inner
def _residuals(unknown, who, stander, standing, p, work, out):  # type: ignore[no-untyped-def]
    """Fill the residuals (R,) at the unknowns; returns the sum of their squares."""
    _measure(unknown, who, stander, standing, p, work)
    size = unknown.shape[0]
    for k in range(STEPS):
        out[k] = stander.step[k] * unknown[k]
    for k in range(size - STEPS):
        out[STEPS + k] = stander.weight[k] * (unknown[STEPS + k] - standing.mode[p, k])
    at = size
    hands = stander.hands.shape[0]
    for h in range(hands):
        c = add(vector(work.value[3 * h :]), vector(work.shift[3 * h :]))
        limit = _LOST_LIMIT if work.lost[h] else _HAND_LIMIT
        weight = math.sqrt(_LOST if work.lost[h] else _HAND)
        far = norm(c)
        if far > limit:  # the square grows no faster than the distance beyond the limit
            weight *= math.sqrt(2.0 * limit * far - limit * limit) / far
        store(scale(weight, c), out[at + 3 * h :])
    at += 3 * hands
    for k in range(6):
        out[at + k] = math.sqrt(_FOOT) * (work.value[3 * hands + k] + work.shift[3 * hands + k])
    at += 6
    for e in range(standing.edges.shape[1]):
        k = 3 * hands + 6 + e
        out[at + e] = math.sqrt(_EDGE) * max(work.shift[k] - work.value[k], 0.0)
    at += standing.edges.shape[1]
    for k in range(STEPS):
        low = standing.area[p, k, 0]
        high = standing.area[p, k, 1]
        out[at + k] = math.sqrt(_STOP) * max(max(low - unknown[k], unknown[k] - high), 0.0)
    at += STEPS
    for j in range(work.past.shape[0]):
        for i in range(3):
            out[at + 3 * j + i] = math.sqrt(_STOP) * work.past[j, i]
    total = 0.0
    for k in range(out.shape[0]):
        total += out[k] * out[k]
    return total


@inner
def _linearise(unknown, free, who, stander, standing, p, work):  # type: ignore[no-untyped-def]
    """Fill the normal equations by differences of the residuals; unknowns that are not free stay."""
    size = unknown.shape[0]
    rows = work.residual.shape[0]
    for k in range(size):
        work.trial[k] = unknown[k]
    for k in range(size):
        if free[k]:
            work.trial[k] = unknown[k] + _NUDGE
            _residuals(work.trial, who, stander, standing, p, work, work.other)
            work.trial[k] = unknown[k]
        for r in range(rows):
            slope = (work.other[r] - work.residual[r]) / _NUDGE
            work.jacobian[k, r] = slope if free[k] else 0.0
    for k in range(size):
        total = 0.0
        for r in range(rows):
            total += work.jacobian[k, r] * work.residual[r]
        work.slope[k] = total
        for m in range(k + 1):
            total = 0.0
            for r in range(rows):
                total += work.jacobian[k, r] * work.jacobian[m, r]
            work.normal[k, m] = total
            work.normal[m, k] = total


@inner
def _descend(unknown, free, who, stander, standing, p, work):  # type: ignore[no-untyped-def]
    """Lower the sum of squares from where the unknowns are."""
    size = unknown.shape[0]
    damping = 1e-3
    cost = _residuals(unknown, who, stander, standing, p, work, work.residual)
    for _ in range(_INNER):
        _linearise(unknown, free, who, stander, standing, p, work)
        moved = 0.0
        for _ in range(_TRIES):
            for k in range(size):
                for m in range(size):
                    work.factor[k, m] = work.normal[k, m]
                work.factor[k, k] += damping * (work.normal[k, k] + 1.0)
                work.step[k] = -work.slope[k]
            factorise(work.factor, LEAST_PIVOT)
            substitute(work.factor, work.step, work.step)
            most = 0.0
            for k in range(size):
                most = max(most, abs(work.step[k]))
            share = min(1.0, _MOST / max(most, 1e-12))
            for k in range(size):
                work.trial[k] = unknown[k] + share * work.step[k]
            now = _residuals(work.trial, who, stander, standing, p, work, work.other)
            if now < cost:
                moved = share * most
                for k in range(size):
                    unknown[k] = work.trial[k]
                for r in range(work.residual.shape[0]):
                    work.residual[r] = work.other[r]
                cost = now
                damping = max(0.2 * damping, 1e-9)
                break
            damping *= 6.0
        if moved < _SMALL:
            break


@inner
def _renew(stander, standing, before, turn, work):  # type: ignore[no-untyped-def]
    """Let the shifts grow by what is missed; returns the greatest miss [m] that may yet be less.

    before (H,) [m]: how far the hands were off a round before, which is renewed.
    """
    hands = stander.hands.shape[0]
    worst = 0.0
    for h in range(hands):
        far = norm(vector(work.value[3 * h :]))
        if turn >= _PATIENCE and far > _FROZEN and far > _GAIN * before[h]:
            work.lost[h] = 1
        before[h] = far
        for i in range(3 * h, 3 * h + 3):
            if work.lost[h]:
                work.shift[i] = 0.0
            else:
                grown = work.shift[i] + work.value[i]
                work.shift[i] = min(max(grown, -_HAND_LIMIT), _HAND_LIMIT)
        if not work.lost[h]:
            worst = max(worst, far)
    for k in range(3 * hands, 3 * hands + 6):
        work.shift[k] += work.value[k]
        worst = max(worst, abs(work.value[k]))
    for k in range(3 * hands + 6, work.value.shape[0]):
        before_it = work.shift[k]
        work.shift[k] = max(before_it - work.value[k], 0.0)
        worst = max(worst, -work.value[k])
        worst = max(worst, min(before_it, abs(work.value[k])))
    return worst


@inner
def _summary(unknown, stander, standing, p, turns, work, out):  # type: ignore[no-untyped-def]
    """Fill what is told of a posture that was measured, see NUMBERS."""
    total = 0.0
    for k in range(STEPS):
        total += (stander.step[k] * unknown[k]) ** 2
    for k in range(unknown.shape[0] - STEPS):
        total += (stander.weight[k] * (unknown[STEPS + k] - standing.mode[p, k])) ** 2
    hands = stander.hands.shape[0]
    out[0] = total
    out[1] = 0.0
    for h in range(hands):
        out[1] = max(out[1], norm(vector(work.value[3 * h :])))
    out[2] = max(norm(vector(work.value[3 * hands :])), norm(vector(work.value[3 * hands + 3 :])))
    out[3] = np.inf
    for k in range(3 * hands + 6, work.value.shape[0]):
        out[3] = min(out[3], work.value[k])
    out[4] = 0.0
    for j in range(work.past.shape[0]):
        out[4] = max(out[4], norm(vector(work.past[j])))
    out[5] = turns


@inner
def _solve(unknown, free, who, stander, standing, p, before, work, out):  # type: ignore[no-untyped-def]
    """Solve one row from where the unknowns are."""
    for k in range(work.shift.shape[0]):
        work.shift[k] = 0.0
    for h in range(work.lost.shape[0]):
        work.lost[h] = 0
        before[h] = np.inf
    turns = 0
    for turn in range(_ROUNDS):
        _descend(unknown, free, who, stander, standing, p, work)
        _measure(unknown, who, stander, standing, p, work)
        turns += 1
        off = _renew(stander, standing, before, turn, work)
        if off < (_DONE if work.lost.sum() == 0 else _DONE_LOST):
            break
    for k in range(STEPS):
        unknown[k] = min(max(unknown[k], standing.area[p, k, 0]), standing.area[p, k, 1])
    _measure(unknown, who, stander, standing, p, work)
    _summary(unknown, stander, standing, p, turns, work, out)


@njit(cache=True, nogil=True)
def solve_standing(stander, standing, rotations, starts, found, numbers, begin, end):  # type: ignore[no-untyped-def]
    """Solve rows begin to end, each from S starts.

    Parameters
    ----------
    stander : Stander
        The bodies.
    standing : Standing
        What is asked of each row.
    rotations : (P, J, 4)
        Joint rotations; those of joints without an unknown angle stay.
    starts : (P, S, 2 + n)
        Unknowns to start from: steps [m] and angles [rad].
    found : (P, S, 2 + n)
        Filled with the unknowns.
    numbers : (P, S, NUMBERS)
        Filled with what they come to.
    """
    size = starts.shape[2]
    joints = rotations.shape[1]
    hands = stander.hands.shape[0]
    held = 3 * hands + 6 + standing.edges.shape[1]
    rows = size + held + STEPS + 3 * joints
    work = _Workspace(
        np.zeros((joints, 4)),
        np.zeros((joints, 3)),
        np.zeros((joints + 1, 3, 4)),
        np.zeros(rows),
        np.zeros(rows),
        np.zeros((size, rows)),
        np.zeros((size, size)),
        np.zeros(size),
        np.zeros((size, size)),
        np.zeros(size),
        np.zeros(size),
        np.zeros(held),
        np.zeros(held),
        np.zeros(hands, np.int64),
        np.zeros((joints, 3, 2)),
        np.zeros((joints, 3)),
        np.zeros((joints, 3)),
    )
    before = np.zeros(hands)
    free = np.ones(size, np.int64)
    for p in range(begin, end):
        for k in range(STEPS):
            free[k] = 1 if standing.area[p, k, 1] > standing.area[p, k, 0] else 0
        for s in range(starts.shape[1]):
            work.rotations[:] = rotations[p]
            past_stops(work.rotations, stander.stops, work.angles, work.limits, work.past)
            found[p, s] = starts[p, s]
            who = standing.who[p]
            _solve(found[p, s], free, who, stander, standing, p, before, work, numbers[p, s])
