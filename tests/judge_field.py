"""Signed distances of spheres to the parts of an environment, by exact distances to triangles.

Space is cut into cells. Each cell lists the triangles near it, nearest first, so that the triangles
of a sphere are read until none can be near enough. It also lists the solid parts that its middle is
inside of, or whose surface crosses it, with their winding numbers there. From the middle to another
point of the cell the winding number changes by the triangles that are crossed on the way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

SIDE = 0.04
"""Side of a cell [m]."""
HALF = 0.5 * np.sqrt(3.0) * SIDE
"""From the middle of a cell to its corner [m]."""
ALIKE = 0.9
"""Cosine of two ways out above which they count as one contact."""
FEW = 6
"""Most contacts of one sphere."""


class Field(NamedTuple):
    """The triangles of some parts, in cells."""

    corners: np.ndarray
    """(T, 3, 3) [m] the triangles, those of a part together."""
    part: np.ndarray
    """(T,) the part of each."""
    first: np.ndarray
    """(K + 1,) the first triangle of each part."""
    origin: np.ndarray
    """(3,) [m] the least corner of the first cell."""
    shape: np.ndarray
    """(3,) the number of cells along each axis."""
    start: np.ndarray
    """(C + 1,) where the triangles of each cell begin in `near`."""
    near: np.ndarray
    """(M,) triangles, nearest first."""
    away: np.ndarray
    """(M,) [m] how far each is from the middle of the cell."""
    solid_start: np.ndarray
    """(C + 1,) where the solid parts of each cell begin."""
    solid_part: np.ndarray
    """(Q,) the parts."""
    solid_turns: np.ndarray
    """(Q,) their winding numbers about the middle of the cell."""
    far: float
    """[m] within which of the middle of a cell its triangles are complete."""


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def nearest_point(p, corners, i):
    """The distance from p to triangle i, and its nearest point from p.

    The regions of corners, edges and face are told apart as in Ericson, Real-Time Collision
    Detection (2005), section 5.1.5.
    """
    abx = corners[i, 1, 0] - corners[i, 0, 0]
    aby = corners[i, 1, 1] - corners[i, 0, 1]
    abz = corners[i, 1, 2] - corners[i, 0, 2]
    acx = corners[i, 2, 0] - corners[i, 0, 0]
    acy = corners[i, 2, 1] - corners[i, 0, 1]
    acz = corners[i, 2, 2] - corners[i, 0, 2]
    apx = p[0] - corners[i, 0, 0]
    apy = p[1] - corners[i, 0, 1]
    apz = p[2] - corners[i, 0, 2]
    d1 = abx * apx + aby * apy + abz * apz
    d2 = acx * apx + acy * apy + acz * apz
    d3 = d1 - (abx * abx + aby * aby + abz * abz)
    d4 = d2 - (acx * abx + acy * aby + acz * abz)
    d5 = d1 - (abx * acx + aby * acy + abz * acz)
    d6 = d2 - (acx * acx + acy * acy + acz * acz)
    va = d3 * d6 - d5 * d4
    vb = d5 * d2 - d1 * d6
    vc = d1 * d4 - d3 * d2
    v = 0.0
    w = 0.0
    if d1 <= 0.0 and d2 <= 0.0:
        v = 0.0
    elif d3 >= 0.0 and d4 <= d3:
        v = 1.0
    elif d6 >= 0.0 and d5 <= d6:
        w = 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v = d1 / (d1 - d3)
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        w = d2 / (d2 - d6)
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = 1.0 - w
    else:
        whole = va + vb + vc
        if whole > 0.0:
            v = vb / whole
            w = vc / whole
    x = v * abx + w * acx - apx
    y = v * aby + w * acy - apy
    z = v * abz + w * acz - apz
    return np.sqrt(x * x + y * y + z * z), x, y, z


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def turns_about(p, corners, begin, end):
    """The winding number of triangles begin..end about p: solid angles of van Oosterom and
    Strackee (1983)."""
    total = 0.0
    for i in range(begin, end):
        t = corners[i]
        ax, ay, az = t[0, 0] - p[0], t[0, 1] - p[1], t[0, 2] - p[2]
        bx, by, bz = t[1, 0] - p[0], t[1, 1] - p[1], t[1, 2] - p[2]
        cx, cy, cz = t[2, 0] - p[0], t[2, 1] - p[1], t[2, 2] - p[2]
        a = np.sqrt(ax * ax + ay * ay + az * az)
        b = np.sqrt(bx * bx + by * by + bz * bz)
        c = np.sqrt(cx * cx + cy * cy + cz * cz)
        volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        ab = ax * bx + ay * by + az * bz
        bc = bx * cx + by * cy + bz * cz
        ca = cx * ax + cy * ay + cz * az
        total += 2.0 * np.arctan2(volume, a * b * c + ab * c + bc * a + ca * b)
    return total / (4.0 * np.pi)


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _crossing(p, q, corners, i):
    """How the winding number changes from p to q by triangle i: 1, -1 or 0."""
    t = corners[i]
    dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    ux, uy, uz = t[1, 0] - t[0, 0], t[1, 1] - t[0, 1], t[1, 2] - t[0, 2]
    vx, vy, vz = t[2, 0] - t[0, 0], t[2, 1] - t[0, 1], t[2, 2] - t[0, 2]
    nx = uy * vz - uz * vy
    ny = uz * vx - ux * vz
    nz = ux * vy - uy * vx
    along = dx * nx + dy * ny + dz * nz
    if along == 0.0:
        return 0
    ax, ay, az = t[0, 0] - p[0], t[0, 1] - p[1], t[0, 2] - p[2]
    s = (ax * nx + ay * ny + az * nz) / along
    if s < 0.0 or s >= 1.0:
        return 0
    # the point of the plane from the first corner, in the two edges
    hx, hy, hz = s * dx - ax, s * dy - ay, s * dz - az
    square = nx * nx + ny * ny + nz * nz
    v = ((hy * vz - hz * vy) * nx + (hz * vx - hx * vz) * ny + (hx * vy - hy * vx) * nz) / square
    w = ((uy * hz - uz * hy) * nx + (uz * hx - ux * hz) * ny + (ux * hy - uy * hx) * nz) / square
    if v < 0.0 or w < 0.0 or v + w > 1.0:
        return 0
    return -1 if along > 0.0 else 1


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _cells_near(t, origin, shape, far, low, high):
    """Write the least and the last cell, along each axis, whose middle may be within far of a
    triangle."""
    for i in range(3):
        least = min(t[0, i], t[1, i], t[2, i]) - far - origin[i]
        most = max(t[0, i], t[1, i], t[2, i]) + far - origin[i]
        low[i] = max(0, int(np.floor(least / SIDE - 0.5)))
        high[i] = min(shape[i] - 1, int(np.ceil(most / SIDE - 0.5)))


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _middle(cell, origin, shape, out):
    out[2] = origin[2] + (cell % shape[2] + 0.5) * SIDE
    out[1] = origin[1] + (cell // shape[2] % shape[1] + 0.5) * SIDE
    out[0] = origin[0] + (cell // (shape[2] * shape[1]) + 0.5) * SIDE


@njit(cache=True, nogil=True, error_model="numpy")
def _near_cells(corners, origin, shape, far):
    """(M,) cells, triangles and distances [m] of those within far of the middle of a cell."""
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    at = np.empty(3)
    room = 1 << 20
    cells = np.empty(room, np.int32)
    near = np.empty(room, np.int32)
    away = np.empty(room, np.float32)
    count = 0
    for i in range(len(corners)):
        _cells_near(corners[i], origin, shape, far, low, high)
        for x in range(low[0], high[0] + 1):
            for y in range(low[1], high[1] + 1):
                for z in range(low[2], high[2] + 1):
                    cell = (x * shape[1] + y) * shape[2] + z
                    _middle(cell, origin, shape, at)
                    gap = nearest_point(at, corners, i)[0]
                    if gap > far:
                        continue
                    if count == room:
                        room *= 2
                        cells = np.concatenate((cells, cells))
                        near = np.concatenate((near, near))
                        away = np.concatenate((away, away))
                    cells[count] = cell
                    near[count] = i
                    away[count] = gap
                    count += 1
    return cells[:count], near[:count], away[:count]


@njit(cache=True, nogil=True, error_model="numpy")
def _is_crossed(k, part, cell, start, near, away):
    """Whether the surface of part k may cross a cell."""
    for m in range(start[cell], start[cell + 1]):
        if away[m] > HALF * 1.001:
            return False
        if part[near[m]] == k:
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _solid_cells(corners, part, first, solid, origin, shape, start, near, away):
    """The cells that a solid part fills or crosses: rows of cell, part and winding number."""
    found = [(0, 0, 0)][:0]
    low = np.empty(3, np.int64)
    high = np.empty(3, np.int64)
    at = np.empty(3)
    box = np.empty((3, 3))
    for k in range(len(solid)):
        if not solid[k] or first[k] == first[k + 1]:
            continue
        for i in range(3):
            box[0, i] = corners[first[k] : first[k + 1], :, i].min()
            box[1, i] = corners[first[k] : first[k + 1], :, i].max()
            box[2, i] = box[0, i]
        _cells_near(box, origin, shape, HALF, low, high)
        for x in range(low[0], high[0] + 1):
            for y in range(low[1], high[1] + 1):
                for z in range(low[2], high[2] + 1):
                    cell = (x * shape[1] + y) * shape[2] + z
                    _middle(cell, origin, shape, at)
                    turns = int(np.round(turns_about(at, corners, first[k], first[k + 1])))
                    if turns != 0 or _is_crossed(k, part, cell, start, near, away):
                        found.append((cell, k, turns))
    return found


def field_of(corners, part, solid, low, high, far):
    """The field of the triangles (T, 3, 3) of K parts, between the corners low and high (3,) [m].

    Parameters
    ----------
    corners, part
        The triangles [m], and the part of each; those of a part together, parts in order.
    solid
        (K,) whether each part is solid.
    low, high
        Where spheres may be [m].
    far
        How far a sphere reaches [m].
    """
    first = np.searchsorted(part, np.arange(len(solid) + 1)).astype(np.int64)
    origin = np.asarray(low, float) - SIDE
    shape = np.maximum(1, np.ceil((np.asarray(high, float) - origin) / SIDE).astype(np.int64) + 1)
    far = far + HALF
    cells, near, away = _near_cells(corners, origin, shape, far)
    # by cell, then by distance: floats that are not negative are in the order of their bits
    order = np.argsort((cells.astype(np.int64) << 32) | away.view(np.int32))
    near = near[order]
    away = away[order]
    start = np.concatenate([[0], np.cumsum(np.bincount(cells, minlength=int(shape.prod())))])
    rows = _solid_cells(corners, part, first, solid, origin, shape, start, near, away)
    table = np.array(rows, np.int64).reshape(-1, 3)
    table = table[np.argsort(table[:, 0], kind="stable")]
    solid_start = np.searchsorted(table[:, 0], np.arange(len(start))).astype(np.int64)
    return Field(
        corners=np.ascontiguousarray(corners, dtype=float),
        part=np.asarray(part, np.int64),
        first=first,
        origin=origin,
        shape=shape,
        start=start,
        near=near,
        away=away,
        solid_start=solid_start,
        solid_part=np.ascontiguousarray(table[:, 1]),
        solid_turns=np.ascontiguousarray(table[:, 2]),
        far=far,
    )


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _inside_parts(field, cell, p, middle, aside, parts, turns):
    """Write the solid parts that p is inside of into parts; return how many.

    Only triangles within `aside`, the distance of p from the middle, can be crossed on the way.
    """
    first = field.solid_start[cell]
    count = min(len(parts), field.solid_start[cell + 1] - first)
    for q in range(count):
        parts[q] = field.solid_part[first + q]
        turns[q] = field.solid_turns[first + q]
    for m in range(field.start[cell], field.start[cell + 1]):
        if field.away[m] > aside + 1e-6:
            break
        t = field.near[m]
        k = field.part[t]
        for q in range(count):
            if parts[q] == k:
                turns[q] += _crossing(middle, p, field.corners, t)
    inside = 0
    for q in range(count):
        if turns[q] != 0:
            parts[inside] = parts[q]
            inside += 1
    return inside


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _way_out(field, k, cell, p, aside):
    """The distance from p to the surface of part k, and its nearest point from p."""
    best = (np.inf, 0.0, 0.0, 0.0)
    for m in range(field.start[cell], field.start[cell + 1]):
        if field.away[m] - aside > best[0] + 1e-6:
            return best
        if field.part[field.near[m]] == k:
            found = nearest_point(p, field.corners, field.near[m])
            if found[0] < best[0]:
                best = found
    if best[0] < field.far - aside - 1e-6:
        return best
    for t in range(field.first[k], field.first[k + 1]):
        found = nearest_point(p, field.corners, t)
        if found[0] < best[0]:
            best = found
    return best


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _add(depth, out, count, excess, x, y, z):
    """Add a contact with a unit way out, or put it in the place of a shallower one that is alike;
    return how many there are."""
    for c in range(count):
        if out[c, 0] * x + out[c, 1] * y + out[c, 2] * z > ALIKE:
            if excess > depth[c]:
                depth[c] = excess
                out[c, 0], out[c, 1], out[c, 2] = x, y, z
            return count
    if count == len(depth):
        least = 0
        for c in range(1, count):
            if depth[c] < depth[least]:
                least = c
        if depth[least] >= excess:
            return count
        count -= 1
        depth[least], depth[count] = depth[count], depth[least]
        for i in range(3):
            out[least, i] = out[count, i]
    depth[count] = excess
    out[count, 0], out[count, 1], out[count, 2] = x, y, z
    return count + 1


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def sphere_contacts(field, p, radius, allowed, off, depth, out, count, parts):
    """Add the contacts of one sphere with all parts of a field.

    Parameters
    ----------
    p, radius
        The centre (3,) and the radius [m]; a negative one asks for spheres that are shrunk.
    allowed
        (K,) how deep the sphere may be in each part [m].
    off
        How near [m] counts as a contact.
    depth, out, count
        The contacts so far: depth beyond what is allowed [m] and unit way out; how many.
    parts
        (2, n) room for the numbers of parts.

    Returns
    -------
    int
        How many contacts there are now.
    """
    ix = int(np.floor((p[0] - field.origin[0]) / SIDE))
    iy = int(np.floor((p[1] - field.origin[1]) / SIDE))
    iz = int(np.floor((p[2] - field.origin[2]) / SIDE))
    if min(ix, iy, iz) < 0 or ix >= field.shape[0] or iy >= field.shape[1] or iz >= field.shape[2]:
        return count
    cell = (ix * field.shape[1] + iy) * field.shape[2] + iz
    begin = field.start[cell]
    end = field.start[cell + 1]
    solids = field.solid_start[cell + 1] > field.solid_start[cell]
    if begin == end and not solids:
        return count
    x = field.origin[0] + (ix + 0.5) * SIDE
    y = field.origin[1] + (iy + 0.5) * SIDE
    z = field.origin[2] + (iz + 0.5) * SIDE
    aside = np.sqrt((p[0] - x) ** 2 + (p[1] - y) ** 2 + (p[2] - z) ** 2)
    if not solids and field.away[begin] - aside > radius + off + 1e-6:
        return count
    inside = 0
    if solids:
        inside = _inside_parts(field, cell, p, (x, y, z), aside, parts[0], parts[1])
    for i in range(inside):
        k = parts[0, i]
        gap, x, y, z = _way_out(field, k, cell, p, aside)
        excess = radius + gap - allowed[k]
        if excess > -off and gap > 1e-9:
            count = _add(depth, out, count, excess, x / gap, y / gap, z / gap)
    for m in range(begin, end):
        if field.away[m] - aside > radius + off + 1e-6:
            break
        t = field.near[m]
        k = field.part[t]
        within = False
        for i in range(inside):
            within |= parts[0, i] == k
        if within:
            continue
        gap, x, y, z = nearest_point(p, field.corners, t)
        excess = radius - gap - allowed[k]
        if excess > -off and gap > 1e-9:
            count = _add(depth, out, count, excess, -x / gap, -y / gap, -z / gap)
    return count
