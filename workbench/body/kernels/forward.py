"""Batch loops of forward kinematics: the chain of transforms, and the spheres in the world."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.body.kernels.rotation import product, quaternion_matrix, twist_angle
from workbench.compiled import njit
from workbench.geometry.simd4 import FOUR, first_of, load_four, splat4, store_triples

__all__ = ["Chain", "Rows", "Skin", "chain_transforms", "place_bodies", "place_spheres"]


class Chain(NamedTuple):
    """The tree walked from the reference segment, in M steps. The reference itself is no step."""

    to: NDArray[np.int64]
    """(M,) the segment that each step reaches, from `came` over `joint`."""
    came: NDArray[np.int64]
    joint: NDArray[np.int64]
    upward: NDArray[np.int64]
    """(M,) 1 where the step goes from a distal segment to the proximal one."""
    at_came: NDArray[np.float64]
    """(M, 3) the joint [m] in the frame of `came`, and in that of `to`."""
    at_to: NDArray[np.float64]


class Skin(NamedTuple):
    """The S spheres of a body of N segments and J joints, and how they share the twists of joints.

    Coordinates are (3, S), one after the other, so that the loops run on several spheres at once.
    """

    centre: NDArray[np.float64]
    """(3, S) in the frame of the segment [m]."""
    out: NDArray[np.float64]
    """(3, S) from the line that the segment twists about to the centre, at right angles."""
    across: NDArray[np.float64]
    """(3, S) the same, a quarter turn on."""
    start: NDArray[np.int64]
    """(N + 1,) the first sphere of each segment."""
    twist_joint: NDArray[np.int64]
    """(N,) the joint whose twist a segment shares, -1 for none."""
    joint_axis: NDArray[np.float64]
    """(J, 3) the twist axis of each joint."""
    twist_axis: NDArray[np.float64]
    """(N, 3) the line that each segment twists about."""
    twist_share: NDArray[np.float64]
    """(S,)."""
    shown: NDArray[np.int64]
    """(N,) 1 in the logical window."""
    blend_joint: NDArray[np.int64]
    """(S,) the joint across which a sphere is blended, -1 where it is rigid."""
    blend_share: NDArray[np.float64]
    """(S,)."""
    blend_point: NDArray[np.float64]
    """(S, 3) that joint in the frame of the sphere's own segment [m]."""
    blended: NDArray[np.int64]
    """The blended spheres. Those of segment n are blended[blend_start[n]:blend_start[n + 1]]."""
    blend_start: NDArray[np.int64]
    distal: NDArray[np.int64]
    """(S,) 1 where the sphere's segment is the distal one of its joint."""
    twist_shared: NDArray[np.int64]
    """(J,) 1 where the proximal segment shares the twist."""


class Rows(NamedTuple):
    """What B bodies of one topology differ in."""

    joint_in_parent: NDArray[np.float64]
    """(B, J, 3) [m]."""
    joint_in_child: NDArray[np.float64]
    """(B, J, 3) [m]."""
    centre: NDArray[np.float64]
    """(B, S, 3) [m]."""
    twist_point: NDArray[np.float64]
    """(B, N, 3) a point of the line that each segment twists about [m]."""
    twist_axis: NDArray[np.float64]
    """(B, N, 3)."""
    twist_share: NDArray[np.float64]
    """(B, S)."""
    blend_share: NDArray[np.float64]
    """(B, S)."""


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _take_step(world, p, chain, m, r):  # type: ignore[no-untyped-def]
    """Place the segment that step m of the chain reaches in pose p; r: the joint's rotation."""
    # With R, x of the segment that the step comes from:  R' = R r (or R r^T upward),
    # x' = x + R joint_in_came - R' joint_in_to. Row by row.
    to = chain.to[m]
    came = chain.came[m]
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


@njit(cache=True, error_model="numpy", nogil=True, _nrt=False)
def chain_transforms(rotations, chain, first, world):  # type: ignore[no-untyped-def]
    """Chain the transforms of the segments from the reference outward.

    Parameters
    ----------
    rotations
        (P, J, 4) quaternions w, x, y, z.
    chain, first
        The walk, and the step to begin at. What earlier steps reach is placed already.
    world
        (P, N, 3, 4) world-from-segment transforms, filled in place.
    """
    for p in range(world.shape[0]):
        for m in range(first, chain.to.shape[0]):
            q = rotations[p, chain.joint[m]]
            _take_step(world, p, chain, m, quaternion_matrix(q[0], q[1], q[2], q[3]))


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _transposed(r):  # type: ignore[no-untyped-def]
    """The transpose of a 3 x 3 matrix given row by row."""
    return r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]


