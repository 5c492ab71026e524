"""A body on its way between two poses: rotations on the way, and how far each sphere can stray from
a chord.

Joints turn at a constant rate on the shortest arc (slerp), the reference segment likewise, and its
origin moves on a straight line. Time runs from 0 to 1 in every pose pair.

The bounds. Let segment i be reached over joints with turning angles theta_1 .. theta_i from the
reference (theta_0), Theta_i their sum. Its world rotation W_i is a product of rotations at constant
rates, each about an axis that is fixed in the segment before it; so its angular velocity is at most
Theta_i, and the rate of change of that velocity at most S_i = sum over k of Theta_(k-1) theta_k. A
point x = J + W_i c, fixed in segment i, whose entry joint J has speed at most V and acceleration at
most B, has speed at most V + Theta |c| and acceleration at most B + (Theta^2 + S) |c|; the next
joint is such a point. Where c itself moves in the frame (a shared twist, a blend) with c' and c'',
c' is added to the one and 2 Theta c' + c'' to the other. A path with acceleration at most A is
never farther than A h^2 / 8 from its chord over a time h: the error of linear interpolation,
component by component.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.rotation import quaternion_matrix
from workbench.compiled import njit

__all__ = ["Levers", "PoseTurns", "aim", "bound_segments", "chord_deviation", "turn_on"]

_MOST = 1e15


class PoseTurns(NamedTuple):
    """How P pose pairs of a body with J joints turn; row J is the reference segment.

    goal (P, J + 1, 4): the end's quaternions on the near side of the start's; half (P, J + 1): half
    the turning angles [rad]; bound (P, N, 4): V, B, Theta, S of this module's text; twist (P, J,
    6): mean and amplitude of the squared length of the projected quaternion, its phase, twice its
    rate of area, the half angle, and the time at which the twist jumps from pi to -pi (2: none).
    """

    goal: NDArray[np.float64]
    half: NDArray[np.float64]
    bound: NDArray[np.float64]
    twist: NDArray[np.float64]


class Levers(NamedTuple):
    """What makes spheres stray (S,): reach [m], how far the centre comes from its segment's entry
    joint at most; twist [m], the share of the twist of joint twist_joint (-1: none) times the
    distance from its axis; blend [m], the share of the blend across blend_joint (-1: none) times
    the distance from it; blend_twist, the joint whose twist the blend leaves out, or -1."""

    segment: NDArray[np.int64]
    reach: NDArray[np.float64]
    twist: NDArray[np.float64]
    twist_joint: NDArray[np.int64]
    blend: NDArray[np.float64]
    blend_joint: NDArray[np.int64]
    blend_twist: NDArray[np.int64]


@njit(cache=True, nogil=True, error_model="numpy")
def _aim_twist(q, goal, half, axis, out):  # type: ignore[no-untyped-def]
    """What bounds the rate of the twist about an axis, and where it passes half a turn.

    The quaternion runs on a great circle; its projection on (w, axis) is an ellipse, run through
    with a constant rate of area, and the twist is twice the angle of the projection.
    """
    out[0] = 1.0
    out[1] = 0.0
    out[2] = 0.0
    out[3] = 0.0
    out[4] = half
    out[5] = 2.0
    sine = math.sin(half)
    cosine = math.cos(half)
    if sine < 1e-12:
        return
    u0 = q[0]
    u1 = q[1] * axis[0] + q[2] * axis[1] + q[3] * axis[2]
    g1 = goal[1] * axis[0] + goal[2] * axis[1] + goal[3] * axis[2]
    v0 = (goal[0] - cosine * u0) / sine
    v1 = (g1 - cosine * u1) / sine
    uu = u0 * u0 + u1 * u1
    vv = v0 * v0 + v1 * v1
    uv = u0 * v0 + u1 * v1
    out[0], out[1] = 0.5 * (uu + vv), math.sqrt(0.25 * (uu - vv) ** 2 + uv * uv)
    out[2], out[3] = math.atan2(uv, 0.5 * (uu - vv)), 2.0 * half * abs(u0 * v1 - u1 * v0)
    if u0 * goal[0] <= 0.0 and not (u0 == 0.0 and goal[0] == 0.0):
        side = 1.0 if u0 > 0.0 or (u0 == 0.0 and goal[0] < 0.0) else -1.0
        out[5] = min(max(math.atan2(side * u0, -side * v0) / half, 0.0), 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def aim(rotations, first, second, axes, twisted, turns):  # type: ignore[no-untyped-def]
    """Fill goal, half and twist of `turns` for the pairs of frames first, second (P,) of rotations
    (F, J + 1, 4).

    axes (J, 3): twist axes; twisted (J,): 1 where a sphere shares the joint's twist.
    """
    for p in range(len(first)):
        for j in range(rotations.shape[1]):
            a = rotations[first[p], j]
            b = rotations[second[p], j]
            goal = turns.goal[p, j]
            # a half turn goes the way the end quaternion's sign says; rounding must not turn it
            # round
            sign = -1.0 if a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < -1e-12 else 1.0
            less = 0.0
            more = 0.0
            for i in range(4):
                goal[i] = sign * b[i]
                less += (a[i] - goal[i]) ** 2
                more += (a[i] + goal[i]) ** 2
            turns.half[p, j] = 2.0 * math.atan2(math.sqrt(less), math.sqrt(more))
            if j < len(twisted) and twisted[j]:
                _aim_twist(a, goal, turns.half[p, j], axes[j], turns.twist[p, j])


@njit(cache=True, nogil=True, error_model="numpy")
def bound_segments(shift, half, chain, entry, reference, bound):  # type: ignore[no-untyped-def]
    """Fill bound (P, N, 4) from the way of the reference segment's origin (P,) [m] and the half
    angles (P, J + 1).

    entry (N, 3): the joint by which the walk from the reference reaches each segment, in its frame.
    """
    joints = half.shape[1] - 1
    for p in range(len(shift)):
        out = bound[p]
        n = reference
        out[n, 0] = shift[p]
        out[n, 1] = 0.0
        out[n, 2] = 2.0 * half[p, joints]
        out[n, 3] = 0.0
        for m in range(chain.to.shape[0]):
            n = chain.to[m]
            came = chain.came[m]
            theta = 2.0 * half[p, chain.joint[m]]
            arm = 0.0
            for i in range(3):
                arm += (chain.at_came[m, i] - entry[came, i]) ** 2
            arm = math.sqrt(arm)
            total = out[came, 2]
            out[n, 0] = out[came, 0] + total * arm
            out[n, 1] = out[came, 1] + (total * total + out[came, 3]) * arm
            out[n, 2], out[n, 3] = total + theta, out[came, 3] + total * theta


@njit(cache=True, nogil=True, error_model="numpy")
def turn_on(rotations, origin, pairs, turns, reference, pair, time, out, world):  # type: ignore[no-untyped-def]
    """Fill out (U, J + 1, 4) with the quaternions at time (U,) of pairs (U,): spherical linear
    interpolation.

    pairs: first and second frame (P,); world (U, N, 3, 4) gets the reference segment's transform,
    its origin (F, 3) running straight.
    """
    first, second = pairs
    for u in range(len(pair)):
        p = pair[u]
        t = time[u]
        for j in range(out.shape[1]):
            a = rotations[first[p], j]
            b = turns.goal[p, j]
            half = turns.half[p, j]
            sine = math.sin(half)
            f = 1.0 - t
            g = t
            if sine > 1e-7:
                f = math.sin(f * half) / sine
                g = math.sin(g * half) / sine
            for i in range(4):
                out[u, j, i] = f * a[i] + g * b[i]
        q = out[u, out.shape[1] - 1]
        place = world[u, reference]
        r = quaternion_matrix(q[0], q[1], q[2], q[3])
        for i in range(3):
            place[i, 0] = r[3 * i]
            place[i, 1] = r[3 * i + 1]
            place[i, 2] = r[3 * i + 2]
            place[i, 3] = (1.0 - t) * origin[first[p], i] + t * origin[second[p], i]


@njit(cache=True, nogil=True, error_model="numpy")
def _twist_rates(twist, a, b):  # type: ignore[no-untyped-def]
    """Bounds of the first and second derivative of a joint's twist over the times a..b."""
    mean = twist[0]
    swing = twist[1]
    phase = twist[2]
    area = twist[3]
    half = twist[4]
    least = min(
        mean + swing * math.cos(2.0 * a * half - phase),
        mean + swing * math.cos(2.0 * b * half - phase),
    )
    lowest = 0.5 * (phase + math.pi)
    if a * half <= lowest <= b * half:
        least = mean - swing
    least = max(least, 1e-15)
    return min(area / least, _MOST), min(area * 2.0 * half * swing / (least * least), _MOST)


