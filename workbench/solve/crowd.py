"""The spheres of a body in clusters of neighbours, whose middle sphere speaks for all of them."""

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
    middle, reach, start = [], [], [0]
    for n in range(len(body.segments)):
        rows = np.arange(body.start[n], body.start[n + 1])
        for group in _split(body.centre, rows) if len(rows) else []:
            far = _reaches(body, n, group)
            best = int(np.argmin(far))
            member.append(group)
            middle.append(int(group[best]))
            reach.append(float(far[best]) * (1 + 1e-9) + 1e-12)
        start.append(len(middle))
    counts = [len(group) for group in member]
    return Crowd(
        radius=body.radius,
        start=np.array(start, dtype=np.int64),
        middle=np.array(middle, dtype=np.int64),
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


def _reaches(body: Body, n: int, rows: Ints) -> Floats:
    """(len(rows),) how far from each one's centre the spheres of the cluster extend, at every twist of segment n.

    Two spheres whose shares of the twist differ move against each other by at most the arc of the difference.
    """
    c, share = body.centre[rows], body.twist_share[rows]
    apart: Floats = np.linalg.norm(c[:, None] - c[None], axis=-1)
    if body.twist_joint[n] >= 0:
        axis, arm = body.twist_axis[n], c - body.twist_point[n]
        lever = np.linalg.norm(arm - np.outer(arm @ axis, axis), axis=1)
        arc = np.minimum(np.pi * np.abs(share[:, None] - share[None]), 2.0)
        apart = apart + arc * np.minimum(lever[:, None], lever[None])
    reach: Floats = (apart + body.radius[rows][None]).max(axis=1)
    return reach
