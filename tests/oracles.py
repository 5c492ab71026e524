"""Slow and obvious: what every kernel must equal. One table feeds the tests and the benchmarks."""

from __future__ import annotations

import numpy as np


def matrix(q):
    """Rotation matrix of a quaternion by its action on the axes: q v q*."""

    def times(a, b):
        return np.array(
            [a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))]
        )

    inverse = q * [1, -1, -1, -1] / (q @ q)
    return np.stack(
        [times(times(q, np.array([0.0, *axis])), inverse)[1:] for axis in np.eye(3)], axis=1
    )


def forward(body, poses):
    """World transforms as 4 x 4 products from the reference segment outward, one segment at a
    time."""
    n = len(body.segments)
    world = np.full((len(poses), n, 4, 4), np.nan)
    for p in range(len(poses)):
        done = {poses.reference}
        world[p, poses.reference] = np.vstack([poses.world_from_reference[p], [0, 0, 0, 1]])
        while len(done) < n:
            for child in range(1, n):
                parent = int(body.parent[child])
                j = child - 1
                parent_from_child = np.eye(4)
                parent_from_child[:3, :3] = matrix(poses.rotations[p, j])
                shift = parent_from_child[:3, :3] @ body.joint_in_child[0, j]
                parent_from_child[:3, 3] = body.joint_in_parent[0, j] - shift
                if parent in done and child not in done:
                    world[p, child] = world[p, parent] @ parent_from_child
                    done.add(child)
                elif child in done and parent not in done:
                    world[p, parent] = world[p, child] @ np.linalg.inv(parent_from_child)
                    done.add(parent)
    return world[:, :, :3]


def point_segment(p, a, b):
    """Distance of a point to a line segment."""
    d = b - a
    t = np.clip((p - a) @ d / (d @ d), 0, 1) if d @ d > 0 else 0.0
    return np.linalg.norm(p - a - t * d)


def point_triangle(p, corners):
    """Distance of a point to a triangle: its plane where the foot is inside, else its nearest
    edge."""
    a, b, c = corners
    edges = min(point_segment(p, a, b), point_segment(p, b, c), point_segment(p, c, a))
    n = np.cross(b - a, c - a)
    if n @ n <= 1e-30:
        return edges
    foot = p - n * (n @ (p - a)) / (n @ n)
    sides = [np.cross(v - u, foot - u) @ n for u, v in ((a, b), (b, c), (c, a))]
    return min(edges, np.linalg.norm(p - foot)) if min(sides) >= 0 else edges


def winding(p, triangles):
    """Winding number of triangles about a point."""
    total = 0.0
    for corners in triangles:
        a, b, c = corners - p
        la, lb, lc = np.linalg.norm([a, b, c], axis=1)
        total += 2 * np.arctan2(
            a @ np.cross(b, c), la * lb * lc + (a @ b) * lc + (b @ c) * la + (c @ a) * lb
        )
    return total / (4 * np.pi)


def clearance(placed, environment):
    """Signed clearance (P, N, K) from every triangle of every part to every sphere."""
    body = placed.body
    out = np.full((len(placed), len(body.segments), len(environment.parts)), np.inf)
    corners = environment.vertices[environment.triangles]
    for p, n, k in np.ndindex(out.shape):
        polygons = environment.polygons(k)
        part = corners[
            environment.triangle_start[polygons.start] : environment.triangle_start[polygons.stop]
        ]
        rows = range(*body.spheres(n).indices(len(body.sphere_names)))
        if environment.hidden[k] or not len(part) or not rows:
            continue
        for s in rows:
            c = placed.centres[p, s]
            gap = min(point_triangle(c, t) for t in part)
            if environment.solid[k] and abs(winding(c, part)) > 0.5:
                gap = -gap
            out[p, n, k] = min(out[p, n, k], gap - body.radius[0, s])
    return out


def sphere_pairs(placed):
    """All overlapping sphere pairs of non-adjacent segments: {(pose, i, j): I}."""
    body = placed.body
    segment = body.sphere_segment
    found = {}
    for p in range(len(placed)):
        for i in range(len(body.sphere_names)):
            for j in range(i + 1, len(body.sphere_names)):
                gap = (
                    np.linalg.norm(placed.centres[p, i] - placed.centres[p, j])
                    - body.radius[0, i]
                    - body.radius[0, j]
                )
                if gap < -1e-9 and not body.adjacent[segment[i], segment[j]]:
                    found[p, i, j] = gap
    return found


def circle_touches_polygon(centre, radius, loops):
    """The paper's predicate in the plane: does a circle (2D) touch a polygon given as loops of
    corners (even-odd)?"""
    inside = False
    for loop in loops:
        for a, b in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            if point_segment(centre, a, b) < radius:
                return True
            if (a[1] > centre[1]) != (b[1] > centre[1]):
                crossing = (b[0] - a[0]) * (centre[1] - a[1]) / (b[1] - a[1]) + a[0]
                inside ^= bool(centre[0] < crossing)
    return inside


