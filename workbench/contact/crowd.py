"""The spheres of a body in clusters of neighbours, each with a ball around all of them however the
joints turn."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from workbench.contact.kernels.groups import Crowd
from workbench.geometry.lanes import LANES
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.blend import blend_point
from workbench.model.body import Body
from workbench.model.kept import kept_with_body
from workbench.model.poses import Placed

__all__ = ["crowd_of"]

CLUSTER = LANES


def crowd_of(placed: Placed) -> Crowd:
    """The clusters of a placed body with its window; the clusters are made once a body."""
    return _crowd(placed.body)._replace(shown=placed.window.astype(np.int64))


@kept_with_body
def _crowd(body: Body) -> Crowd:
    member: list[Ints] = []
    middle = []
    hubs = []
    reach = []
    start = [0]
    for n in range(len(body.segments)):
        rows = np.arange(body.start[n], body.start[n + 1])
        member += _groups(body, rows)
        start.append(len(member))
    balls = _balls(body, member)
    for n, (a, b) in enumerate(pairwise(start)):
        for c in range(a, b):
            still = not np.any(_moves(body, member[c]))
            hub, far, best = (*balls[c], -1) if still else _middle(body, n, member[c])
            middle.append(best)
            hubs.append(hub)
            reach.append(far * (1 + 1e-9) + 1e-9)
    counts = [len(group) for group in member]
    return Crowd(
        radius=body.radius[0],
        start=np.array(start, dtype=np.int64),
        middle=np.array(middle, dtype=np.int64),
        hub=np.array(hubs).reshape(-1, 3),
        reach=np.array(reach),
        first=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        member=np.concatenate([np.zeros(0, dtype=np.int64), *member]),
        around=body.enclosing_centre[0],
        big=body.enclosing_radius[0] * (1 + 1e-9) + 1e-9,
        shown=np.ones(len(body.segments), dtype=np.int64),
    )


def _moves(body: Body, rows: Ints) -> Bools:
    """Which spheres move in the frame of their segment: they share a twist, or are blended across a
    joint."""
    twists = (body.twist_joint[body.sphere_segment[rows]] >= 0) & (body.twist_share[0, rows] > 0)
    moves: Bools = twists | ((body.blend_joint[rows] >= 0) & (body.blend_share[0, rows] > 0))
    return moves


def _groups(body: Body, rows: Ints) -> list[Ints]:
    """Clusters of a segment's spheres: alike in place, and in the joint and share they are blended
    by."""
    blended = np.where(body.blend_share[0, rows] > 0, body.blend_joint[rows], -1)
    found = []
    for joint in np.unique(blended):
        some = rows[blended == joint]
        arm = np.linalg.norm(body.centre[0, some] - blend_point(body)[0, some], axis=1)
        sway = 2.0 * body.blend_share[0, some] * arm.mean() if joint >= 0 else np.zeros(len(some))
        found += _split(np.column_stack([body.centre[0, some], sway]), some)
    return found


def _split(points: Floats, rows: Ints) -> list[Ints]:
    """Rows halved at the middle of the longest side of their points until none is longer than
    CLUSTER; sorted."""
    if len(rows) <= CLUSTER:
        return [np.sort(rows)]
    order = np.argsort(points[:, np.argmax(np.ptp(points, axis=0))], kind="stable")
    half = len(rows) // 2
    return [
        group for some in (order[:half], order[half:]) for group in _split(points[some], rows[some])
    ]


def _balls(body: Body, clusters: list[Ints]) -> list[tuple[Floats, float]]:
    """A small ball around the spheres of each cluster, its centre (3,) and radius: pulled toward the
    farthest sphere, ever less."""
    if not clusters:
        return []
    padded = np.array([np.pad(rows, (0, CLUSTER - len(rows)), mode="edge") for rows in clusters])
    centre = body.centre[0, padded]
    radius = body.radius[0, padded]
    every = np.arange(len(clusters))
    hub: Floats = 0.5 * (
        (centre - radius[..., None]).min(axis=1) + (centre + radius[..., None]).max(axis=1)
    )
    best = hub.copy()
    least = np.full(len(clusters), np.inf)
    for step in range(2, 100):
        far = np.linalg.norm(centre - hub[:, None], axis=2) + radius
        worst = np.argmax(far, axis=1)
        nearer = far[every, worst] < least
        best[nearer] = hub[nearer]
        least[nearer] = far[every, worst][nearer]
        hub = hub + (centre[every, worst] - hub) / step
    return list(zip(best, least.tolist(), strict=True))


def _middle(body: Body, n: int, rows: Ints) -> tuple[Floats, float, int]:
    """The sphere from whose centre the cluster extends least however the joints turn, and how far.

    Two spheres whose shares of the twist differ move against each other by at most the arc of the
    difference. Blended by v and w across one joint they stand at (1 - v) a + v Q a and (1 - w) b +
    w Q b from it, Q being some rotation: apart by at most |a - b| + 2 |v - w| |b|.
    """
    c = body.centre[0, rows]
    share = body.twist_share[0, rows]
    blend = body.blend_share[0, rows]
    joint = blend_point(body)[0, rows]
    apart: Floats = np.linalg.norm(c[:, None] - c[None], axis=-1)
    far = np.linalg.norm(c - joint, axis=1)
    if body.twist_joint[n] >= 0 and np.any(share > 0):
        lever, along = _about(body, n, c)
        arc = np.minimum(np.pi * np.abs(share[:, None] - share[None]), 2.0)
        apart = apart + arc * np.minimum(lever[:, None], lever[None])
        off, height = _about(body, n, joint)
        far = np.hypot(lever + off, along - height)
    apart = apart + 2.0 * np.abs(blend[:, None] - blend[None]) * np.minimum(far[:, None], far[None])
    reach = (apart + body.radius[0, rows][None]).max(axis=1)
    best = int(np.argmin(reach))
    return c[best], float(reach[best]), int(rows[best])


def _about(body: Body, n: int, points: Floats) -> tuple[Floats, Floats]:
    """Distance (n,) of points from the line that segment n twists about, and place (n,) along it
    [m]."""
    arm = points - body.twist_point[0, n]
    along = arm @ body.twist_axis[0, n]
    return np.linalg.norm(arm - np.outer(along, body.twist_axis[0, n]), axis=1), along
