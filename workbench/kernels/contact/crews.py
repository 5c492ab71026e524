"""Many different bodies of a family, one pose each: where their spheres are, and the least
clearance of each thing that is asked for."""

from __future__ import annotations

import math

import numpy as np

from workbench.kernels.compiled import njit
from workbench.kernels.contact.inside import inside_part
from workbench.kernels.contact.polygon import point_polygon
from workbench.kernels.contact.tree import box_gap, nearest_polygon
from workbench.kernels.forward import Chain, Skin, chain_transforms, place_spheres

__all__ = ["least_gaps", "place_crew"]


@njit(cache=True, nogil=True)
def place_crew(rotations, chain, skin, segment, family, world, centres, begin, end):  # type: ignore[no-untyped-def]
    """Place bodies begin..end.

    rotations (B, J, 4); chain, skin: of one of them; segment (S,): of each sphere. family:
    in_parent, in_child (B, J, 3), centre (B, S, 3), twist_point, twist_axis (B, N, 3), twist_share,
    blend_share (B, S). world (B, N, 3, 4): the reference segment's is there before; centres (B, S,
    3).
    """
    in_parent, in_child, centre, twist_point, twist_axis, twist_share, blend_share = family
    steps = len(chain.to)
    count = centre.shape[1]
    came = np.empty((steps, 3))
    to = np.empty((steps, 3))
    own = np.empty((3, count))
    out = np.empty((3, count))
    across = np.empty((3, count))
    joint = np.zeros((count, 3))
    for b in range(begin, end):
        for m in range(steps):
            j = chain.joint[m]
            for i in range(3):
                up = in_parent[b, j, i]
                down = in_child[b, j, i]
                came[m, i], to[m, i] = (down, up) if chain.upward[m] else (up, down)
        for s in range(count):
            n = segment[s]
            x = twist_axis[b, n, 0]
            y = twist_axis[b, n, 1]
            z = twist_axis[b, n, 2]
            u = centre[b, s, 0] - twist_point[b, n, 0]
            v = centre[b, s, 1] - twist_point[b, n, 1]
            w = centre[b, s, 2] - twist_point[b, n, 2]
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
                own[i, s] = centre[b, s, i]
            j = skin.blend_joint[s]
            if j >= 0:
                for i in range(3):
                    joint[s, i] = in_child[b, j, i] if skin.distal[s] else in_parent[b, j, i]
        one = Chain(chain.to, chain.came, chain.joint, chain.upward, came, to)
        chain_transforms(rotations[b : b + 1], one, 0, world[b : b + 1])
        whole = Skin(
            own,
            out,
            across,
            skin.start,
            skin.twist_joint,
            skin.joint_axis,
            twist_axis[b],
            twist_share[b],
            skin.shown,
            skin.blend_joint,
            blend_share[b],
            joint,
            skin.blended,
            skin.blend_start,
            skin.distal,
            skin.twist_shared,
        )
        place_spheres(rotations[b : b + 1], world[b : b + 1], whole, centres[b : b + 1])


@njit(cache=True, nogil=True, forceinline=True)
def _nearest(x, y, z, r, most, faces, shells, k, free, stack):  # type: ignore[no-untyped-def]
    """Signed distance of a sphere to part k, the polygon and its point, -1 where not below `most`;
    and how far about the centre there is surely no surface. free: what is known of that before, 0
    where nothing is."""
    root = faces.root[k]
    gap = math.sqrt(box_gap(x, y, z, faces.low[root], faces.high[root]))
    if max(gap, free) > 0.0 and max(gap, free) - r >= most:
        return np.inf, -1, x, y, z, max(gap, free)
    inside = free <= 0.0 and inside_part(x, y, z, faces, shells, k, stack)
    if not inside and most + r <= 0.0:
        return np.inf, -1, x, y, z, max(gap, free)
    limit = np.inf if inside or most == np.inf else (most + r) * (most + r) * (1.0 + 1e-12)
    square, f, px, py, pz = nearest_polygon(x, y, z, faces, k, limit)
    if f < 0:
        return np.inf, -1, x, y, z, math.sqrt(limit)
    away = math.sqrt(square)
    return (-away if inside else away) - r, f, px, py, pz, 0.0 if inside else away


