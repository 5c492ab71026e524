"""Reach envelopes about the seat reference point, as Kennedy measured them (AMRL-TR-77-50, 1978): of
one person, and of a share of people, ray by ray a percentile of how far they reach, as Kennedy's
tables are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from workbench.errors import UsageError
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body, check_one
from workbench.model.envelope import GRADES, Envelope, Losses, RayReach, ReachTask
from workbench.model.environment import Environment
from workbench.model.poses import Poses, check_rows, row_for_each
from workbench.model.study import Study
from workbench.posture.reaching.limbs import limb
from workbench.posture.reaching.obstacles import ObstacleScene
from workbench.posture.reaching.reach_solver import LimbTask
from workbench.study.envelope.asking import (
    Drawn,
    Rays,
    anchors,
    asked,
    check_step,
    drawn,
    level_rays,
    point_rays,
    ray_grid,
    rows_toward,
    solid_angles,
)
from workbench.study.envelope.clearing import cleared_from
from workbench.study.envelope.ends import Ends, Stations, cleared_stations, ray_ends, stations
from workbench.study.situation import Situation

__all__ = [
    "HALVINGS",
    "MOST_DISCOMFORT",
    "comfort_limit",
    "envelopes",
    "losses",
    "no_rays",
    "people_envelope",
    "reach_envelope",
    "situation_envelope",
]

STEP = 15
LEVELS = 0.15
"""Distance [m] of the level sections."""
TRIES = 8192
"""Postures drawn, of which those are kept that the stops allow."""
MOST_DISCOMFORT = (7.0, 28.0)
"""Greatest discomfort of the GRADES: what it is with each of an arm's seven angles at the end of
its comfortable range, and twice as far from the mode as that."""


def envelopes(study: Study, people: Sequence[Sequence[Situation]]) -> Iterator[Envelope]:
    """The envelopes that a study asks for, each from the posture of its case and about the
    reference point of the seat where it stands, or the shoulder.

    Parameters
    ----------
    people
        Of each person the cases that are postures.
    """
    for task in study.reach_envelopes:
        case = study.cases[task.case].name
        here = next(
            situation
            for mine in people
            for situation in mine
            if (situation.place.role, situation.work.name) == (task.person, case)
        )
        yield situation_envelope(here, task)


def situation_envelope(here: Situation, task: ReachTask) -> Envelope:
    """The envelope of a person in a case (B = 1), about the reference point of the seat where it
    stands; about the shoulder of who has none."""
    seat = here.place.own_seat
    grip = task.grip or None
    if seat is not None and here.seated is not None:
        origin = np.array(seat.srp) + here.seated.shift[0]
    else:
        chain = limb(here.body, task.limb, grip=grip, zone=task.zone)
        origin = anchors(asked(here.body, here.poses, chain))[0][0]
    found = reach_envelope(
        here.body,
        here.poses,
        origin,
        name=task.limb,
        grip=grip,
        zone=task.zone,
        environment=here.environment if task.obstacles else None,
        person=task.person,
    )
    return found if here.seated is not None else replace(found, origin_name="shoulder")


def reach_envelope(
    body: Body,
    poses: Poses,
    origin: ArrayLike,
    *,
    name: str,
    grip: str | None = None,
    zone: int = 1,
    environment: Environment | None = None,
    step: int = STEP,
    levels: bool = True,
    person: str = "",
) -> Envelope:
    """The reach envelope of a limb about an origin (3,) [m], from one pose.

    name, grip, zone: as for `limb`. environment: obstacles, which are heeded where one is given.
    step [deg]: of the grid, a divisor of 90. levels: whether level sections are found as well.
    InputError where the body lacks the landmarks of the grip.
    """
    check_one(body)
    check_step(step)
    chain = limb(body, name, grip=grip, zone=zone)
    centre = np.asarray(origin, dtype=np.float64)
    if centre.shape != (3,):
        raise UsageError(f"origin: expected a point (3,), got an array {centre.shape}")
    check_rows(poses, 1, "body")
    task = asked(body, poses, chain)
    postures = drawn(task, TRIES)
    direction, triangles = ray_grid(step)
    about = _ray_reach(task, point_rays(centre[None], direction, triangles), postures, environment)
    heights = _heights(about, centre) if levels else np.zeros(0)
    return Envelope(
        person=person,
        limb=chain.name,
        zone=zone,
        origin=centre,
        step=float(np.radians(step)),
        about=about,
        triangles=triangles,
        cell=solid_angles(direction, float(np.radians(step))),
        heights=heights,
        levels=_ray_reach(task, level_rays(centre, heights, step), postures, environment),
        obstacles=environment is not None,
        parts=environment.parts if environment is not None else (),
    )


def _heights(about: RayReach, origin: Floats) -> Floats:
    """(H,) [m] the heights of the level sections: whole steps from the origin, as far as anything
    is reached."""
    high = (about.outer * about.direction[:, 2])[about.reached]
    if not len(high):
        return np.zeros(0)
    first = np.ceil(high.min() / LEVELS)
    last = np.floor(high.max() / LEVELS)
    return LEVELS * np.arange(first, last + 1)


def _ray_reach(
    task: LimbTask, rays: Rays, postures: Drawn, environment: Environment | None
) -> RayReach:
    if not len(rays):
        return no_rays()
    ends = ray_ends(task, rays, postures)
    at = stations(task, rays, ends)
    none = np.zeros(0, dtype=np.int64)
    lost = Losses(none, np.zeros(0), np.zeros(0), none)
    clear = (ends.outer, ends.inner, ends.reached)
    if environment is not None and len(at):
        room = ObstacleScene(
            environment, np.zeros(len(environment.parts), dtype=np.int64), np.zeros((len(task), 3))
        )
        at = cleared_stations(at, room, postures)
        lost = losses(at, room)
        clear = _clear(ends, at, lost)
    grades = [comfort_limit(at, most) for most in MOST_DISCOMFORT]
    return RayReach(
        rays.origin,
        rays.direction,
        ends.outer,
        ends.inner,
        ends.reached,
        *clear,
        np.array([grade[0] for grade in grades]),
        np.array([grade[1] for grade in grades]),
        lost,
    )


def no_rays() -> RayReach:
    """What is reached along no rays at all."""
    none = np.zeros(0)
    whole = np.zeros(0, dtype=np.int64)
    flags = np.zeros(0, dtype=np.bool_)
    grades = np.zeros((len(GRADES), 0))
    return RayReach(
        np.zeros((0, 3)),
        np.zeros((0, 3)),
        none,
        none,
        flags,
        none,
        none,
        flags,
        grades,
        grades,
        Losses(whole, none, none, whole),
    )


def _clear(ends: Ends, at: Stations, lost: Losses) -> tuple[Floats, Floats, Bools]:
    """Outer and inner radius (R,) [m] of what is clear of obstacles, and whether anything is (R,);
    else as without."""
    outer = ends.outer.copy()
    inner = ends.inner.copy()
    good = np.flatnonzero(at.clear)
    clear = np.zeros(len(outer), dtype=np.bool_)
    clear[at.ray[good]] = True
    for bound, way, edges in ((outer, 1, lost.begin), (inner, -1, lost.end)):
        ray, first = np.unique(at.ray[good[::-way]], return_index=True)
        for k, station in zip(ray.tolist(), good[::-way][first].tolist(), strict=True):
            if at.place[station] == (at.count[k] - 1 if way > 0 else 0):
                continue
            gap = way * (edges - at.radius[station])
            next_to = (
                (lost.ray == k)
                & (gap >= 0)
                & (gap <= abs(at.radius[station + way] - at.radius[station]))
            )
            bound[k] = at.radius[station] + way * float(
                gap[next_to].min(initial=np.inf) if next_to.any() else 0.0
            )
    return outer, inner, clear


# What obstacles take of rays: runs of stations that are reached only through them, their ends
# found by halving; and how far reach is easy along a ray.

HALVINGS = 4
"""How often the stretch between a clear station and one that is not is halved."""


def losses(at: Stations, room: ObstacleScene) -> Losses:
    """The stretches of the rays that obstacles take, each known up to where the limb was found
    clear."""
    lost = at.reached & ~at.clear
    same = at.ray[1:] == at.ray[:-1]
    begins = lost & np.concatenate([[True], ~(same & lost[:-1])])
    ends = lost & np.concatenate([~(same & lost[1:]), [True]])
    head = np.flatnonzero(begins)
    tail = np.flatnonzero(ends)
    ray = at.ray[head]
    begin = at.radius[head].copy()
    end = at.radius[tail].copy()
    inner = at.place[head] == 0
    outer = at.place[tail] == at.count[ray] - 1
    for station, edge, way, whole in ((head, begin, -1, inner), (tail, end, 1, outer)):
        beside = np.clip(station + way, 0, len(at) - 1)
        clear = ~whole & at.clear[beside]
        # a stretch that nothing reaches, obstacles or not, shares the way with its neighbour
        middle = ~whole & ~clear
        edge[middle] = 0.5 * (at.radius[station] + at.radius[beside])[middle]
        rows = np.flatnonzero(clear)
        edge[rows] = _halved(at, room, beside[rows], station[rows])
    parts = [at.part[a : b + 1] for a, b in zip(head, tail, strict=True)]
    part = [int(np.bincount(p[p >= 0]).argmax()) if np.any(p >= 0) else -1 for p in parts]
    return Losses(ray, begin, end, np.array(part, dtype=np.int64).reshape(-1))


def _halved(at: Stations, room: ObstacleScene, clear: Ints, blocked: Ints) -> Floats:
    """(P,) [m] how far from clear stations (P,) toward blocked ones the limb comes clear."""
    good = at.radius[clear].copy()
    bad = at.radius[blocked].copy()
    angles = at.angles[clear].copy()
    rays = at.rays.rows(at.ray[clear])
    for _ in range(HALVINGS):
        if not len(good):
            break
        middle = 0.5 * (good + bad)
        some = rows_toward(at.task, clear, rays.at(middle))
        found, fine = cleared_from(some, angles, room)
        good = np.where(fine, middle, good)
        bad = np.where(fine, bad, middle)
        angles[fine] = found.angles[fine]
    return good


def comfort_limit(at: Stations, most: float) -> tuple[Floats, Floats]:
    """(R,) [m] the outermost and the innermost radius of each ray at which discomfort is no more
    than `most`, between stations in proportion; nan where there is none."""
    outer = np.full(len(at.rays), np.nan)
    inner = np.full(len(at.rays), np.nan)
    easy = at.reached & (at.discomfort <= most)
    for found, way in ((outer, 1), (inner, -1)):
        rows = np.flatnonzero(easy)[::-way]
        ray, first = np.unique(at.ray[rows], return_index=True)
        station = rows[first]
        beside = np.clip(station + way, 0, len(at) - 1)
        on = (at.ray[beside] == ray) & (beside != station) & at.reached[beside]
        rise = np.where(on, at.discomfort[beside] - at.discomfort[station], 1.0)
        share = np.where(
            on, np.clip((most - at.discomfort[station]) / np.maximum(rise, 1e-9), 0.0, 1.0), 0.0
        )
        found[ray] = at.radius[station] + share * (at.radius[beside] - at.radius[station])
    return outer, inner


TRIES_A_PERSON = 2048
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
        ends = ray_ends(
            task, point_rays(points[some], direction, triangles), drawn(task, TRIES_A_PERSON)
        )
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
