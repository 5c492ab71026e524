"""The reach envelope of a share of people: ray by ray a percentile of how far they reach, as
Kennedy's tables are."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import UsageError
from workbench.model.arrays import Floats
from workbench.model.body import Body
from workbench.model.envelope import GRADES, Envelope, Losses, RayReach
from workbench.model.poses import Poses, row_for_each
from workbench.posture.reaching.limbs import limb
from workbench.study.envelope.asking import (
    asked,
    check_step,
    drawn,
    point_rays,
    ray_grid,
    solid_angles,
)
from workbench.study.envelope.ends import ray_ends
from workbench.study.envelope.envelope import no_rays

__all__ = ["people_envelope"]

TRIES = 2048
MOST = 64
"""People at a time."""


def people_envelope(
    body: Body,
    poses: Poses,
    origins: ArrayLike,
    *,
    name: str,
    percentile: float = 5.0,
    grip: str | None = None,
    zone: int = 1,
    step: int = 15,
) -> Envelope:
    """The envelope of B people, rows of a body and a row of poses each, about their seat reference
    points (B, 3) [m] or one (3,) for all, obstacles aside.

    percentile p (0 to 50): of every ray the outer boundary is the p-th percentile of the people's
    outer radii, the inner one the (100 - p)-th of their inner radii, both of somebody among them
    (the inverse of the distribution function); who reaches nothing along the ray counts as reaching
    nowhere. So 100 - p % of the people reach at least as far on any one ray; on all rays together
    fewer do, as nobody is at the same percentile everywhere. The origin is the mean of theirs.
    UsageError where numbers of rows do not fit, or for another percentile.
    """
    if not len(poses):
        raise UsageError("poses: expected one row at least, got none")
    people = row_for_each(body, poses)
    given = np.asarray(origins, dtype=np.float64)
    if given.shape not in ((3,), (len(poses), 3)):
        raise UsageError(
            f"origins: expected points (3,) or ({len(poses)}, 3), got an array {given.shape}"
        )
    points = np.broadcast_to(given, (len(poses), 3))
    if not 0.0 <= percentile <= 50.0:
        raise UsageError(f"a percentile of an envelope is 0 to 50, got {percentile}")
    check_step(step)
    direction, triangles = ray_grid(step)
    chain = limb(people, name, grip=grip, zone=zone)
    outer = np.zeros((len(poses), len(direction)))
    inner = np.full((len(poses), len(direction)), np.inf)
    for first in range(0, len(poses), MOST):
        some = slice(first, first + MOST)
        own = Poses(poses.rotations[some], poses.reference, poses.world_from_reference[some])
        task = asked(people[some], own, chain.rows(some))
        ends = ray_ends(task, point_rays(points[some], direction, triangles), drawn(task, TRIES))
        outer[some] = np.where(ends.reached, ends.outer, 0.0).reshape(len(task), -1)
        inner[some] = np.where(ends.reached, ends.inner, np.inf).reshape(len(task), -1)
    far = np.percentile(outer, percentile, axis=0, method="inverted_cdf")
    near = np.percentile(inner, 100.0 - percentile, axis=0, method="inverted_cdf")
    return _shared(percentile, zone, step, chain.name, points, far, near)


def _shared(
    percentile: float,
    zone: int,
    step: int,
    name: str,
    points: Floats,
    far: Floats,
    near: Floats,
) -> Envelope:
    """The envelope of people about points (B, 3) with these percentiles of radii (D,) [m]."""
    reached = far > near
    middle = points.mean(axis=0)
    direction, triangles = ray_grid(step)
    return Envelope(
        person=f"{percentile:g}th percentile of {len(points)} people",
        limb=name,
        zone=zone,
        origin=middle,
        step=float(np.radians(step)),
        about=_rays(middle, direction, (np.where(reached, far, 0.0), np.where(reached, near, 0.0))),
        triangles=triangles,
        cell=solid_angles(direction, float(np.radians(step))),
        heights=np.zeros(0),
        levels=no_rays(),
        obstacles=False,
        people=len(points),
    )


def _rays(origin: Floats, direction: Floats, ends: tuple[Floats, Floats]) -> RayReach:
    """Rays of a share of people: how far, with nothing said of ease and obstacles."""
    outer, inner = ends
    reached = outer > inner
    none = np.zeros(0, dtype=np.int64)
    unknown = np.full((len(GRADES), len(direction)), np.nan)
    return RayReach(
        np.tile(origin, (len(direction), 1)),
        direction,
        outer,
        inner,
        reached,
        outer,
        inner,
        reached,
        unknown,
        unknown,
        Losses(none, np.zeros(0), np.zeros(0), none),
    )
