"""Contacts and clearance: spheres against spheres by the paper's three steps, spheres against
polygons exactly."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from functools import lru_cache, wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np

from workbench.body.forward import place
from workbench.contact.batches import (
    Groups,
    balls_of,
    clearance_by_part,
    grouped_clearance,
    grouped_collides,
    grouped_room,
    least_clearances,
    paired_clearance,
    pays,
    touching,
)
from workbench.contact.distance_fields import packed_faces
from workbench.contact.enclosure import deepen
from workbench.contact.kernels.clearance import ClearanceTask, near_sides
from workbench.contact.kernels.pairs import Balls, sphere_contacts
from workbench.errors import InputError, UsageError
from workbench.model.arrays import Bools, Floats, Ints, pieces
from workbench.model.body import Body, Topology, check_one
from workbench.model.contacts import TANGENT_TOLERANCE, Clearance, Contacts
from workbench.model.environment import Environment
from workbench.model.poses import Placed, Poses

__all__ = [
    "BLOCK",
    "allowed_depth",
    "allowed_groups",
    "allowed_in_oneself",
    "body_clearance",
    "body_contacts",
    "by_person",
    "clearance",
    "clearance_of_groups",
    "clearance_of_rows",
    "collides",
    "contacts",
    "nearest",
    "room",
    "room_of_poses",
    "self_clearance",
    "self_contacts",
]

_faces = packed_faces
HAIR = 1e-12
"""More [m] than the rounding of a depth."""
_ROOM = 1 << 16
"""Sphere pairs that there is room for at first."""
P = ParamSpec("P")
T = TypeVar("T")


def by_person(function: Callable[P, T]) -> Callable[P, T]:
    """Let a function of placed bodies with one row be asked of bodies with many.

    Its leading arguments that are Placed have as many poses each. Its answer is an array with a row
    for each pose, a noun of such arrays, or Contacts; it is the same to the last bit as that of the
    poses of each person alone.
    """

    @wraps(function)
    def call(*args: P.args, **options: P.kwargs) -> T:
        placed = [one for one in (*args, *options.values()) if isinstance(one, Placed)]
        if all(len(one.body) == 1 for one in placed) or len({len(one) for one in placed}) > 1:
            return function(*args, **options)
        if options.get("rows") is not None:
            raise UsageError("rows: expected None for a body of several rows; ask for one person")
        answers = []
        for rows, some in _people(placed):
            own = [some.get(id(value), value) for value in args]
            named = {name: some.get(id(value), value) for name, value in options.items()}
            answers.append((rows, function(*own, **named)))
        return _together(answers, placed)

    return call


def _people(placed: list[Placed]) -> Iterator[tuple[Ints, dict[int, Any]]]:
    """The numbers of the poses of the same people, and by the id of each that is placed these poses
    of it, with one row of its body."""
    people = np.stack([one.person for one in placed], axis=1)
    chosen, which = np.unique(people, axis=0, return_inverse=True)
    if not len(chosen):
        chosen = np.zeros((1, len(placed)), dtype=np.int64)
    for k, person in enumerate(chosen.tolist()):
        rows = np.flatnonzero(which.reshape(-1) == k)
        yield rows, {id(one): one.of_person(b, rows) for one, b in zip(placed, person, strict=True)}


def _together(answers: list[tuple[Ints, Any]], placed: list[Placed]) -> Any:
    """The answers as one, of all bodies."""
    first = answers[0][1]
    order = np.concatenate([rows for rows, _ in answers])
    back = np.argsort(order, kind="stable")
    if isinstance(first, np.ndarray):
        return np.concatenate([answer for _, answer in answers])[back]
    values = {
        field.name: np.concatenate([getattr(answer, field.name) for _, answer in answers])
        for field in fields(first)
        if isinstance(getattr(first, field.name), np.ndarray)
    }
    if isinstance(first, Contacts):
        values["pose"] = np.concatenate([rows[answer.pose] for rows, answer in answers])
        back = np.argsort(values["pose"], kind="stable")
    whole: dict[str, Any] = {name: array[back] for name, array in values.items()}
    bodies = {name: one.body for name, one in zip(("body", "other"), (placed * 2)[:2], strict=True)}
    for name, body in bodies.items():
        known = getattr(first, name, None)
        if known is not None and hasattr(known, "topology"):
            whole[name] = body
    return replace(first, **whole)


@by_person
def collides(
    placed: Placed,
    environment: Environment,
    *,
    tolerance: float = TANGENT_TOLERANCE,
    threads: int | None = None,
) -> Bools:
    """(P,) True where a pose overlaps a part by more than the part allows and `tolerance` [m].

    The same as asking it of all of `clearance`, but it stops at the first. Hidden parts and
    segments outside the logical window take no part. threads: all cores where None.

    Examples
    --------
    >>> import workbench as wb
    >>> trainer = wb.load_environment("trainer")
    >>> body = wb.load_body("bubbleman")
    >>> seated = {joint: {"flexion": 85} for joint in ("LH", "RH", "LK", "RK")}
    >>> poses = wb.pose(body, seated, reference="LT", position=(0.17, 0.28, 0.38))
    >>> placed = wb.place(body, poses)
    >>> wb.collides(placed, trainer)
    array([ True])
    """
    if not pays(placed):
        depth = allowed_depth(placed.body, environment) + tolerance
        deep = -clearance_by_part(placed, environment, most=HAIR - depth).distance > depth
        return np.asarray(np.any(deep, axis=(1, 2)))
    groups, columns = allowed_groups(placed.body, environment)
    return grouped_collides(placed, environment, groups, columns + tolerance, threads=threads)


@by_person
def contacts(
    placed: Placed,
    environment: Environment,
    *,
    margin: float = 0.0,
    tolerance: float = TANGENT_TOLERANCE,
) -> Contacts:
    """All (sphere, polygon) pairs that overlap, or lie nearer than `margin` [m], in all poses.

    A pair counts where its signed distance is below margin - tolerance: tangent spheres are not in
    contact. In a solid part a sphere whose centre is inside has one row with the nearest polygon
    and a distance that is negative all the way in. Rows are sorted by pose, sphere, part, polygon.
    Hidden parts are left out.

    Examples
    --------
    >>> import workbench as wb
    >>> trainer = wb.load_environment("trainer")
    >>> body = wb.load_body("bubbleman")
    >>> seated = {joint: {"flexion": 85} for joint in ("LH", "RH", "LK", "RK")}
    >>> poses = wb.pose(body, seated, reference="LT", position=(0.17, 0.28, 0.38))
    >>> placed = wb.place(body, poses)
    >>> worst = wb.contacts(placed, trainer).deepest()
    >>> print(worst.name(0), f"{1000 * worst.distance[0]:.0f} mm", worst.other_name(0))
    lower torso, pubis (bottom) -50 mm left_seat_pan, polygon 2
    """
    body = placed.body
    rows, numbers = touching(placed, environment, margin - tolerance)
    order = np.lexsort((rows[:, 3], rows[:, 2], rows[:, 1], rows[:, 0]))
    rows = rows[order]
    numbers = numbers[order]
    point = numbers[:, 1:4]
    inside = numbers[:, 4] > 0
    centre = placed.centres[rows[:, 0], rows[:, 1]]
    normal = _unit(
        np.where(inside[:, None], point - centre, centre - point), environment.normal[rows[:, 3]]
    )
    segment = body.sphere_segment[rows[:, 1]]
    none = np.full(len(rows), -1)
    return Contacts(
        body=body,
        other=environment,
        pose=rows[:, 0],
        sphere=rows[:, 1],
        part=rows[:, 2],
        polygon=rows[:, 3],
        other_sphere=none,
        distance=numbers[:, 0],
        point=point,
        normal=normal,
        facing=_facing(placed, (rows[:, 0], segment), -normal),
        other_facing=none,
        allowed=allowed_depth(body, environment)[segment, rows[:, 2]],
    )


@by_person
def self_contacts(
    placed: Placed, *, margin: float = 0.0, tolerance: float = TANGENT_TOLERANCE
) -> Contacts:
    """Sphere pairs of non-adjacent segments that overlap, or lie nearer than `margin` [m].

    Overlap about a common joint is legal and left to the joint stops; `allowed` carries the body's
    allowance for soft flesh, and a row is a fault where its excess is positive.

    Examples
    --------
    >>> import numpy as np
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> bowed = wb.place(body, wb.pose(body, {"RH": {"flexion": 150}}))
    >>> found = wb.self_contacts(bowed).deepest()
    >>> first = int(np.argmax(found.excess))
    >>> found.name(first), found.other_name(first)
    ('central torso (bottom)', 'right upper leg (front)')
    """
    body = placed.body
    one, other = np.nonzero(np.triu(~body.adjacent))
    both = placed.window[one] & placed.window[other]
    pairs = np.stack([one, other], axis=1)[both]
    return _sphere_rows(placed, placed, pairs, margin - tolerance, body.allowance[0])


@by_person
def body_contacts(
    one: Placed, other: Placed, *, margin: float = 0.0, tolerance: float = TANGENT_TOLERANCE
) -> Contacts:
    """Sphere pairs of two bodies that overlap, or lie nearer than `margin` [m]. Both hold the same
    number of poses.

    Any object made of spheres is such a body: one segment without joints will do.
    """
    pairs = _all_pairs(one, other)
    none = np.zeros((len(one.window), len(other.window)))
    return _sphere_rows(one, other, pairs, margin - tolerance, none)


@by_person
def clearance(placed: Placed, environment: Environment) -> Floats:
    """Signed clearance (P, N, parts) [m] of every segment to every part: negative is penetration
    depth.

    Infinite for hidden parts and segments without spheres, NaN outside the logical window.

    Examples
    --------
    >>> import workbench as wb
    >>> trainer = wb.load_environment("trainer")
    >>> body = wb.load_body("bubbleman")
    >>> seated = {joint: {"flexion": 85} for joint in ("LH", "RH", "LK", "RK")}
    >>> poses = wb.pose(body, seated, reference="LT", position=(0.17, 0.28, 0.38))
    >>> placed = wb.place(body, poses)
    >>> gaps = wb.clearance(placed, trainer)
    >>> gap = gaps[0, body.segments.index("H"), trainer.part_index("canopy")]
    >>> f"head to canopy: {1000 * gap:.0f} mm"
    'head to canopy: 76 mm'
    """
    distance = clearance_by_part(placed, environment).distance
    distance[:, ~placed.window] = np.nan
    return distance


@by_person
def clearance_of_groups(
    placed: Placed, environment: Environment, groups: Groups, *, grid: bool | None = None
) -> Floats:
    """Signed clearance (P, N, G) [m] of every segment to the nearest part of each group of shown
    parts.

    Infinite and NaN where `clearance` is. grid: whether to go through a grid of the groups, which
    is made if it is not there yet; where a batch is large enough for it if None.
    """
    if pays(placed) if grid is None else grid:
        distance = grouped_clearance(placed, environment, groups)[0]
    else:
        apart = clearance_by_part(placed, environment).distance
        distance = np.full((*apart.shape[:2], len(groups)), np.inf)
        for g, parts in enumerate(groups):
            distance[:, :, g] = apart[:, :, list(parts)].min(axis=2, initial=np.inf)
    distance[:, ~placed.window] = np.nan
    return distance


@by_person
def room(placed: Placed, environment: Environment, *, grid: bool | None = None) -> Floats:
    """Least signed clearance (P, N) [m] of every segment from all parts, the overlap that each part
    allows added: below zero is a fault.

    Infinite for segments without spheres, NaN outside the logical window. grid: as of
    `clearance_of_groups`.

    Examples
    --------
    >>> import workbench as wb
    >>> trainer = wb.load_environment("trainer")
    >>> body = wb.load_body("bubbleman")
    >>> seated = {joint: {"flexion": 85} for joint in ("LH", "RH", "LK", "RK")}
    >>> poses = wb.pose(body, seated, reference="LT", position=(0.17, 0.28, 0.38))
    >>> placed = wb.place(body, poses)
    >>> spare = wb.room(placed, trainer)[0]
    >>> body.segments[int(spare.argmin())], bool(spare.min() < 0)
    ('LUL', True)
    """
    groups, depth = allowed_groups(placed.body, environment)
    if pays(placed) if grid is None else grid:
        found: Floats = grouped_room(placed, environment, groups, depth).distance[:, :, 0]
    else:
        apart = clearance_by_part(placed, environment).distance
        apart += allowed_depth(placed.body, environment)
        found = apart.min(axis=2, initial=np.inf)
    found[:, ~placed.window] = np.nan
    return found


def clearance_of_rows(
    placed: Placed, environment: Environment, rows: Ints
) -> tuple[Floats, Ints, Ints, Floats]:
    """Signed clearance (R,) [m] of one segment to one part in one pose for each row (R, 3): pose,
    segment, part.

    With the sphere (R,), the polygon (R,) and its point (R, 3) [m] that are nearest; infinite, -1,
    -1 and NaN where the segment has no sphere or the part no polygon. Needs no grid: for few rows.
    """
    body = placed.body
    check_one(body)
    count = len(rows)
    out = (
        np.full(count, np.inf),
        np.full(count, -1),
        np.full(count, -1),
        np.full((count, 3), np.nan),
    )
    pairs, which = np.unique(rows[:, 1:], axis=0, return_inverse=True)
    for q, (n, k) in enumerate(pairs.tolist()):
        own = np.flatnonzero(which.reshape(-1) == q)
        centres = placed.centres[rows[own, 0]]
        bodies = centres, np.repeat(body.radius, len(own), axis=0), np.zeros((len(own), 3))
        spheres = np.arange(body.start[n], body.start[n + 1])
        task = ClearanceTask(
            spheres, np.array([0, len(spheres)]), np.array([[0, 0, k, 0]]), np.zeros(1)
        )
        found = least_clearances(bodies, task, environment, 1)
        for values, some in zip(out, found, strict=True):
            values[own] = some[:, 0]
    return out


@by_person
def nearest(
    placed: Placed, environment: Environment, *, rows: Ints | None = None, through: bool = False
) -> Clearance:
    """As `clearance`, with the spheres, polygons and points that are nearest.

    through: count depth where a body goes through a part that is no solid (`enclosure.deepen`).
    rows (R, 3): pose, segment, part; only these are looked for, and elsewhere is what holds for
    hidden parts.
    """
    if rows is None:
        found = clearance_by_part(placed, environment)
        if through:
            deepen(found, placed, environment)
        distance, sphere, polygon, point = found
    else:
        distance, sphere, polygon, point = _plain(placed, environment, rows)
    distance[:, ~placed.window] = np.nan
    return Clearance(
        placed.body,
        environment,
        distance,
        sphere,
        polygon,
        point,
        _near_side(placed, distance, sphere, point),
    )


def _plain(
    placed: Placed, environment: Environment, rows: Ints | None = None
) -> tuple[Floats, Ints, Ints, Floats]:
    """Distance, sphere, polygon (P, N, K) and point (P, N, K, 3) without grids, for small batches.

    rows (R, 3): pose, segment, part; all that are shown if None.
    """
    shape = (len(placed), len(placed.window), len(environment.parts))
    if rows is None:
        rows = np.argwhere(np.broadcast_to(np.outer(placed.window, ~environment.hidden), shape))
    out = (
        np.full(shape, np.inf),
        np.full(shape, -1),
        np.full(shape, -1),
        np.full((*shape, 3), np.nan),
    )
    for values, found in zip(out, clearance_of_rows(placed, environment, rows), strict=True):
        values[rows[:, 0], rows[:, 1], rows[:, 2]] = found
    return out


@by_person
def body_clearance(one: Placed, other: Placed) -> Clearance:
    """Signed clearance (P, N, M) [m] of every segment of one body to every segment of another, with
    the nearest spheres; `point` lies on the other's sphere.

    Examples
    --------
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> standing = wb.place(body, wb.pose(body, {}))
    >>> beside = wb.place(body, wb.pose(body, {}, position=(0, -1, 0)))
    >>> float(wb.body_clearance(standing, beside).distance.min().round(3))  # [m]
    0.457
    """
    return _pair_rows((one, other), _all_pairs(one, other))


@by_person
def self_clearance(placed: Placed) -> Clearance:
    """Signed clearance (P, N, N) [m] of all non-adjacent segment pairs of one body, each pair once
    (row < column); infinite elsewhere."""
    body = placed.body
    pairs = np.argwhere(np.triu(~body.adjacent) & np.outer(placed.window, placed.window))
    return _pair_rows((placed, placed), pairs)


def _pair_rows(placed: tuple[Placed, Placed], pairs: Ints) -> Clearance:
    one, other = placed
    return Clearance(one.body, other.body, *paired_clearance(one, other, pairs))


def allowed_depth(body: Body | Topology, environment: Environment) -> Floats:
    """(N, parts) [m] how deep each segment may be in each part: the environment's rules read for
    this body."""
    return _depth(tuple(body.segments), environment)


@lru_cache(maxsize=16)
def _depth(segments: tuple[str, ...], environment: Environment) -> Floats:
    depth = np.zeros((len(segments), len(environment.parts)))
    for rule in environment.allowances:
        for n, name in enumerate(segments):
            if name in rule.segments or "all" in rule.segments:
                depth[n, rule.part] = max(depth[n, rule.part], rule.depth)
    depth.flags.writeable = False
    return depth


def allowed_in_oneself(body: Body, *, flesh_alone: bool = False) -> Floats:
    """(B, N, N) [m] how deep segments of the same body may be in one another: by the allowance for
    soft flesh, and, unless that counts alone, as far as the true surfaces of both may be inside the
    spheres. Infinite of segments with a common joint."""
    error = np.nan_to_num(body.fit_error[..., 1]) * (not flesh_alone)
    depth: Floats = body.allowance + error[:, :, None] + error[:, None]
    depth[:, body.adjacent] = np.inf
    return depth


def allowed_groups(body: Body, environment: Environment) -> tuple[Groups, Floats]:
    """Parts that all segments may be equally deep in, as groups, and that depth (N, G) [m]; without
    hidden parts."""
    parts = np.flatnonzero(~environment.hidden)
    depth, which = np.unique(
        allowed_depth(body, environment)[:, parts], axis=1, return_inverse=True
    )
    which = which.reshape(-1)
    return tuple(tuple(parts[which == g].tolist()) for g in range(depth.shape[1])), depth


def _all_pairs(one: Placed, other: Placed) -> Ints:
    if len(one) != len(other):
        raise InputError(
            f"both bodies need the same number of poses, got {len(one)} and {len(other)}"
        )
    return np.argwhere(np.outer(one.window, other.window))


def _sphere_rows(
    one: Placed, other: Placed, pairs: Ints, margin: float, allowance: Floats
) -> Contacts:
    """Sphere pairs of segment pairs (M, 2) nearer than margin [m]; allowance (N, N') [m]."""
    rows, distance = _sphere_pairs(balls_of(one), balls_of(other), pairs, margin)
    order = np.lexsort((rows[:, 2], rows[:, 1], rows[:, 0]))
    rows = rows[order]
    distance = distance[order]
    a = one.centres[rows[:, 0], rows[:, 1]]
    b = other.centres[rows[:, 0], rows[:, 2]]
    normal = _unit(a - b, np.array([0.0, 0.0, 1.0]))
    segment = one.body.sphere_segment[rows[:, 1]]
    other_segment = other.body.sphere_segment[rows[:, 2]]
    none = np.full(len(rows), -1)
    return Contacts(
        body=one.body,
        other=other.body,
        pose=rows[:, 0],
        sphere=rows[:, 1],
        part=none,
        polygon=none,
        other_sphere=rows[:, 2],
        distance=distance,
        point=b + normal * other.body.radius[0][rows[:, 2], None],
        normal=normal,
        facing=_facing(one, (rows[:, 0], segment), -normal),
        other_facing=_facing(other, (rows[:, 0], other_segment), normal),
        allowed=allowance[segment, other_segment],
    )


def _sphere_pairs(one: Balls, other: Balls, pairs: Ints, margin: float) -> tuple[Ints, Floats]:
    """Rows (C, 3) and distances (C,) of `sphere_contacts`, searched again where they are many."""
    count = _ROOM
    while True:
        rows = np.empty((count, 3), dtype=np.int64)
        distance = np.empty(count)
        used = sphere_contacts(one, other, np.ascontiguousarray(pairs), margin, rows, distance)
        if used <= count:
            return rows[:used], distance[:used]
        count = used


def _facing(placed: Placed, where: tuple[Ints, Ints], direction: Floats) -> Ints:
    """(C,) the entry of the six-direction table nearest to a world direction (C, 3), by (pose,
    segment)."""
    pose, segment = where
    local = np.einsum("cji,cj->ci", placed.world_from_segment[pose, segment][..., :3], direction)
    return np.argmax(np.einsum("cdi,ci->cd", placed.body.directions[segment], local), axis=1)


def _near_side(placed: Placed, distance: Floats, sphere: Ints, point: Floats) -> Ints:
    """(P, N, K) the side of each nearest sphere that faces the point; inside a solid, the side away
    from it."""
    side = np.full(sphere.shape, -1)
    body = placed.body
    bodies = placed.centres, placed.world_from_segment, body.radius[0], body.directions
    near_sides(*bodies, distance, sphere, point, side)
    return side


def _unit(vector: Floats, spare: Floats) -> Floats:
    """Unit vectors; `spare` where a vector has no length to speak of."""
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.where(length > 1e-12, vector / np.maximum(length, 1e-300), spare)


# Questions of any number of poses: they are placed and asked block by block, so that memory holds
# the answers and one block.

BLOCK = 4096
"""Poses that are placed at a time."""


def room_of_poses(body: Body, poses: Poses, environment: Environment) -> Floats:
    """Compute the `room` of any number of poses, a million and more.

    Parameters
    ----------
    body
        The body.
    poses
        P poses.
    environment
        The environment.

    Returns
    -------
    Floats
        (P, N) [m], as `room` gives it for poses that are placed. Beside poses and answers it takes
        memory for 4,096 poses.
    """
    found = np.empty((len(poses), len(body.segments)))
    grid = pays(poses)
    for rows in pieces(len(poses), size=BLOCK):
        found[rows] = room(place(body, poses.rows(rows)), environment, grid=grid)
    return found