@njit(cache=True, error_model="numpy", _nrt=False)
def _across(q, axis, shared, distal):  # type: ignore[no-untyped-def]
    """Return the rotation that carries a point of one segment of a joint along with the other one.

    Parameters
    ----------
    q, axis
        Quaternion and twist axis of the joint.
    shared
        1 where the proximal segment shares the twist: then it is left out.
    distal
        1 for a point of the distal segment, whose frame the result is in.
    """
    # Q = S T is the joint's rotation, of swing S and twist T. For the proximal segment it is Q, or
    # S without the twist. For the distal one it is Q', or T' S' T, since it has the twist.
    r = quaternion_matrix(q[0], q[1], q[2], q[3])
    if shared == 0:
        return r if distal == 0 else _transposed(r)
    along = q[1] * axis[0] + q[2] * axis[1] + q[3] * axis[2]
    w = q[0]
    if w * w + along * along < 1e-24:  # half a turn of swing: the twist is undetermined
        w = 1.0
    t = quaternion_matrix(w, along * axis[0], along * axis[1], along * axis[2])
    s = product(r, _transposed(t))
    return s if distal == 0 else product(_transposed(t), product(_transposed(s), t))


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _turn(x):  # type: ignore[no-untyped-def]
    """Return sin 4x and cos 4x - 1 of four numbers |x| <= pi / 4.

    Taylor's series of sin x and cos x has a remainder below 1e-16. The angle is doubled twice by
    sin 2a = 2 sin a cos a and cos 2a - 1 = -2 sin^2 a.
    """
    one = splat4(1.0)
    y = x * x
    s = splat4(-1 / 1307674368000) * y + splat4(1 / 6227020800)
    s = (s * y + splat4(-1 / 39916800)) * y + splat4(1 / 362880)
    s = (s * y + splat4(-1 / 5040)) * y + splat4(1 / 120)
    s = ((s * y + splat4(-1 / 6)) * y + one) * x
    c = splat4(1 / 20922789888000) * y + splat4(-1 / 87178291200)
    c = (c * y + splat4(1 / 479001600)) * y + splat4(-1 / 3628800)
    c = (c * y + splat4(1 / 40320)) * y + splat4(-1 / 720)
    c = ((c * y + splat4(1 / 24)) * y + splat4(-1 / 2)) * y + one
    twice = splat4(2.0) * s * c
    less = splat4(-2.0) * s * s
    return splat4(2.0) * twice * (one + less), splat4(-2.0) * twice * twice


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _quarter(rotations, p, skin, n):  # type: ignore[no-untyped-def]
    """Return a quarter of the twist [rad] that segment n shares in pose p, about its own line; 0 for none."""
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
    """Return the twelve entries of a segment's transform, each as four equal numbers."""
    w = world[p, n]
    return (
        splat4(w[0, 0]),
        splat4(w[0, 1]),
        splat4(w[0, 2]),
        splat4(w[0, 3]),
        splat4(w[1, 0]),
        splat4(w[1, 1]),
        splat4(w[1, 2]),
        splat4(w[1, 3]),
        splat4(w[2, 0]),
        splat4(w[2, 1]),
        splat4(w[2, 2]),
        splat4(w[2, 3]),
    )


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _carried(f, x, y, z):  # type: ignore[no-untyped-def]
    """Transform four points of a segment into the world."""
    return (
        f[0] * x + f[1] * y + f[2] * z + f[3],
        f[4] * x + f[5] * y + f[6] * z + f[7],
        f[8] * x + f[9] * y + f[10] * z + f[11],
    )


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _turned(c, out, across, turn, less):  # type: ignore[no-untyped-def]
    """Return one coordinate of four centres turned about their line: c + (cos - 1) out + sin across."""
    return c + less * out + turn * across


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _four_spheres(skin, s, quarter, f, centres, at):  # type: ignore[no-untyped-def]
    """Place the spheres s to s + 3, turned by their shares, at position `at` of the flat centres."""
    u = s + np.uint64(skin.centre.shape[1])
    v = s + np.uint64(2 * skin.centre.shape[1])
    x = load_four(skin.centre, s)
    y = load_four(skin.centre, u)
    z = load_four(skin.centre, v)
    if quarter != 0.0:
        turn, less = _turn(load_four(skin.twist_share, s) * splat4(quarter))
        x = _turned(x, load_four(skin.out, s), load_four(skin.across, s), turn, less)
        y = _turned(y, load_four(skin.out, u), load_four(skin.across, u), turn, less)
        z = _turned(z, load_four(skin.out, v), load_four(skin.across, v), turn, less)
    x, y, z = _carried(f, x, y, z)
    store_triples(centres, at, x, y, z)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _one_sphere(skin, s, quarter, f, share, m):  # type: ignore[no-untyped-def]
    """Return one sphere's position, with the same bits as `_four_spheres`.

    Its centre first moves by `share` of the rotation m about its blend point.
    """
    x = splat4(skin.centre[0, s])
    y = splat4(skin.centre[1, s])
    z = splat4(skin.centre[2, s])
    if quarter != 0.0:
        turn, less = _turn(splat4(skin.twist_share[s] * quarter))
        x = _turned(x, splat4(skin.out[0, s]), splat4(skin.across[0, s]), turn, less)
        y = _turned(y, splat4(skin.out[1, s]), splat4(skin.across[1, s]), turn, less)
        z = _turned(z, splat4(skin.out[2, s]), splat4(skin.across[2, s]), turn, less)
    if share != 0.0:
        b = skin.blend_point[s]
        u = first_of(x) - b[0]
        v = first_of(y) - b[1]
        w = first_of(z) - b[2]
        x = x + splat4(share * (m[0] * u + m[1] * v + m[2] * w - u))
        y = y + splat4(share * (m[3] * u + m[4] * v + m[5] * w - v))
        z = z + splat4(share * (m[6] * u + m[7] * v + m[8] * w - w))
    x, y, z = _carried(f, x, y, z)
    return first_of(x), first_of(y), first_of(z)