@njit(cache=True, nogil=True, forceinline=True)
def _bounds(b, centres, radius, shift, asked, faces, lead, bound):  # type: ignore[no-untyped-def]
    """How near body b comes at least, by the sphere and polygon that were nearest of the one
    before: bound (Q,), a hair more, so that it cuts off nothing that counts."""
    for q in range(len(bound)):
        m = lead[q, 0]
        s = lead[q, 1]
        f = lead[q, 2]
        bound[q] = np.inf
        if m >= 0:
            moves = asked[2][m, 3]
            x = centres[b, s, 0]
            y = centres[b, s, 1]
            z = centres[b, s, 2]
            x = x - moves * shift[b, 0]
            y = y - moves * shift[b, 1]
            z = z - moves * shift[b, 2]
            square = point_polygon(x, y, z, faces, f, np.inf)[0]
            bound[q] = math.sqrt(square) - radius[b, s] + asked[3][m] + 1e-9


@njit(cache=True, nogil=True)
def least_gaps(centres, radius, shift, asked, faces, shells, out, begin, end):  # type: ignore[no-untyped-def]
    """Least signed distance plus allowance, for bodies begin..end.

    centres (B, S, 3), radius (B, S); shift (B, 3): how far the parts that go along have gone.
    asked: rows: spheres, group by group; first (G + 1,): where each group begins; pairs (M, 4):
    question, group, part, 1 where the part goes along; allowed (M,): added to the pair's distance.
    out: room (B, Q), infinite before; sphere, polygon (B, Q); point (B, Q, 3): of that polygon,
    where it has gone.

    Spheres are measured only where they may be nearest: not where the one before, with no surface
    about it for so far, or the sphere that was nearest of the body before says that they are not.
    """
    rows, first, pairs, allowed = asked
    room, sphere, polygon, point = out
    stack = np.empty(64, np.int64)
    bound = np.empty(room.shape[1])
    lead = np.full((room.shape[1], 3), -1)
    for b in range(begin, end):
        _bounds(b, centres, radius, shift, asked, faces, lead, bound)
        for m in range(len(pairs)):
            q = pairs[m, 0]
            g = pairs[m, 1]
            k = pairs[m, 2]
            moves = pairs[m, 3]
            if faces.root[k] < 0:
                continue
            hx = 0.0
            hy = 0.0
            hz = 0.0
            clear = 0.0
            for i in range(first[g], first[g + 1]):
                s = rows[i]
                x = centres[b, s, 0] - moves * shift[b, 0]
                y = centres[b, s, 1] - moves * shift[b, 1]
                z = centres[b, s, 2] - moves * shift[b, 2]
                away = math.sqrt((x - hx) ** 2 + (y - hy) ** 2 + (z - hz) ** 2)
                free = max(0.0, clear - away - 1e-9)
                most = min(room[b, q], bound[q]) - allowed[m]
                signed, f, px, py, pz, about = _nearest(
                    x, y, z, radius[b, s], most, faces, shells, k, free, stack
                )
                if about > free:
                    hx = x
                    hy = y
                    hz = z
                    clear = about
                if f >= 0 and signed + allowed[m] < room[b, q]:
                    room[b, q] = signed + allowed[m]
                    sphere[b, q] = s
                    polygon[b, q] = f
                    lead[q, 0] = m
                    lead[q, 1] = s
                    lead[q, 2] = f
                    point[b, q, 0] = px + moves * shift[b, 0]
                    point[b, q, 1] = py + moves * shift[b, 1]
                    point[b, q, 2] = pz + moves * shift[b, 2]
