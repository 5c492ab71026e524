"""Conservative advancement: what two looks at a moving sphere say about the time between them.

A look is a row: time, centre x y z, signed distance of the centre, nearest point x y z. Between two
looks the centre x(t) stays within `way` of the chord, and on the chord, at the fraction f of its
length l:

* for any closed set d(x)^2 - |x|^2 is the least of linear functions, so it is concave, and d^2 >=
  (1 - f) da^2 + f db^2 - f (1 - f) l^2: if that stays positive no surface is crossed and the sign
  stays;
* a signed distance changes by no more than the way moved: it is at least (da + db - l) / 2, at most
  (da + db + l) / 2;
* |x - p| is convex for every point p, so the distance is at most max(|xa - p|, |xb - p|): taken
  with the nearest points of both looks. Inside a solid the same bounds the depth.

Two spheres are the same with the one's centre seen from the other's: the part is the origin.
"""

from __future__ import annotations

import math

import numpy as np

from workbench.compiled import batch_loop, inner, njit
from workbench.contact.kernels.search import foot, signed_distance
from workbench.contact.kernels.wide_bvh import DEEP, EIGHT

__all__ = ["LOOK", "near_pairs", "near_parts", "possible_range", "sample_distances"]

LOOK = 8
"""Numbers in a look."""
_FAR = 1e150