@njit(cache=True, error_model="numpy", _nrt=False, forceinline=True)
def _blended_spheres(rotations, p, skin, n, quarter, f, centres):  # type: ignore[no-untyped-def]
    """Place the blended spheres of segment n, moved by their shares of their joints' rotations."""
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
    """Place the spheres of the shown segments: twisted by their share, blended, and transformed.

    Four spheres are placed at a time. The last four of a segment overlap those before, with the same
    bits.

    Parameters
    ----------
    rotations, world
        (P, J, 4) quaternions and (P, N, 3, 4) world-from-segment transforms.
    skin
        The spheres.
    centres
        (P, S, 3) [m], filled in place.
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


@njit(cache=True, error_model="numpy")
def _pack_chain(rows, b, chain, at_came, at_to):  # type: ignore[no-untyped-def]
    """Fill at_came and at_to (M, 3) of a chain with the joints of body b."""
    for m in range(len(chain.to)):
        j = chain.joint[m]
        for i in range(3):
            above = rows.joint_in_parent[b, j, i]
            below = rows.joint_in_child[b, j, i]
            at_came[m, i] = below if chain.upward[m] else above
            at_to[m, i] = above if chain.upward[m] else below


@njit(cache=True, error_model="numpy")
def _pack_centres(rows, b, segment, centre, out, across):  # type: ignore[no-untyped-def]
    """Fill the coordinates (3, S) of `Skin` with those of body b; segment (S,): of each sphere."""
    for s in range(len(segment)):
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
        for i in range(3):
            centre[i, s] = rows.centre[b, s, i]


@njit(cache=True, error_model="numpy")
def _pack_blend_points(rows, b, skin, blend_point):  # type: ignore[no-untyped-def]
    """Fill blend_point (S, 3) of `Skin` with the joints of body b."""
    for s in range(len(blend_point)):
        j = skin.blend_joint[s]
        if j < 0:
            continue
        joints = rows.joint_in_child if skin.distal[s] else rows.joint_in_parent
        for i in range(3):
            blend_point[s, i] = joints[b, j, i]


@njit(cache=True, error_model="numpy", nogil=True)
def place_bodies(rotations, person, chain, first, skin, segment, rows, world, centres):  # type: ignore[no-untyped-def]
    """Place P poses, each with its own body. Poses of one body in a run share its packing.

    Parameters
    ----------
    rotations
        (P, J, 4) quaternions w, x, y, z.
    person
        (P,) the row of `rows` that each pose is of.
    chain, skin
        Of the topology, without a body's own coordinates.
    first
        The step of the chain to begin at.
    segment
        (S,) of each sphere.
    rows
        The bodies.
    world, centres
        (P, N, 3, 4), where the reference segment is placed already, and (P, S, 3); filled in place.
    """
    steps = len(chain.to)
    spheres = centres.shape[1]
    at_came = np.empty((steps, 3))
    at_to = np.empty((steps, 3))
    centre = np.empty((3, spheres))
    out = np.empty((3, spheres))
    across = np.empty((3, spheres))
    blend_point = np.zeros((spheres, 3))
    own_chain = Chain(chain.to, chain.came, chain.joint, chain.upward, at_came, at_to)
    begin = 0
    while begin < len(person):
        b = person[begin]
        end = begin + 1
        while end < len(person) and person[end] == b:
            end += 1
        _pack_chain(rows, b, chain, at_came, at_to)
        chain_transforms(rotations[begin:end], own_chain, first, world[begin:end])
        _pack_centres(rows, b, segment, centre, out, across)
        _pack_blend_points(rows, b, skin, blend_point)
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
