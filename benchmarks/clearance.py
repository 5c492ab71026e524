"""What collision and clearance cost: in the product's places, in made cockpits, for one pose, and
of an index. Every answer is checked on a sample against brute force."""

from __future__ import annotations

import itertools
import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from time import process_time
from unittest.mock import patch

import numpy as np

import workbench as wb
from benchmarks.cases import Case, in_cockpit, in_real_vehicle, seated_in
from benchmarks.table import Row
from benchmarks.timing import microseconds
from workbench.contact.collide import clearance_of_groups, collides, contacts, nearest, room
from workbench.model.arrays import Floats

__all__ = [
    "by_segment",
    "checked",
    "index_rows",
    "mesh_rows",
    "one_pose_rows",
    "place_rows",
]

PLACES = ("trainer", "compact_car")
NAMED = 100
"""Poses that are asked about with names, since that takes longest."""


def by_segment(case: Case) -> Floats:
    """(P, N, G) [m] clearance of each segment from each group of parts that permit the same."""
    return clearance_of_groups(case.placed, case.environment, case.groups)


def brute_force(points: Floats, corners: Floats) -> Floats:
    """(n,) distance of points (n, 3) to the nearest of triangles (T, 3, 3), one point at a time.

    Nothing clever: only triangles whose ball about their middle lies farther off than the nearest
    middle are left out.
    """
    middle = corners.mean(axis=1)
    around = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    out = np.empty(len(points))
    for i, x in enumerate(points):
        far = np.linalg.norm(x - middle, axis=1)
        out[i] = _distance(x, corners[far - around <= far.min() + 1e-9])
    return out


def _distance(x: Floats, corners: Floats) -> float:
    """Distance of a point to the nearest of triangles: their edges, and their planes over them."""
    side = np.roll(corners, -1, axis=1) - corners
    square = np.maximum((side**2).sum(-1), 1e-300)
    normal = np.cross(side[:, 0], side[:, 1])
    area = (normal**2).sum(-1)
    away = x - corners
    along = np.clip((away * side).sum(-1) / square, 0, 1)
    edges = ((away - along[..., None] * side) ** 2).sum(-1).min(axis=1)
    over = np.all((np.cross(side, away) * normal[:, None]).sum(-1) >= 0, axis=1)
    over &= area > 1e-30  # a needle or a point is its edges
    height = (away[:, 0] * normal).sum(-1) ** 2 / np.maximum(area, 1e-300)
    return float(np.sqrt(np.where(over, np.minimum(height, edges), edges).min()))


def winding(x: Floats, corners: Floats) -> float:
    """Winding number of triangles (T, 3, 3) about a point: the sum of their solid angles."""
    a, b, c = np.moveaxis(corners - x, 1, 0)
    p, q, r = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    below = p * q * r + (a * b).sum(1) * r + (b * c).sum(1) * p + (c * a).sum(1) * q
    return float(np.arctan2((a * np.cross(b, c)).sum(1), below).sum() / (2 * np.pi))


def _inside(x: Floats, corners: Floats) -> bool:
    """Whether a point is inside of triangles; outside of their box it is not."""
    boxed = np.all((x >= corners.min(axis=(0, 1))) & (x <= corners.max(axis=(0, 1))))
    return bool(boxed and abs(winding(x, corners)) > 0.5)


def segment_gap(case: Case, pose: int, segment: int, parts: Sequence[int]) -> float:
    """Clearance [m] of one segment from the nearest of some parts, by brute force."""
    environment = case.environment
    body = case.placed.body
    rows = body.spheres(segment)
    corners = environment.vertices[environment.triangles]
    ends = environment.triangle_start[environment.part_start]
    least = np.inf
    for k in parts:
        part = corners[ends[k] : ends[k + 1]]
        if not len(part):
            continue
        centres = case.placed.centres[pose, rows]
        gap = brute_force(centres, part)
        if environment.solid[k]:
            gap *= [-1.0 if _inside(c, part) else 1.0 for c in centres]
        least = min(least, float((gap - body.radius[0, rows]).min()))
    return least