@batch_loop
def possible_range(one, two, way, least, most):  # type: ignore[no-untyped-def]
    """Fill least, most (M,) with the signed distances [m] that are possible between looks one and
    two (M, 8)."""
    for i in range(len(way)):
        a = one[i]
        b = two[i]
        da = a[4]
        db = b[4]
        square = (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2 + (b[3] - a[3]) ** 2
        chord = math.sqrt(square)
        reach = np.inf
        for e in range(2):
            q = a if e == 0 else b
            u = (a[1] - q[5]) ** 2 + (a[2] - q[6]) ** 2 + (a[3] - q[7]) ** 2
            v = (b[1] - q[5]) ** 2 + (b[2] - q[6]) ** 2 + (b[3] - q[7]) ** 2
            reach = min(reach, max(u, v))
        reach = math.sqrt(reach) + way[i]
        least[i] = max(0.5 * (da + db - chord) - way[i], -reach)
        most[i] = min(0.5 * (da + db + chord) + way[i], reach)
        low = min(da * da, db * db)
        if square > abs(da * da - db * db):
            f = 0.5 + 0.5 * (da * da - db * db) / square
            low = (1.0 - f) * da * da + f * db * db - f * (1.0 - f) * square
        low = math.sqrt(max(low, 0.0)) - way[i]
        if low > 0.0 and da > 0.0 and db > 0.0:
            least[i] = max(least[i], low)
        elif low > 0.0 and da < 0.0 and db < 0.0:
            most[i] = min(most[i], -low)


@batch_loop
def sample_distances(parts, part, far, looks, space):  # type: ignore[no-untyped-def]
    """Fill distance and nearest point of looks (M, 8) at parts (M,): exact up to far (M,) [m], no
    less beyond. parts: Parts; space: SearchSpace."""
    for i in range(len(part)):
        row = looks[i]
        x = row[1]
        y = row[2]
        z = row[3]
        signed, rank, _ = signed_distance(
            x, y, z, far[i], 0.0, parts, part[i], space.stack, space.gaps
        )
        row[4] = far[i]
        row[5] = _FAR
        row[6] = _FAR
        row[7] = _FAR
        if rank >= 0:
            row[4] = signed
            row[5], row[6], row[7] = foot(x, y, z, parts.trees, rank)


@inner
def _ball_near(start, end, size, parts, k, stack, gaps):  # type: ignore[no-untyped-def]
    """True where part k may come within `size` of a chord: within a ball around it, or around the
    ball."""
    x = 0.5 * (start[0] + end[0])
    y = 0.5 * (start[1] + end[1])
    z = 0.5 * (start[2] + end[2])
    half = math.sqrt((x - start[0]) ** 2 + (y - start[1]) ** 2 + (z - start[2]) ** 2)
    most = half + max(size, 0.0)
    return signed_distance(x, y, z, most, 0.0, parts, k, stack, gaps)[1] >= 0


@njit(cache=True, nogil=True)
def near_parts(balls, spheres, start, parts, allowed, checked, margin):  # type: ignore[no-untyped-def]
    """All (pair, sphere, part) (M, 3) that may touch: the segment's enclosing sphere may, and so
    may the sphere.

    balls: where the N enclosing spheres and spheres: the S spheres begin and end (P, N or S, 3),
    and how far their surfaces may be from the chord (P, N or S) [m]: radius and straying. start (N
    + 1,): each segment's spheres; a NaN is outside the window. allowed (N, K) [m]: depth that is no
    contact; checked (K,); margin [m].
    """
    from_ball, to_ball, ball_size = balls
    from_sphere, to_sphere, sphere_size = spheres
    rows = np.empty((1024, 3), np.int64)
    used = 0
    stack = np.empty(DEEP, np.int64)
    gaps = np.empty(DEEP + EIGHT, np.float32)
    for p in range(len(from_ball)):
        for n in range(len(start) - 1):
            if start[n] == start[n + 1] or not ball_size[p, n] >= 0.0:
                continue
            for k in range(allowed.shape[1]):
                if checked[k] == 0 or parts.trees.root[k] < 0:
                    continue
                room = margin - allowed[n, k]
                if not _ball_near(
                    from_ball[p, n], to_ball[p, n], ball_size[p, n] + room, parts, k, stack, gaps
                ):
                    continue
                for s in range(start[n], start[n + 1]):
                    size = sphere_size[p, s] + room
                    if not _ball_near(
                        from_sphere[p, s], to_sphere[p, s], size, parts, k, stack, gaps
                    ):
                        continue
                    if used == len(rows):
                        rows = np.concatenate((rows, np.empty_like(rows)))
                    rows[used, 0] = p
                    rows[used, 1] = s
                    rows[used, 2] = k
                    used += 1
    return rows[:used]


@inner
def _chords_meet(a, b, c, d, reach):  # type: ignore[no-untyped-def]
    """True where two points that run from a to b and from c to d in the same time may come within
    `reach`."""
    x = a[0] - c[0]
    y = a[1] - c[1]
    z = a[2] - c[2]
    u = b[0] - d[0] - x
    v = b[1] - d[1] - y
    w = b[2] - d[2] - z
    square = u * u + v * v + w * w
    t = 0.0
    if square > 0.0:
        t = min(max(-(x * u + y * v + z * w) / square, 0.0), 1.0)
    x = x + t * u
    y = y + t * v
    z = z + t * w
    return not math.sqrt(x * x + y * y + z * z) > reach


@njit(cache=True, nogil=True)
def near_pairs(one, other, pairs, allowed, margin):  # type: ignore[no-untyped-def]
    """All (pair, sphere, other sphere) (M, 3) of the segment pairs (Q, 2) that may touch.

    one, other: (balls, spheres, start) as in `near_parts`; allowed (N, N') [m].
    """
    (a0, a1, a_size), (s0, s1, s_size), a_start = one
    (b0, b1, b_size), (v0, v1, v_size), b_start = other
    rows = np.empty((1024, 3), np.int64)
    used = 0
    for p in range(len(a0)):
        for q in range(len(pairs)):
            n = pairs[q, 0]
            m = pairs[q, 1]
            room = margin - allowed[n, m]
            if not _chords_meet(
                a0[p, n], a1[p, n], b0[p, m], b1[p, m], a_size[p, n] + b_size[p, m] + room
            ):
                continue
            for s in range(a_start[n], a_start[n + 1]):
                if not _chords_meet(
                    s0[p, s], s1[p, s], b0[p, m], b1[p, m], s_size[p, s] + b_size[p, m] + room
                ):
                    continue
                for v in range(b_start[m], b_start[m + 1]):
                    if not _chords_meet(
                        s0[p, s], s1[p, s], v0[p, v], v1[p, v], s_size[p, s] + v_size[p, v] + room
                    ):
                        continue
                    if used == len(rows):
                        rows = np.concatenate((rows, np.empty_like(rows)))
                    rows[used, 0] = p
                    rows[used, 1] = s
                    rows[used, 2] = v
                    used += 1
    return rows[:used]
