"""Kinematics, joint stops and skin of one limb of one person, and how they change with each turn.

A turn is one free angle: a component of a joint's swing, or its twist. All lengths are in metres,
all angles in radians.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

CONE = 1
HINGE = 2
POLYGON = 3


class Chain(NamedTuple):
    """The K segments that a limb moves, from the held one outward, and its D turns."""

    parent: np.ndarray
    """(K,) the segment before, -1 where that is held."""
    held: np.ndarray
    """(K, 3, 4) where the held segment before is in the world."""
    at_parent: np.ndarray
    """(K, 3) the joint in the frame of the segment before."""
    at_child: np.ndarray
    """(K, 3) the joint in the segment's own frame."""
    axes: np.ndarray
    """(K, 3, 3) axes of swing, swing and twist, rows."""
    turn: np.ndarray
    """(K, 3) the turn of each axis, -1 where it keeps its angle."""
    angle: np.ndarray
    """(K, 3) the angles that are kept."""
    owner: np.ndarray
    """(D,) the segment of each turn."""
    axis: np.ndarray
    """(D,) its axis."""
    moves: np.ndarray
    """(K, D) whether a turn moves a segment."""
    kind: np.ndarray
    """(K,) of stop; 0 where the joint is not free."""
    limits: np.ndarray
    """(K, 3, 2)."""
    play: np.ndarray
    """(K,) how far a hinge may stray about its other axes."""
    couplings: np.ndarray
    """(C, 5) segment, axis and side of a limit, and the driver's segment and axis."""
    coupled: np.ndarray
    """(C, 4) two angles of the driver and the limits there."""
    polygon: np.ndarray
    """(V, 3) unit vectors, counter-clockwise."""
    edges: np.ndarray
    """(V, 3) unit normals of its edges, each from a vertex to the next; they point inward."""
    wedges: np.ndarray
    """(V, 3) normals of the planes through a direction inside and each vertex."""
    window: int
    """How many edges to each side of the nearest vertex are looked at."""
    pointer: np.ndarray
    """(3,) the direction of the limb in the zero pose."""
    shaped: int
    """The segment that the polygon holds for, -1 for none."""
    frame: int
    """The segment in whose frame the polygon stands, -1 where it is held."""
    frame_turn: np.ndarray
    """(3, 3) its turn, where it is held."""
    end: int
    tip: np.ndarray
    """(3,) in the frame of `end`."""


class Skin(NamedTuple):
    """The S spheres of the limb that may meet obstacles."""

    segment: np.ndarray
    """(S,) index into the chain."""
    centre: np.ndarray
    """(S, 3)."""
    radius: np.ndarray
    allowed: np.ndarray
    """(S, parts) how deep each may be in each part."""
    twist: np.ndarray
    """(S,) the segment whose joint's twist it shares, -1 for none."""
    twist_share: np.ndarray
    twist_point: np.ndarray
    """(S, 3) of the line that it twists about."""
    twist_axis: np.ndarray
    """(S, 3)."""
    blend: np.ndarray
    """(S,) the segment whose joint it is blended across, -1 for none."""
    blend_share: np.ndarray
    blend_point: np.ndarray
    """(S, 3) the joint in the sphere's own segment."""
    distal: np.ndarray
    """(S,) whether the sphere is beyond the joint."""
    shared: np.ndarray
    """(S,) whether the segment before the joint shares its twist."""


class State(NamedTuple):
    """Where the turns have brought the limb."""

    angles: np.ndarray
    """(K, 3)."""
    world: np.ndarray
    """(K, 3, 4)."""
    joint: np.ndarray
    """(K, 3) in the world."""
    swing: np.ndarray
    """(K, 3, 3) rotation of the swing."""
    twist: np.ndarray
    """(K, 3, 3) rotation of the twist."""
    spin: np.ndarray
    """(D, 3) the angular velocity in the world for each turn."""
    room: np.ndarray
    """(6, 3) to work in."""
    turned: np.ndarray
    """(3, 3) to work in."""


