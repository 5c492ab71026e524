"""Batch loops of forward kinematics: the chain of transforms, and the spheres in the world."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.rotation import product, quaternion_matrix, twist_angle
from workbench.compiled import njit
from workbench.geometry.quads import FOUR, first_of, four, load_four, store_triples

__all__ = ["Chain", "Rows", "Skin", "chain_transforms", "place_bodies", "place_spheres"]


class Chain(NamedTuple):
    """The tree walked from the reference segment: step m reaches segment `to` from `came` over
    `joint`.

    `upward` is 1 where the step goes from a distal segment to the proximal one. at_came, at_to: the
    joint's coordinates in both frames. The reference itself is not a step.
    """

    to: NDArray[np.int64]
    came: NDArray[np.int64]
    joint: NDArray[np.int64]
    upward: NDArray[np.int64]
    at_came: NDArray[np.float64]
    at_to: NDArray[np.float64]


class Skin(NamedTuple):
    """The spheres of a body and how they share the twist of a joint; `shown` (N,) is 1 in the
    window.

    centre (3, S): one coordinate after the other, so that the loops run on several spheres at once.
    out, across (3, S): each centre's arm from the line that its segment twists about, and that arm
    a quarter turn on. blend_joint (S,): -1 where rigid; blend_share (S,), blend_point (S, 3): the
    joint in the frame of the sphere's own segment; blended: the spheres that are, those of segment
    n being blended[blend_start[n]:blend_start[n + 1]]; distal (S,): 1 where that segment is the
    joint's distal one; twist_shared (J,): 1 where the proximal one shares the twist.
    """

    centre: NDArray[np.float64]
    out: NDArray[np.float64]
    across: NDArray[np.float64]
    start: NDArray[np.int64]
    twist_joint: NDArray[np.int64]
    joint_axis: NDArray[np.float64]
    twist_axis: NDArray[np.float64]
    twist_share: NDArray[np.float64]
    shown: NDArray[np.int64]
    blend_joint: NDArray[np.int64]
    blend_share: NDArray[np.float64]
    blend_point: NDArray[np.float64]
    blended: NDArray[np.int64]
    blend_start: NDArray[np.int64]
    distal: NDArray[np.int64]
    twist_shared: NDArray[np.int64]


class Rows(NamedTuple):
    """What B bodies of one topology differ in: joint_in_parent, joint_in_child (B, J, 3), centre
    (B, S, 3), twist_point, twist_axis (B, N, 3), twist_share, blend_share (B, S)."""

    joint_in_parent: NDArray[np.float64]
    joint_in_child: NDArray[np.float64]
    centre: NDArray[np.float64]
    twist_point: NDArray[np.float64]
    twist_axis: NDArray[np.float64]
    twist_share: NDArray[np.float64]
    blend_share: NDArray[np.float64]


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)
def chain_transforms(rotations, chain, first, world):  # type: ignore[no-untyped-def]
    """Fill world (P, N, 3, 4) for the steps `first` onward; what earlier steps reached must be
    filled already."""
    for p in range(world.shape[0]):
        for m in range(first, chain.to.shape[0]):
            to = chain.to[m]
            came = chain.came[m]
            j = chain.joint[m]
            q = rotations[p, j]
            r = quaternion_matrix(q[0], q[1], q[2], q[3])
            for i in range(3):
                u = world[p, came, i, 0]
                v = world[p, came, i, 1]
                w = world[p, came, i, 2]
                if chain.upward[m]:
                    a = u * r[0] + v * r[1] + w * r[2]
                    b = u * r[3] + v * r[4] + w * r[5]
                    c = u * r[6] + v * r[7] + w * r[8]
                else:
                    a = u * r[0] + v * r[3] + w * r[6]
                    b = u * r[1] + v * r[4] + w * r[7]
                    c = u * r[2] + v * r[5] + w * r[8]
                joint = u * chain.at_came[m, 0] + v * chain.at_came[m, 1] + w * chain.at_came[m, 2]
                back = a * chain.at_to[m, 0] + b * chain.at_to[m, 1] + c * chain.at_to[m, 2]
                world[p, to, i, 0] = a
                world[p, to, i, 1] = b
                world[p, to, i, 2] = c
                world[p, to, i, 3] = world[p, came, i, 3] + joint - back


@njit(cache=True, error_model="numpy", _nrt=False)
def _across(q, axis, shared, distal):  # type: ignore[no-untyped-def]
    """The rotation that carries a point of one segment of a joint along with the other segment, in
    the frame of the first: Q, or for the distal one its inverse; without the twist T where the
    proximal segment shares it.

    Q = S T: of the swing alone S for the proximal segment, and T' S' T for the distal one, which
    has the twist.
    """
    r = quaternion_matrix(q[0], q[1], q[2], q[3])
    if shared == 0:
        return r if distal == 0 else (r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8])
    along = q[1] * axis[0] + q[2] * axis[1] + q[3] * axis[2]
    w = q[0]
    x = along * axis[0]
    y = along * axis[1]
    z = along * axis[2]
    if w * w + along * along < 1e-24:  # half a turn of swing: no twist can be told from it
        w = 1.0
    t = quaternion_matrix(w, x, y, z)
    s = product(r, (t[0], t[3], t[6], t[1], t[4], t[7], t[2], t[5], t[8]))
    if distal == 0:
        return s
    back = product((s[0], s[3], s[6], s[1], s[4], s[7], s[2], s[5], s[8]), t)
    return product((t[0], t[3], t[6], t[1], t[4], t[7], t[2], t[5], t[8]), back)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _turn(x):  # type: ignore[no-untyped-def]
    """sin 4x and cos 4x - 1 for |x| <= pi / 4, of four numbers: Taylor's series of sin x and cos x,
    whose rest is less than 1e-16, and the formulae for twice an angle."""
    one = four(1.0)
    y = x * x
    s = four(-1 / 1307674368000) * y + four(1 / 6227020800)
    s = (s * y + four(-1 / 39916800)) * y + four(1 / 362880)
    s = (s * y + four(-1 / 5040)) * y + four(1 / 120)
    s = ((s * y + four(-1 / 6)) * y + one) * x
    c = four(1 / 20922789888000) * y + four(-1 / 87178291200)
    c = (c * y + four(1 / 479001600)) * y + four(-1 / 3628800)
    c = (c * y + four(1 / 40320)) * y + four(-1 / 720)
    c = ((c * y + four(1 / 24)) * y + four(-1 / 2)) * y + one
    twice = four(2.0) * s * c
    less = four(-2.0) * s * s
    return four(2.0) * twice * (one + less), four(-2.0) * twice * twice


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _quarter(rotations, p, skin, n):  # type: ignore[no-untyped-def]
    """A quarter of the twist [rad] that segment n shares in pose p, about its own line; zero where
    it shares none."""
    j = skin.twist_joint[n]
    if j < 0:
        return 0.0
    axis = skin.joint_axis[j]
    line = skin.twist_axis[n]
    q = rotations[p, j]
    angle = 0.25 * twist_angle(q[0], q[1], q[2], q[3], axis[0], axis[1], axis[2])
    return -angle if axis[0] * line[0] + axis[1] * line[1] + axis[2] * line[2] < 0.0 else angle


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _frame(world, p, n):  # type: ignore[no-untyped-def]
    """The twelve entries of a segment's transform, each four times."""
    w = world[p, n]
    return (
        four(w[0, 0]),
        four(w[0, 1]),
        four(w[0, 2]),
        four(w[0, 3]),
        four(w[1, 0]),
        four(w[1, 1]),
        four(w[1, 2]),
        four(w[1, 3]),
        four(w[2, 0]),
        four(w[2, 1]),
        four(w[2, 2]),
        four(w[2, 3]),
    )


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _carried(f, x, y, z):  # type: ignore[no-untyped-def]
    """Four points of a segment in the world."""
    return (
        f[0] * x + f[1] * y + f[2] * z + f[3],
        f[4] * x + f[5] * y + f[6] * z + f[7],
        f[8] * x + f[9] * y + f[10] * z + f[11],
    )


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _turned(c, out, across, turn, less):  # type: ignore[no-untyped-def]
    """One coordinate of four centres turned about their line."""
    return c + less * out + turn * across


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _four_spheres(skin, s, quarter, f, centres, at):  # type: ignore[no-untyped-def]
    """Place the spheres s..s + 3, which stand at place `at` of all numbers of centres, turned by
    their shares."""
    u = s + np.uint64(skin.centre.shape[1])
    v = s + np.uint64(2 * skin.centre.shape[1])
    x = load_four(skin.centre, s)
    y = load_four(skin.centre, u)
    z = load_four(skin.centre, v)
    if quarter != 0.0:
        turn, less = _turn(load_four(skin.twist_share, s) * four(quarter))
        x = _turned(x, load_four(skin.out, s), load_four(skin.across, s), turn, less)
        y = _turned(y, load_four(skin.out, u), load_four(skin.across, u), turn, less)
        z = _turned(z, load_four(skin.out, v), load_four(skin.across, v), turn, less)
    x, y, z = _carried(f, x, y, z)
    store_triples(centres, at, x, y, z)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _one_sphere(skin, s, quarter, f, share, m):  # type: ignore[no-untyped-def]
    """One sphere's place, as `_four_spheres` would have it four times; moved by its share of the
    rotation m first."""
    x = four(skin.centre[0, s])
    y = four(skin.centre[1, s])
    z = four(skin.centre[2, s])
    if quarter != 0.0:
        turn, less = _turn(four(skin.twist_share[s] * quarter))
        x = _turned(x, four(skin.out[0, s]), four(skin.across[0, s]), turn, less)
        y = _turned(y, four(skin.out[1, s]), four(skin.across[1, s]), turn, less)
        z = _turned(z, four(skin.out[2, s]), four(skin.across[2, s]), turn, less)
    if share != 0.0:
        b = skin.blend_point[s]
        u = first_of(x) - b[0]
        v = first_of(y) - b[1]
        w = first_of(z) - b[2]
        x = x + four(share * (m[0] * u + m[1] * v + m[2] * w - u))
        y = y + four(share * (m[3] * u + m[4] * v + m[5] * w - v))
        z = z + four(share * (m[6] * u + m[7] * v + m[8] * w - w))
    x, y, z = _carried(f, x, y, z)
    return first_of(x), first_of(y), first_of(z)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _blended_spheres(rotations, p, skin, n, quarter, f, centres):  # type: ignore[no-untyped-def]
    """Place the blended spheres of segment n, moved by their shares of the rotations of their
    joints."""
    last = -1
    m = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    for i in range(skin.blend_start[n], skin.blend_start[n + 1]):
        s = skin.blended[i]
        b = skin.blend_joint[s]
        if b != last:
            m = _across(rotations[p, b], skin.joint_axis[b], skin.twist_shared[b], skin.distal[s])
            last = b
        x, y, z = _one_sphere(skin, s, quarter, f, skin.blend_share[s], m)
        centres[p, s, 0] = x
        centres[p, s, 1] = y
        centres[p, s, 2] = z


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)
def place_spheres(rotations, world, skin, centres):  # type: ignore[no-untyped-def]
    """Fill centres (P, S, 3) for the shown segments: local centres, twisted by their share and
    blended, into the world.

    Four spheres go at a time; those left over go with some that are done again, to the same digits.
    """
    spheres = centres.shape[1]
    still = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    for p in range(world.shape[0]):
        for n in range(world.shape[1]):
            first = skin.start[n]
            last = skin.start[n + 1]
            if skin.shown[n] == 0 or first == last:
                continue
            quarter = _quarter(rotations, p, skin, n)
            f = _frame(world, p, n)
            for s in range(first, last if last - first < FOUR else first):
                x, y, z = _one_sphere(skin, s, quarter, f, 0.0, still)
                centres[p, s, 0] = x
                centres[p, s, 1] = y
                centres[p, s, 2] = z
            for s in range(first, last if last - first >= FOUR else first, FOUR):
                s = min(s, last - FOUR)
                _four_spheres(
                    skin, np.uint64(s), quarter, f, centres, np.uint64(3 * (p * spheres + s))
                )
            _blended_spheres(rotations, p, skin, n, quarter, f, centres)


