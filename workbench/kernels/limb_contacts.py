"""What the spheres of limbs enter, as planes that they must stay behind: one batch loop over bodies of a family."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from workbench.kernels.field import deepest, record_gap, square_bound
from workbench.kernels.forward import Chain, Skin, chain_transforms, place_spheres
from workbench.kernels.heads import near_heads
from workbench.kernels.lanes import first_bit
from workbench.kernels.polygon import point_polygon
from workbench.kernels.tree import wider
from workbench.kernels.wide import DEEP, EIGHT, near_boxes, point_lanes

__all__ = ["Limbs", "least_heights", "limb_contacts"]


class Limbs(NamedTuple):
    """The moving segments of B bodies of a family, S spheres of theirs: skin, chain as for one body; of each body its
    own centre, out, across (B, 3, S), radius, twist_share, blend_share (B, S), twist_axis (B, N, 3), blend_point
    (B, S, 3), at_came, at_to (B, M, 3).

    solid (B, S): those that may meet obstacles; segment (S,); link (S,): the link of the chain that carries each,
    carrier (S,): that link's segment. joint (K,): the body's joints of the chain, free (K,): 1 where they turn. base:
    the held segment.
    """

    skin: Skin
    chain: Chain
    centre: NDArray[np.float64]
    out: NDArray[np.float64]
    across: NDArray[np.float64]
    radius: NDArray[np.float64]
    twist_axis: NDArray[np.float64]
    twist_share: NDArray[np.float64]
    blend_share: NDArray[np.float64]
    blend_point: NDArray[np.float64]
    at_came: NDArray[np.float64]
    at_to: NDArray[np.float64]
    solid: NDArray[np.int64]
    segment: NDArray[np.int64]
    link: NDArray[np.int64]
    carrier: NDArray[np.int64]
    joint: NDArray[np.int64]
    free: NDArray[np.int64]
    axes: NDArray[np.float64]
    base: int


@njit(cache=True, error_model="numpy", _nrt=False)
def _quaternion(axes, angles, p, k, out, j):  # type: ignore[no-untyped-def]
    """Write exp(swing) exp(twist) of angles[p, k] about axes[j] into out[0, j]."""
    s0, s1, t = angles[p, k, 0], angles[p, k, 1], angles[p, k, 2]
    x = s0 * axes[j, 0, 0] + s1 * axes[j, 1, 0]
    y = s0 * axes[j, 0, 1] + s1 * axes[j, 1, 1]
    z = s0 * axes[j, 0, 2] + s1 * axes[j, 1, 2]
    size = math.sqrt(x * x + y * y + z * z)
    w, scale = math.cos(0.5 * size), 0.5
    if size > 1e-9:
        scale = math.sin(0.5 * size) / size
    x, y, z = x * scale, y * scale, z * scale
    a, b = math.cos(0.5 * t), math.sin(0.5 * t)
    u, v, r = b * axes[j, 2, 0], b * axes[j, 2, 1], b * axes[j, 2, 2]
    out[0, j, 0] = w * a - x * u - y * v - z * r
    out[0, j, 1] = w * u + x * a + y * r - z * v
    out[0, j, 2] = w * v + y * a + z * u - x * r
    out[0, j, 3] = w * r + z * a + x * v - y * u


@njit(cache=True, error_model="numpy", _nrt=False)
def _placed(limbs, b, held, base, angles, p, space):  # type: ignore[no-untyped-def]
    """Place the limb of body b at angles[p]: frames and spheres into space."""
    rotations, world, centres = space
    for j in range(rotations.shape[1]):
        for i in range(4):
            rotations[0, j, i] = held[p, j, i]
    for k in range(limbs.joint.shape[0]):
        if limbs.free[k]:
            _quaternion(limbs.axes, angles, p, k, rotations, limbs.joint[k])
    for i in range(3):
        for m in range(4):
            world[0, limbs.base, i, m] = base[p, i, m]
    c, s = limbs.chain, limbs.skin
    chain = Chain(c.to, c.came, c.joint, c.upward, limbs.at_came[b], limbs.at_to[b])
    chain_transforms(rotations, chain, 0, world)
    skin = Skin(
        limbs.centre[b], limbs.out[b], limbs.across[b], s.start, s.twist_joint, s.joint_axis, limbs.twist_axis[b],
        limbs.twist_share[b], s.shown, s.blend_joint, limbs.blend_share[b], limbs.blend_point[b], s.blended,
        s.blend_start, s.distal, s.twist_shared,
    )  # fmt: skip
    place_spheres(rotations, world, skin, centres)


@njit(cache=True, error_model="numpy", _nrt=False)
def _keep(found, p, count, values):  # type: ignore[no-untyped-def]
    """Insert (excess, sphere, polygon, x, y, z, inside) by its excess among found[p], deepest first; the new count."""
    most = found.shape[1]
    if count == most and found[p, most - 1, 0] >= values[0]:
        return count
    at = min(count, most - 1)
    while at > 0 and found[p, at - 1, 0] < values[0]:
        for i in range(7):
            found[p, at, i] = found[p, at - 1, i]
        at -= 1
    for i in range(7):
        found[p, at, i] = values[i]
    return min(count + 1, most)


@njit(cache=True, error_model="numpy", _nrt=False)
def _sphere(x, y, z, r, s, n, g, index, clear, found, p, count, space):  # type: ignore[no-untyped-def]
    """Keep what sphere s of segment n, at (x, y, z) with radius r, enters of group g by more than -clear beyond what
    is allowed."""
    faces, shells, field, owner, allowed = index[0], index[1], index[2], index[3], index[4]
    stack, gaps = space
    square, sure = square_bound(x, y, z, field, g)
    near = max(r + clear - index[7][n, g], 0.0)
    limit = wider(near * near)
    if sure and square > limit:
        return count
    deep = -1
    if not sure:
        depth, rank = deepest(x, y, z, faces, shells, field, g, stack, gaps)
        if rank >= 0:
            deep = int(field.record[field.begin[rank] + 8])
            excess = depth + r - allowed[n, owner[deep]]
            if excess > -clear:
                _, u, v, w = point_polygon(x, y, z, faces, deep, np.inf)
                count = _keep(found, p, count, (excess, float(s), float(deep), u, v, w, 1.0))
    stack[0], size = field.root[g], 1
    point = point_lanes(x, y, z)
    while size > 0:
        size -= 1
        m = stack[size]
        bits = near_boxes(point, field.box, m, field.many[m], limit, gaps)
        if bits != 0:
            bits &= near_heads(x, y, z, field.head, m, limit, gaps)
        while bits != 0:
            c = np.int64(field.child[m, first_bit(bits)])
            bits &= bits - np.uint64(1)
            if c >= 0:
                stack[size] = c
                size += 1
                continue
            gap = record_gap(x, y, z, field, -1 - c, limit)
            if gap > limit:
                continue
            f = int(field.record[field.begin[-1 - c] + 8])
            excess = r - math.sqrt(gap) - allowed[n, owner[f]]
            if f != deep and excess > -clear:
                _, u, v, w = point_polygon(x, y, z, faces, f, np.inf)
                count = _keep(found, p, count, (excess, float(s), float(f), u, v, w, 0.0))
    return count


@njit(cache=True, error_model="numpy", _nrt=False)
def _plane(limbs, b, shift, world, centres, normals, found, p, i, allowed, clear, planes):  # type: ignore[no-untyped-def]
    """Make found[p, i], of a part shifted, the plane planes[p, i]: link, point (3), normal (3), offset."""
    x, y, z = shift
    s = int(found[p, i, 1])
    c0, c1, c2 = centres[0, s, 0], centres[0, s, 1], centres[0, s, 2]
    u, v, w = found[p, i, 3], found[p, i, 4], found[p, i, 5]
    n0, n1, n2 = c0 - x - u, c1 - y - v, c2 - z - w
    if found[p, i, 6] > 0.0:
        n0, n1, n2 = -n0, -n1, -n2
    size = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    if size > 1e-9:
        n0, n1, n2 = n0 / size, n1 / size, n2 / size
    else:
        f = int(found[p, i, 2])
        n0, n1, n2 = normals[f, 0], normals[f, 1], normals[f, 2]
    k = limbs.carrier[s]
    d0, d1, d2 = c0 - world[0, k, 0, 3], c1 - world[0, k, 1, 3], c2 - world[0, k, 2, 3]
    planes[p, i, 0] = limbs.link[s]
    for m in range(3):
        planes[p, i, 1 + m] = world[0, k, 0, m] * d0 + world[0, k, 1, m] * d1 + world[0, k, 2, m] * d2
    planes[p, i, 4], planes[p, i, 5], planes[p, i, 6] = n0, n1, n2
    reach = limbs.radius[b, s] - allowed + 2.0 * clear
    planes[p, i, 7] = n0 * (u + x) + n1 * (v + y) + n2 * (w + z) + reach


@njit(cache=True, nogil=True)
def limb_contacts(limbs, who, held, base, angles, index, shift, reach, out, begin, end):  # type: ignore[no-untyped-def]
    """Place the limbs of rows begin..end, row p of body who[p], and find what they enter.

    held (P, J, 4): rotations of all joints, those of the chain aside; base (P, 3, 4); angles (P, K, 3). index: faces,
    shells, Field, owner (F,) the part of each polygon, allowed (N, parts) [m], moving (parts,): 1 in the second group,
    normals (F, 3), least (N, groups) [m] that is allowed anywhere in a group. shift (B, 3) [m]: of the second group of
    parts, if the field has two. reach [m]: how near what counts is, how far it is to be kept off. out: found
    (P, Q, 7), planes (P, Q, 8), many (P,), part (P, Q), overlap (P,) [m] beyond what is allowed.
    """
    found, planes, many, part, overlap = out
    near, clear = reach
    joints, spheres, segments = held.shape[1], limbs.centre.shape[2], limbs.skin.shown.shape[0]
    rotations, world = np.zeros((1, joints, 4)), np.zeros((1, segments, 3, 4))
    centres = np.zeros((1, spheres, 3))
    space = (np.empty(DEEP, np.int64), np.empty(DEEP + EIGHT, np.float32))
    field, owner, allowed = index[2], index[3], index[4]
    for p in range(begin, end):
        b, count = who[p], 0
        _placed(limbs, b, held, base, angles, p, (rotations, world, centres))
        for g in range(field.root.shape[0]):
            if field.root[g] < 0:
                continue
            x, y, z = (shift[b, 0], shift[b, 1], shift[b, 2]) if g == 1 else (0.0, 0.0, 0.0)
            for s in range(spheres):
                if limbs.solid[b, s]:
                    u, v, w = centres[0, s, 0] - x, centres[0, s, 1] - y, centres[0, s, 2] - z
                    r, n = limbs.radius[b, s], limbs.segment[s]
                    count = _sphere(u, v, w, r, s, n, g, index, near, found, p, count, space)
        many[p] = count
        overlap[p] = max(0.0, found[p, 0, 0]) if count > 0 else 0.0
        for i in range(count):
            f, s = int(found[p, i, 2]), int(found[p, i, 1])
            part[p, i] = owner[f]
            moved = field.root.shape[0] > 1 and index[5][owner[f]] > 0
            x, y, z = (shift[b, 0], shift[b, 1], shift[b, 2]) if moved else (0.0, 0.0, 0.0)
            depth = allowed[limbs.segment[s], owner[f]]
            _plane(limbs, b, (x, y, z), world, centres, index[6], found, p, i, depth, clear, planes)


@njit(cache=True, nogil=True)
def least_heights(limbs, who, held, base, ways, out, begin, end):  # type: ignore[no-untyped-def]
    """Place the segments of rows begin..end, row p of body who[p], and fill out (P, W) with the least height of their
    spheres along each way. ways: vectors (W, 3) and which segments count (W, N)."""
    way, counts = ways
    joints, spheres, segments = held.shape[1], limbs.centre.shape[2], limbs.skin.shown.shape[0]
    rotations, world = np.zeros((1, joints, 4)), np.zeros((1, segments, 3, 4))
    centres, angles = np.zeros((1, spheres, 3)), np.zeros((1, 1, 3))
    for p in range(begin, end):
        b = who[p]
        _placed(limbs, b, held, base, angles, p, (rotations, world, centres))
        for w in range(len(way)):
            out[p, w] = np.inf
            for s in range(spheres):
                if counts[w, limbs.segment[s]]:
                    high = way[w, 0] * centres[0, s, 0] + way[w, 1] * centres[0, s, 1] + way[w, 2] * centres[0, s, 2]
                    out[p, w] = min(out[p, w], high - limbs.radius[b, s])
