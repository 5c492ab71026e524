"""The spheres of a body in clusters of neighbours, each with a ball around all of them at every twist."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from workbench.kernels.groups import Crowd
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.poses import Placed

__all__ = ["crowd_of"]

CLUSTER = 8


def crowd_of(placed: Placed) -> Crowd:
    """The clusters of a placed body with its window; the clusters are made once a body."""
    return _crowd(placed.body)._replace(shown=placed.window.astype(np.int64))


@lru_cache(maxsize=16)
def _crowd(body: Body) -> Crowd:
    member: list[Ints] = []
    middle, hubs, reach, start = [], [], [], [0]
    for n in range(len(body.segments)):
        rows = np.arange(body.start[n], body.start[n + 1])
        for group in _split(body.centre, rows) if len(rows) else []:
            rigid = body.twist_joint[n] < 0 or not np.any(body.twist_share[group] > 0)
            hub, far, best = _ball(body, group) if rigid else _middle(body, n, group)
            member.append(group)
            middle.append(best)
            hubs.append(hub)
            reach.append(far * (1 + 1e-9) + 1e-9)
        start.append(len(middle))
    counts = [len(group) for group in member]
    return Crowd(
        radius=body.radius,
        start=np.array(start, dtype=np.int64),
        middle=np.array(middle, dtype=np.int64),
        hub=np.array(hubs).reshape(-1, 3),
        reach=np.array(reach),
        first=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
        member=np.concatenate([np.zeros(0, dtype=np.int64), *member]),
        around=body.enclosing_centre,
        big=body.enclosing_radius * (1 + 1e-9) + 1e-9,
        shown=np.ones(len(body.segments), dtype=np.int64),
    )


def _split(centre: Floats, rows: Ints) -> list[Ints]:
    """Rows halved at the middle of their longest side until no piece is longer than CLUSTER; sorted within."""
    if len(rows) <= CLUSTER:
        return [np.sort(rows)]
    points = centre[rows]
    order = rows[np.argsort(points[:, np.argmax(np.ptp(points, axis=0))], kind="stable")]
    half = len(rows) // 2
    return _split(centre, order[:half]) + _split(centre, order[half:])


def _ball(body: Body, rows: Ints) -> tuple[Floats, float, int]:
    """A small ball around spheres, its centre (3,), radius, and -1: pulled toward the farthest sphere, ever less."""
    centre, radius = body.centre[rows], body.radius[rows]
    hub: Floats = 0.5 * ((centre - radius[:, None]).min(axis=0) + (centre + radius[:, None]).max(axis=0))
    best, least = hub, np.inf
    for step in range(2, 100):
        far = np.linalg.norm(centre - hub, axis=1) + radius
        worst = int(np.argmax(far))
        if far[worst] < least:
            best, least = hub, float(far[worst])
        hub = hub + (centre[worst] - hub) / step
    return best, least, -1


def _middle(body: Body, n: int, rows: Ints) -> tuple[Floats, float, int]:
    """The sphere from whose centre the cluster extends least at every twist of segment n, and how far.

    Two spheres whose shares of the twist differ move against each other by at most the arc of the difference.
    """
    c, share = body.centre[rows], body.twist_share[rows]
    apart: Floats = np.linalg.norm(c[:, None] - c[None], axis=-1)
    if body.twist_joint[n] >= 0:
        axis, arm = body.twist_axis[n], c - body.twist_point[n]
        lever = np.linalg.norm(arm - np.outer(arm @ axis, axis), axis=1)
        arc = np.minimum(np.pi * np.abs(share[:, None] - share[None]), 2.0)
        apart = apart + arc * np.minimum(lever[:, None], lever[None])
    far = (apart + body.radius[rows][None]).max(axis=1)
    best = int(np.argmin(far))
    return c[best], float(far[best]), int(rows[best])