def on_the_way(body, way, steps):
    """A body placed at steps + 1 even times between two poses."""
    import workbench as wb

    start, end = (wb.join_poses([poses] * (steps + 1)) for poses in way)
    return wb.place(body, wb.between(start, end, np.linspace(0, 1, steps + 1)))


def first_below(distance, level):
    """(...) the first row of distance (T, ...) that is below a level, as a fraction of the way;
    infinite for none."""
    touch = distance < level
    return np.where(touch.any(axis=0), np.argmax(touch, axis=0), np.inf) / (len(distance) - 1)


def check_sweep(body, way, environment, found, *, steps):
    """First times (N, K) against dense sampling: never later, and touching where they say."""
    import workbench as wb

    distance = wb.clearance(on_the_way(body, way, steps), environment)
    sampled = first_below(distance, -1e-9)
    times = np.where(np.isnan(found), np.inf, found)
    assert np.all(times <= sampled + 2e-6), (times, sampled)
    for n, k in np.argwhere(np.isfinite(found)):
        # at the time found the surfaces meet; or the contact has begun
        near = wb.between(*way, min(found[n, k] + 1e-6, 1.0))
        gap = wb.clearance(wb.place(body, near), environment)[0, n, k]
        assert gap < 2e-5, (n, k, found[n, k], gap)
        assert sampled[n, k] >= found[n, k] - 2e-6
        before = distance[: int(np.ceil(found[n, k] * steps)), n, k]
        assert np.all(before > -1e-5)


def check_pair_sweep(body, way, other, own, *, steps):
    """First times of sphere pairs (S, S) with another pose of the body and with itself, against
    dense sampling."""
    import workbench as wb

    centres = on_the_way(body, way, steps).centres
    radii = body.radius[0, :, None] + body.radius[0, None]
    still = wb.place(body, other[1]).centres[0]
    segment = body.sphere_segment
    gaps = np.linalg.norm(centres[:, :, None] - still[None, None], axis=-1) - radii
    selves = np.linalg.norm(centres[:, :, None] - centres[:, None], axis=-1) - radii
    allowed = body.allowance[0, segment][:, segment]
    apart = np.triu(~body.adjacent)[segment][:, segment]
    for found, distance, level in (
        (other[0], gaps, 0.0),
        (own, np.where(apart, selves, np.inf), -allowed),
    ):
        sampled = first_below(distance, level - 1e-9)
        times = np.where(np.isnan(found), np.inf, found)
        assert np.all(times <= sampled + 2e-6)
        # not earlier than the step before, but for contacts that fall between two steps
        early = np.argwhere(times < sampled - 1.0 / steps - 2e-6)
        for s, v in early:
            here = wb.place(body, wb.between(*way, min(times[s, v] + 1e-6, 1.0))).centres[0]
            there = still if found is other[0] else here
            gap = np.linalg.norm(here[s] - there[v]) - radii[s, v]
            assert gap < np.broadcast_to(level, gaps.shape[1:])[s, v] + 2e-5


def check_episodes(body, motion, environment, found, *, steps):
    """Episodes by segment and part against dense sampling: what is sampled in contact lies in one
    of them, they begin and end where the surfaces meet, and nothing sampled is deeper."""
    import workbench as wb

    def frame(i):
        return wb.Poses(motion.rotations[[i]], motion.reference, motion.world_from_reference[[i]])

    pieces = [
        wb.clearance(on_the_way(body, (frame(i), frame(i + 1)), steps), environment)
        for i in range(len(motion) - 1)
    ]
    distance = np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])
    times = np.arange(len(distance)) / steps
    inside = np.zeros(distance.shape, dtype=bool)
    deep = np.full(distance.shape[1:], np.inf)
    for e in range(len(found)):
        n = found.segment[e]
        k = found.part[e]
        here = (times >= found.enter[e] - 2e-6) & (times <= found.leave[e] + 2e-6)
        inside[here, n, k] = True
        deep[n, k] = min(deep[n, k], found.distance[e])
        within = (times >= found.enter[e] + 2e-6) & (times <= found.leave[e] - 2e-6)
        assert np.all(distance[within, n, k] < 1e-5)
        assert found.distance[e] <= distance[within, n, k].min(initial=np.inf) + 1.1e-5
        at = wb.between(
            frame(found.frame[e]),
            frame(min(found.frame[e] + 1, len(motion) - 1)),
            found.deepest[e] - found.frame[e],
        )
        assert (
            abs(wb.clearance(wb.place(body, at), environment)[0, n, k] - found.distance[e]) < 1e-8
        )
    assert np.all(inside | ~(distance < -1e-9))