def state_of(chain):
    """A state to be filled."""
    k = len(chain.parent)
    d = len(chain.owner)
    return State(
        np.zeros((k, 3)),
        np.zeros((k, 3, 4)),
        np.zeros((k, 3)),
        np.zeros((k, 3, 3)),
        np.zeros((k, 3, 3)),
        np.zeros((d, 3)),
        np.zeros((6, 3)),
        np.zeros((3, 3)),
    )


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _clear(rows, i):
    for j in range(rows.shape[1]):
        rows[i, j] = 0.0


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _rodrigues(x, y, z, out):
    """Write the rotation by a vector into out (3, 3)."""
    square = x * x + y * y + z * z
    size = np.sqrt(square)
    a = np.sin(size) / size if size > 1e-9 else 1.0
    b = (1.0 - np.cos(size)) / square if size > 1e-5 else 0.5
    out[0, 0] = 1.0 - b * (y * y + z * z)
    out[1, 1] = 1.0 - b * (x * x + z * z)
    out[2, 2] = 1.0 - b * (x * x + y * y)
    out[0, 1] = b * x * y - a * z
    out[1, 0] = b * x * y + a * z
    out[0, 2] = b * x * z + a * y
    out[2, 0] = b * x * z - a * y
    out[1, 2] = b * y * z - a * x
    out[2, 1] = b * y * z + a * x


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _times(a, b, out):
    """Write the product of two matrices (3, 3) into out."""
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _swing_spin(v, axis, before, out):
    """Write the angular velocity in the world of a swing vector v that grows along an axis: the
    left Jacobian of the rotation vector, turned by the frame before."""
    square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    size = np.sqrt(square)
    b = (1.0 - np.cos(size)) / square if size > 1e-4 else 0.5
    c = (size - np.sin(size)) / (square * size) if size > 1e-4 else 1.0 / 6.0
    x = v[1] * axis[2] - v[2] * axis[1]
    y = v[2] * axis[0] - v[0] * axis[2]
    z = v[0] * axis[1] - v[1] * axis[0]
    p = axis[0] + b * x + c * (v[1] * z - v[2] * y)
    q = axis[1] + b * y + c * (v[2] * x - v[0] * z)
    r = axis[2] + b * z + c * (v[0] * y - v[1] * x)
    for i in range(3):
        out[i] = before[i, 0] * p + before[i, 1] * q + before[i, 2] * r


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def move(chain, turns, state):
    """Bring the limb to turns (D,)."""
    own = state.turned
    vector = state.room[0]
    for k in range(len(chain.parent)):
        for a in range(3):
            d = chain.turn[k, a]
            state.angles[k, a] = turns[d] if d >= 0 else chain.angle[k, a]
        angles = state.angles[k]
        axes = chain.axes[k]
        for i in range(3):
            vector[i] = angles[0] * axes[0, i] + angles[1] * axes[1, i]
        _rodrigues(vector[0], vector[1], vector[2], state.swing[k])
        t = angles[2]
        _rodrigues(t * axes[2, 0], t * axes[2, 1], t * axes[2, 2], state.twist[k])
        _times(state.swing[k], state.twist[k], own)
        above = chain.held[k] if chain.parent[k] < 0 else state.world[chain.parent[k]]
        here = state.world[k]
        _times(above, own, here)
        at = chain.at_parent[k]
        back = chain.at_child[k]
        for i in range(3):
            state.joint[k, i] = (
                above[i, 3] + above[i, 0] * at[0] + above[i, 1] * at[1] + above[i, 2] * at[2]
            )
            here[i, 3] = state.joint[k, i] - (
                here[i, 0] * back[0] + here[i, 1] * back[1] + here[i, 2] * back[2]
            )
        for a in range(2):
            d = chain.turn[k, a]
            if d >= 0:
                _swing_spin(vector, axes[a], above, state.spin[d])
        d = chain.turn[k, 2]
        if d >= 0:
            for i in range(3):
                state.spin[d, i] = (
                    here[i, 0] * axes[2, 0] + here[i, 1] * axes[2, 1] + here[i, 2] * axes[2, 2]
                )


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _about(spin, x, y, z, out):
    """Add the velocity of a point at x, y, z from the joint to out (3,)."""
    out[0] += spin[1] * z - spin[2] * y
    out[1] += spin[2] * x - spin[0] * z
    out[2] += spin[0] * y - spin[1] * x


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def tip(chain, state, out):
    """Write the tip (3,) into out."""
    w = state.world[chain.end]
    t = chain.tip
    for i in range(3):
        out[i] = w[i, 3] + w[i, 0] * t[0] + w[i, 1] * t[1] + w[i, 2] * t[2]


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def tip_slope(chain, state, at, out):
    """Write how the tip at `at` changes with each turn into out (D, 3)."""
    for d in range(len(chain.owner)):
        _clear(out, d)
        if chain.moves[chain.end, d]:
            o = state.joint[chain.owner[d]]
            _about(state.spin[d], at[0] - o[0], at[1] - o[1], at[2] - o[2], out[d])


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _twisted(skin, s, angle, out):
    """Write the centre of a sphere that is turned about its line by its share of a twist."""
    share = skin.twist_share[s] * angle
    p = skin.twist_point[s]
    axis = skin.twist_axis[s]
    x = out[0] - p[0]
    y = out[1] - p[1]
    z = out[2] - p[2]
    c = np.cos(share)
    n = np.sin(share)
    along = (axis[0] * x + axis[1] * y + axis[2] * z) * (1.0 - c)
    out[0] = p[0] + c * x + n * (axis[1] * z - axis[2] * y) + along * axis[0]
    out[1] = p[1] + c * y + n * (axis[2] * x - axis[0] * z) + along * axis[1]
    out[2] = p[2] + c * z + n * (axis[0] * y - axis[1] * x) + along * axis[2]


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _applied(m, v):
    return (
        m[0, 0] * v[0] + m[0, 1] * v[1] + m[0, 2] * v[2],
        m[1, 0] * v[0] + m[1, 1] * v[1] + m[1, 2] * v[2],
        m[2, 0] * v[0] + m[2, 1] * v[1] + m[2, 2] * v[2],
    )


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _back(m, v):
    """The transpose of m times v."""
    return (
        m[0, 0] * v[0] + m[1, 0] * v[1] + m[2, 0] * v[2],
        m[0, 1] * v[0] + m[1, 1] * v[1] + m[2, 1] * v[2],
        m[0, 2] * v[0] + m[1, 2] * v[1] + m[2, 2] * v[2],
    )


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _across(skin, s, state, v):
    """A point v of a sphere's segment, seen from the joint that it is blended across, carried along
    with the other segment."""
    swing = state.swing[skin.blend[s]]
    twist = state.twist[skin.blend[s]]
    if skin.distal[s]:
        # the joint turns by S T; seen from beyond it, the other segment by its inverse
        if skin.shared[s]:
            return _back(twist, _back(swing, _applied(twist, v)))
        return _back(twist, _back(swing, v))
    if skin.shared[s]:
        return _applied(swing, v)
    return _applied(swing, _applied(twist, v))


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def sphere_centre(skin, state, s, out):
    """Write the centre of sphere s in the world into out (3,)."""
    for i in range(3):
        out[i] = skin.centre[s, i]
    if skin.twist[s] >= 0:
        _twisted(skin, s, state.angles[skin.twist[s], 2], out)
    if skin.blend[s] >= 0:
        b = skin.blend_point[s]
        v = (out[0] - b[0], out[1] - b[1], out[2] - b[2])
        u = _across(skin, s, state, v)
        for i in range(3):
            out[i] += skin.blend_share[s] * (u[i] - v[i])
    w = state.world[skin.segment[s]]
    x, y, z = out[0], out[1], out[2]
    for i in range(3):
        out[i] = w[i, 3] + w[i, 0] * x + w[i, 1] * y + w[i, 2] * z


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def sphere_slope(chain, skin, state, s, at, out):
    """Write how the centre `at` of sphere s changes with each turn into out (D, 3)."""
    n = skin.segment[s]
    for d in range(len(chain.owner)):
        _clear(out, d)
        if chain.moves[n, d]:
            o = state.joint[chain.owner[d]]
            _about(state.spin[d], at[0] - o[0], at[1] - o[1], at[2] - o[2], out[d])
    local = state.room[5]
    for i in range(3):
        local[i] = skin.centre[s, i]
    if skin.twist[s] >= 0:
        _twisted(skin, s, state.angles[skin.twist[s], 2], local)
        _twist_slope(chain, skin, state, s, local, out)
    if skin.blend[s] >= 0:
        _blend_slope(chain, skin, state, s, local, out)


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _twist_slope(chain, skin, state, s, local, out):
    """Add how a sphere, `local` in its segment, moves with the twist that it shares."""
    d = chain.turn[skin.twist[s], 2]
    if d < 0:
        return
    p = skin.twist_point[s]
    axis = skin.twist_axis[s]
    share = skin.twist_share[s]
    x, y, z = local[0] - p[0], local[1] - p[1], local[2] - p[2]
    t = (
        share * (axis[1] * z - axis[2] * y),
        share * (axis[2] * x - axis[0] * z),
        share * (axis[0] * y - axis[1] * x),
    )
    if skin.blend[s] >= 0:
        u = _across(skin, s, state, t)
        w = skin.blend_share[s]
        t = (t[0] + w * (u[0] - t[0]), t[1] + w * (u[1] - t[1]), t[2] + w * (u[2] - t[2]))
    moved = _applied(state.world[skin.segment[s]], t)
    for i in range(3):
        out[d, i] += moved[i]


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _blend_slope(chain, skin, state, s, local, out):
    """Add what the turns of the joint that a sphere is blended across change besides.

    The share w of a proximal sphere goes along with the distal segment; that of a distal one stays
    with the proximal segment, but for a twist that this one shares.
    """
    b = skin.blend[s]
    p = skin.blend_point[s]
    world = state.world[skin.segment[s]]
    v = (local[0] - p[0], local[1] - p[1], local[2] - p[2])
    u = _applied(world, _across(skin, s, state, v))
    w = -skin.blend_share[s] if skin.distal[s] else skin.blend_share[s]
    u = (w * u[0], w * u[1], w * u[2])
    for a in range(3):
        d = chain.turn[b, a]
        if d < 0:
            continue
        if a < 2 or not skin.shared[s] or skin.distal[s]:
            _about(state.spin[d], u[0], u[1], u[2], out[d])
        if a == 2 and skin.shared[s] and skin.distal[s]:
            axis = _back(state.twist[b], _back(state.swing[b], chain.axes[b, 2]))
            _about(_applied(world, axis), -u[0], -u[1], -u[2], out[d])


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _limit(chain, state, k, axis, side, slope):
    """A limit as its couplings have it; slope (2,): the driver's turn and how the limit changes."""
    slope[0] = -1.0
    slope[1] = 0.0
    limit = chain.limits[k, axis, side]
    for c in range(len(chain.couplings)):
        row = chain.couplings[c]
        if row[0] != k or row[1] != axis or row[2] != side:
            continue
        first, last, low, high = chain.coupled[c]
        driver = state.angles[row[3], row[4]]
        share = min(1.0, max(0.0, (driver - first) / (last - first)))
        limit = low + share * (high - low)
        if 0.0 < share < 1.0:
            slope[0] = chain.turn[row[3], row[4]]
            slope[1] = (high - low) / (last - first)
    return limit


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _range_breach(chain, state, k, axis, slack, spare, breach, slopes, count):
    """Add how far one angle is past its range, widened by slack, and its slopes (D,); return the
    new count."""
    d = chain.turn[k, axis]
    if d < 0:
        return count
    angle = state.angles[k, axis]
    driver = state.room[1]
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        limit = _limit(chain, state, k, axis, side, driver)
        limit += slack
        past = sign * angle - limit + min(spare, 0.5 * max(limit, 0.0))
        if past > 0.0:
            breach[count] = past
            _clear(slopes, count)
            slopes[count, d] = sign
            if driver[0] >= 0.0:
                slopes[count, int(driver[0])] -= driver[1]
            count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _cone_breach(chain, state, k, spare, breach, slopes, count):
    """Add how far a swing is outside its ellipse: (q - 1) / |grad q|; return the new count."""
    driver = state.room[1]
    value = 0.0
    grad = state.room[2]
    for a in range(2):
        s = state.angles[k, a]
        limit = _limit(chain, state, k, a, 0 if s >= 0.0 else 1, driver)
        limit = max(limit - spare, 0.5 * limit, 1e-9)
        value += (s / limit) ** 2
        grad[a] = s / limit**2
    q = np.sqrt(value)
    if q <= 1.0:
        return count
    size = np.sqrt(grad[0] ** 2 + grad[1] ** 2) / q
    breach[count] = (q - 1.0) / size
    _clear(slopes, count)
    for a in range(2):
        if chain.turn[k, a] >= 0:
            slopes[count, chain.turn[k, a]] = grad[a] / q / size
    return count + 1


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
def _dot(rows, v, g):
    return rows[v, 0] * g[0] + rows[v, 1] * g[1] + rows[v, 2] * g[2]


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _nearest_on_edges(polygon, edges, window, g, best):
    """Write the direction on the edges of a spherical polygon that is nearest to g into best: on
    the edges about the nearest vertex."""
    count = len(polygon)
    nearest = 0
    most = -2.0
    for v in range(count):
        cosine = _dot(polygon, v, g)
        if cosine > most:
            most = cosine
            nearest = v
    for i in range(3):
        best[i] = polygon[nearest, i]
    for step in range(-window, window):
        v = (nearest + step) % count
        a = polygon[v]
        b = polygon[(v + 1) % count]
        nx, ny, nz = edges[v, 0], edges[v, 1], edges[v, 2]
        height = _dot(edges, v, g)
        x, y, z = g[0] - height * nx, g[1] - height * ny, g[2] - height * nz
        long = max(np.sqrt(x * x + y * y + z * z), 1e-300)
        x, y, z = x / long, y / long, z / long
        after = nx * (a[1] * z - a[2] * y) + ny * (a[2] * x - a[0] * z) + nz * (a[0] * y - a[1] * x)
        until = nx * (y * b[2] - z * b[1]) + ny * (z * b[0] - x * b[2]) + nz * (x * b[1] - y * b[0])
        cosine = g[0] * x + g[1] * y + g[2] * z
        if after >= 0.0 and until >= 0.0 and cosine > most:
            most = cosine
            best[0], best[1], best[2] = x, y, z


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _is_within(wedges, edges, g):
    """Whether a direction is inside a spherical polygon: on the inner side of the edge of the wedge
    that it is in."""
    count = len(edges)
    left = _dot(wedges, 0, g)
    for v in range(count):
        right = _dot(wedges, v + 1 if v + 1 < count else 0, g)
        if left >= 0.0 and right < 0.0:
            return _dot(edges, v, g) >= 0.0
        left = right
    return False


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def _polygon_breach(chain, state, spare, breach, slopes, count):
    """Add how far the limb's direction is outside its polygon; return the new count."""
    k = chain.shaped
    limb = _applied(state.world[k], chain.pointer)
    frame = chain.frame_turn if chain.frame < 0 else state.world[chain.frame]
    g = state.room[3]
    best = state.room[4]
    g[0], g[1], g[2] = _back(frame, limb)
    _nearest_on_edges(chain.polygon, chain.edges, chain.window, g, best)
    gap = 2.0 * np.arcsin(
        min(
            1.0,
            0.5 * np.sqrt((g[0] - best[0]) ** 2 + (g[1] - best[1]) ** 2 + (g[2] - best[2]) ** 2),
        )
    )
    past = -gap if _is_within(chain.wedges, chain.edges, g) else gap
    if past + spare <= 0.0:
        return count
    # the turn that brings the limb's direction to the nearest one of the polygon, in the world
    x = g[1] * best[2] - g[2] * best[1]
    y = g[2] * best[0] - g[0] * best[2]
    z = g[0] * best[1] - g[1] * best[0]
    size = np.sqrt(x * x + y * y + z * z)
    if size < 1e-12:
        return count
    sign = -1.0 if past > 0.0 else 1.0
    inward = _applied(frame, (sign * x / size, sign * y / size, sign * z / size))
    breach[count] = past + spare
    for d in range(len(chain.owner)):
        slopes[count, d] = 0.0
        if chain.moves[k, d] and not (chain.frame >= 0 and chain.moves[chain.frame, d]):
            spin = state.spin[d]
            slopes[count, d] = spin[0] * inward[0] + spin[1] * inward[1] + spin[2] * inward[2]
    return count + 1


@njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
def breaches(chain, state, spare, breach, slopes):
    """Write how far the joints are past their stops, drawn in by `spare`, and how that changes with
    each turn; return how many breaches there are."""
    count = 0
    for k in range(len(chain.parent)):
        kind = chain.kind[k]
        if kind == CONE:
            count = _cone_breach(chain, state, k, spare, breach, slopes, count)
            count = _range_breach(chain, state, k, 2, 0.0, spare, breach, slopes, count)
        elif kind == HINGE:
            for axis in range(3):
                slack = chain.play[k] if axis > 0 else 0.0
                count = _range_breach(chain, state, k, axis, slack, spare, breach, slopes, count)
        elif kind == POLYGON:
            count = _polygon_breach(chain, state, spare, breach, slopes, count)
            count = _range_breach(chain, state, k, 2, 0.0, spare, breach, slopes, count)
    return count