@njit(cache=True, nogil=True, error_model="numpy")
def chord_deviation(turns, levers, pair, sphere, begin, end, out):  # type: ignore[no-untyped-def]
    """Fill out (M,) with how far [m] the centre of sphere (M,) may be from its chord between begin
    and end (M,)."""
    for i in range(len(pair)):
        p = pair[i]
        s = sphere[i]
        a = begin[i]
        b = end[i]
        bound = turns.bound[p, levers.segment[s]]
        total = bound[2]
        most = bound[1] + (total * total + bound[3]) * levers.reach[s]
        twist = levers.twist[s]
        blend = levers.blend[s]
        if twist > 0.0 or blend > 0.0:
            speed = 0.0
            rate = 0.0
            if twist > 0.0:
                one, two = _twist_rates(turns.twist[p, levers.twist_joint[s]], a, b)
                speed = twist * one
                rate = twist * (one * one + two)
            if blend > 0.0:
                one = 2.0 * turns.half[p, levers.blend_joint[s]]
                two = 0.0
                if levers.blend_twist[s] >= 0:
                    more, two = _twist_rates(turns.twist[p, levers.blend_twist[s]], a, b)
                    one += more
                rate += blend * (one * one + two) + 2.0 * one * speed
                speed += blend * one
            most += 2.0 * total * speed + rate
        out[i] = 0.125 * (b - a) * (b - a) * most