def checked(case: Case, *, sample: int = 6) -> float:
    """Return the greatest error [m] of `by_segment` against brute force over a seeded sample, half
    of it where something touches.

    Raises
    ------
    ValueError
        If `collides` or `room` says something else than the clearances.
    """
    distance = by_segment(case)
    spare = (distance + case.allowed).min(axis=2)
    if not np.array_equal(collides(case.placed, case.environment), (spare < -1e-9).any(axis=1)):
        raise ValueError(f"{case.name}: `collides` and the clearances do not agree")
    if not np.array_equal(room(case.placed, case.environment), spare):
        raise ValueError(f"{case.name}: `room` and the clearances do not agree")
    rng = np.random.default_rng(3)
    known = np.argwhere(np.isfinite(distance))
    touching = np.argwhere(distance < 0)
    some = [rng.choice(known, min(sample, len(known)), replace=False)]
    if len(touching):
        some = [some[0][: sample - sample // 2], rng.choice(touching, sample // 2)]
    return max(
        abs(segment_gap(case, p, n, case.groups[g]) - distance[p, n, g])
        for p, n, g in np.concatenate(some)
    )


def place_rows(counts: Sequence[str], *, poses: int) -> Iterator[Row]:
    """Yield what is asked of somebody seated in the product's places, in permitted contact with
    solids, and in a real vehicle."""
    for place in PLACES:
        for count in counts:
            yield from _seated_rows(seated_in(place, count, poses))
    real = in_real_vehicle("957", poses)
    if real is None:
        yield Row("by segment", "real vehicle", None, "us", "its mesh is not among the inputs")
    else:
        yield from _seated_rows(real)


def _seated_rows(case: Case) -> Iterator[Row]:
    poses = len(case.placed)
    hits = collides(case.placed, case.environment)
    solid = int(case.environment.solid.sum())
    words = (
        f"{len(case.environment.triangles)} triangles, {len(case.environment.parts)} parts, {solid} "
        f"solid, {len(case.groups)} groups; error {1e3 * checked(case):.0e} mm"
    )
    took = microseconds(lambda: room(case.placed, case.environment), poses)
    yield Row("by segment, permitted contact", case.name, took, "us a pose", words)
    took = microseconds(lambda: by_segment(case), poses)
    words = "how deep, whether it is permitted or not"
    yield Row("by segment and by what is permitted", case.name, took, "us a pose", words)
    took = microseconds(lambda: collides(case.placed, case.environment), poses)
    yield Row("any", case.name, took, "us a pose", f"{hits.mean():.0%} are deeper than permitted")
    if not hits.all():
        free = case.few(np.flatnonzero(~hits))
        took = microseconds(lambda: collides(free.placed, free.environment), len(free.placed))
        yield Row("any, of the others", case.name, took, "us a pose", f"{len(free.placed)} poses")
    few = case.few(slice(0, NAMED))
    took = microseconds(lambda: nearest(few.placed, few.environment), len(few.placed))
    pairs = len(case.placed.body.segments) * len(case.environment.parts)
    words = f"{pairs} pairs, each with its sphere, polygon, point and side"
    yield Row("by segment and part, with names", case.name, took, "us a pose", words)


def mesh_rows(sizes: Sequence[str], counts: Sequence[str], *, poses: int) -> Iterator[Row]:
    """Yield what is asked of somebody in cockpits of curved and of flat faces, and how that grows
    with the mesh."""
    for kind in ("curved", "flat"):
        took: dict[tuple[str, str], float] = {}
        for size in sizes:
            for count in counts:
                case = in_cockpit(kind, size, count, poses)
                rows = list(_mesh_rows(case))
                yield from rows
                took[size, count] = rows[0].value or 0.0
        for count in counts:
            if ("2k", count) in took and ("500k", count) in took:
                ratio = took["500k", count] / took["2k", count]
                figure = "growth by segment, 2k to 500k"
                yield Row(figure, f"{kind}, {count} spheres", ratio, "times")


def _mesh_rows(case: Case) -> Iterator[Row]:
    poses = len(case.placed)
    polygons = len(case.environment.normal)
    words = f"{len(case.environment.triangles)} triangles, {polygons} polygons; "
    words += f"error {1e3 * checked(case):.0e} mm"
    took = microseconds(lambda: by_segment(case), poses)
    yield Row("by segment", case.name, took, "us a pose", words)
    hits = collides(case.placed, case.environment)
    took = microseconds(lambda: collides(case.placed, case.environment), poses)
    yield Row("any", case.name, took, "us a pose", f"{hits.mean():.0%} collide")
    found = len(contacts(case.placed, case.environment))
    took = microseconds(lambda: contacts(case.placed, case.environment), poses)
    yield Row("contacts", case.name, took, "us a pose", f"{found / poses:.0f} a pose")


def one_pose_rows(place: str, count: str, *, poses: int) -> Iterator[Row]:
    """Yield what one call about one pose takes, the Python around it included. No two calls in turn
    are about the same pose."""
    case = seated_in(place, count, poses)
    body = case.placed.body
    around = case.environment
    turn = itertools.cycle([case.few(slice(p, p + 1)) for p in range(poses)])
    work: dict[str, Callable[[Case], object]] = {
        "placed, one pose": lambda one: wb.place(body, one.poses),
        "clearance of all parts, one pose": lambda one: wb.clearance(
            wb.place(body, one.poses), around
        ),
        "clearance with names, one pose": lambda one: nearest(one.placed, around),
        "contacts, one pose": lambda one: wb.contacts(one.placed, around),
        "contacts with the body itself, one pose": lambda one: wb.self_contacts(one.placed),
        "any, one pose": lambda one: wb.collides(one.placed, around),
        "stops, one pose": lambda one: wb.stops(body, one.poses),
    }
    for figure, ask in work.items():
        took = microseconds(lambda ask=ask: ask(next(turn)))  # type: ignore[misc]
        yield Row(figure, case.name, 1e-3 * took, "ms a pose")


def index_rows(cases: Sequence[Case]) -> Iterator[Row]:
    """Yield what it takes to make the index that `by segment` asks, and to read it from disk: a
    first call less a second one."""
    for case in cases:
        name = case.name.split(",")[0]
        words = f"{len(case.environment.triangles)} triangles"
        with (
            tempfile.TemporaryDirectory() as folder,
            patch.dict(os.environ, {"WORKBENCH_CACHE": folder}),
        ):
            for figure in ("index made", "index read"):
                fresh = replace(case, environment=replace(case.environment))
                first = _once(fresh)
                yield Row(figure, name, max(first - _once(fresh), 0.0), "s", words)


def _once(case: Case) -> float:
    begin = process_time()
    by_segment(case)
    return process_time() - begin