@njit(cache=True, error_model="numpy", nogil=True)
def place_bodies(rotations, person, chain, first, skin, segment, rows, world, centres):  # type: ignore[no-untyped-def]
    """Place P poses, pose p of the body in row person[p].

    rotations (P, J, 4); chain, skin: of the topology, without a body's own coordinates; first: the
    step of the chain to begin at; segment (S,): of each sphere; rows: Rows. Fills world (P, N, 3,
    4), where the reference segment stands already, and centres (P, S, 3). Poses of one body in a
    run share its packing.
    """
    steps = len(chain.to)
    spheres = centres.shape[1]
    at_came = np.empty((steps, 3))
    at_to = np.empty((steps, 3))
    centre = np.empty((3, spheres))
    out = np.empty((3, spheres))
    across = np.empty((3, spheres))
    blend_point = np.zeros((spheres, 3))
    begin = 0
    while begin < len(person):
        b = person[begin]
        end = begin + 1
        while end < len(person) and person[end] == b:
            end += 1
        for m in range(steps):
            j = chain.joint[m]
            for i in range(3):
                above = rows.joint_in_parent[b, j, i]
                below = rows.joint_in_child[b, j, i]
                at_came[m, i], at_to[m, i] = (below, above) if chain.upward[m] else (above, below)
        for s in range(spheres):
            n = segment[s]
            x = rows.twist_axis[b, n, 0]
            y = rows.twist_axis[b, n, 1]
            z = rows.twist_axis[b, n, 2]
            u = rows.centre[b, s, 0] - rows.twist_point[b, n, 0]
            v = rows.centre[b, s, 1] - rows.twist_point[b, n, 1]
            w = rows.centre[b, s, 2] - rows.twist_point[b, n, 2]
            along = u * x + v * y + w * z
            u = u - along * x
            v = v - along * y
            w = w - along * z
            out[0, s] = u
            out[1, s] = v
            out[2, s] = w
            across[0, s] = y * w - z * v
            across[1, s] = z * u - x * w
            across[2, s] = x * v - y * u
            j = skin.blend_joint[s]
            for i in range(3):
                centre[i, s] = rows.centre[b, s, i]
                if j >= 0:
                    near = rows.joint_in_child if skin.distal[s] else rows.joint_in_parent
                    blend_point[s, i] = near[b, j, i]
        own_chain = Chain(chain.to, chain.came, chain.joint, chain.upward, at_came, at_to)
        chain_transforms(rotations[begin:end], own_chain, first, world[begin:end])
        own_skin = Skin(
            centre,
            out,
            across,
            skin.start,
            skin.twist_joint,
            skin.joint_axis,
            rows.twist_axis[b],
            rows.twist_share[b],
            skin.shown,
            skin.blend_joint,
            rows.blend_share[b],
            blend_point,
            skin.blended,
            skin.blend_start,
            skin.distal,
            skin.twist_shared,
        )
        place_spheres(rotations[begin:end], world[begin:end], own_skin, centres[begin:end])
        begin = end
