"""Large batches against an environment: pieces of the poses on all cores, over grids that are made
once and kept."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from workbench.contact.distance_fields import (
    Groups,
    build_distance_field,
    packed_faces,
    packed_parts,
    packed_shells,
)
from workbench.contact.kernels.clearance import (
    ClearanceTask,
    Leads,
    min_clearances,
)
from workbench.contact.kernels.clearance_groups import (
    GroupSpace,
    SphereClusters,
    group_clearance,
    group_collides,
    group_room,
)
from workbench.contact.kernels.contacts import ContactRows, environment_contacts
from workbench.contact.kernels.pairs import Balls, PairAnswers, pair_clearance
from workbench.contact.kernels.parts import PartSpace, part_clearance
from workbench.contact.kernels.search import Nearest
from workbench.contact.kernels.wide_bvh import DEEP, EIGHT, search_space
from workbench.geometry.simd8 import LANES
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.environment import Environment
from workbench.model.kept import kept_with_body
from workbench.model.poses import Placed, Poses
from workbench.model.skinning import blend_point
from workbench.threads import run_in_threads

__all__ = [
    "Groups",
    "balls_of",
    "build_clusters",
    "clearance_by_part",
    "grouped_clearance",
    "grouped_collides",
    "grouped_room",
    "least_clearances",
    "nothing_near",
    "paired_clearance",
    "pays",
    "touching",
]

FEWEST_POSES = 64
"""To read grids from disk costs about as much as 64 poses without them; below, none is read."""
PIECE = 128
"""Poses a thread takes at a time."""
PEOPLE = 16
"""Poses of people, each of another body, that a thread takes at a time."""
BALLS = 4
"""Balls without surface that a search remembers."""
CONTACTS = 1024
"""Contacts a pose that there is room for; poses with more are searched twice."""


def pays(placed: Placed | Poses) -> bool:
    """True where a batch is large enough for the grids to pay."""
    return len(placed) >= FEWEST_POSES


def _space(crowd: SphereClusters, groups: Groups) -> GroupSpace:
    """Working space of one thread."""
    pairs = len(crowd.big) * len(groups)
    return GroupSpace(
        stack=np.empty(DEEP, dtype=np.int64),
        gaps=np.empty(DEEP + EIGHT, dtype=np.float32),
        lows=np.empty(max(len(crowd.middle), pairs)),
        low=np.empty(len(crowd.member)),
        pair=np.empty(pairs, dtype=np.int64),
        free=np.empty((BALLS, 4)),
        key=np.empty(len(groups)),
    )


def nothing_near(shape: tuple[int, ...]) -> Nearest:
    """Answers of a shape where nothing is near."""
    none = np.full((*shape, 3), np.nan)
    return Nearest(np.full(shape, np.inf), np.full(shape, -1), np.full(shape, -1), none)


def least_clearances(
    bodies: tuple[Floats, Floats, Floats],
    task: ClearanceTask,
    environment: Environment,
    pairs: int,
    *,
    threads: int | None = None,
) -> Nearest:
    """Signed distance [m], the overlap that is allowed added, sphere, polygon (P, Q) and its nearest
    point (P, Q, 3) of the Q pairs of a task.

    bodies: centres (P, S, 3) and radii (P, S) of the spheres [m], and the displacement (P, 3) [m] of
    the parts that move. Infinite, -1, -1 and NaN where there is nothing.
    """
    centres, radius, moved = bodies
    out = nothing_near((len(centres), pairs))
    parts = packed_parts(environment)

    def work(begin: int, end: int) -> None:
        leads = Leads(np.empty((pairs, 3), dtype=np.int64), np.empty(pairs))
        space = search_space()
        min_clearances(centres, radius, moved, task, parts, out, leads, space, begin, end)

    run_in_threads(work, len(centres), PEOPLE, threads=threads)
    return out


def _by_groups(
    kernel: Callable[..., None],
    placed: Placed,
    environment: Environment,
    groups: Groups,
    more: tuple[Any, ...],
    threads: int | None,
) -> None:
    """Have a loop over groups of parts fill the last of `more`, in pieces of the poses."""
    crowd = build_clusters(placed)
    solids = packed_faces(environment), packed_shells(environment)
    index = (crowd, *solids, build_distance_field(environment, groups))
    bodies = placed.centres, placed.world_from_segment

    def work(begin: int, end: int) -> None:
        kernel(*bodies, *index, *more, _space(crowd, groups), begin, end)

    run_in_threads(work, len(placed), PIECE, threads=threads)


def grouped_collides(
    placed: Placed,
    environment: Environment,
    groups: Groups,
    allowed: Floats,
    *,
    threads: int | None = None,
) -> Bools:
    """(P,) True where any sphere is deeper in a group of parts than allowed (N, G) [m] for its
    segment."""
    hit = np.zeros(len(placed), dtype=np.bool_)
    more = np.ascontiguousarray(allowed), hit
    _by_groups(group_collides, placed, environment, groups, more, threads)
    return hit


def grouped_clearance(
    placed: Placed, environment: Environment, groups: Groups, *, threads: int | None = None
) -> Nearest:
    """Signed distance [m], sphere, polygon (P, N, G) and its nearest point (P, N, G, 3) of every
    segment to every group of parts."""
    out = nothing_near((len(placed), len(placed.window), len(groups)))
    _by_groups(group_clearance, placed, environment, groups, (out,), threads)
    return out


def grouped_room(
    placed: Placed,
    environment: Environment,
    groups: Groups,
    allowed: Floats,
    *,
    threads: int | None = None,
) -> Nearest:
    """Least signed distance plus the overlap that is allowed (N, G) [m] of every segment over all
    groups, with the sphere, the polygon (P, N, 1) and its nearest point (P, N, 1, 3)."""
    out = nothing_near((len(placed), len(placed.window), 1))
    more = np.ascontiguousarray(allowed), out
    _by_groups(group_room, placed, environment, groups, more, threads)
    return out


def clearance_by_part(
    placed: Placed, environment: Environment, *, most: Floats | None = None
) -> Nearest:
    """Signed distance [m], sphere and polygon (P, N, K), and the polygon's nearest point
    (P, N, K, 3) of every segment to every part.

    Infinite, -1, -1 and NaN for hidden parts and segments without spheres or outside the logical
    window, and where the distance is not less than most (N, K) [m], if that is given.
    """
    crowd = build_clusters(placed)
    parts = packed_parts(environment)
    root = np.where(environment.hidden, -1, parts.trees.root)
    parts = parts._replace(trees=parts.trees._replace(root=root))
    pairs = len(placed.window), len(environment.parts)
    limit = np.full(pairs, np.inf) if most is None else np.ascontiguousarray(most)
    shape = len(placed), *pairs
    out = nothing_near(shape)
    bodies = placed.centres, placed.world_from_segment

    def work(begin: int, end: int) -> None:
        hubs = np.empty((len(crowd.middle), 3))
        space = PartSpace(hubs, *search_space())
        part_clearance(*bodies, crowd, parts, limit, out, space, begin, end)

    run_in_threads(work, len(placed), PIECE)
    return out


def paired_clearance(
    one: Placed, other: Placed, pairs: Ints, *, threads: int | None = None
) -> PairAnswers:
    """Least I [m] (P, N, N') of segment pairs (M, 2) of two bodies, the one's and the other's
    sphere that have it, the nearest point (P, N, N', 3) of the other's and the side of the one's
    that faces it (P, N, N').

    Elsewhere infinite, -1, -1, NaN, -1, and NaN for the distance outside the logical windows.
    """
    shape = (len(one), len(one.window), len(other.window))
    memory = np.empty(7 * int(np.prod(shape)))
    out = _answers(memory, shape)
    some = pairs[
        (np.diff(one.body.start)[pairs[:, 0]] > 0) & (np.diff(other.body.start)[pairs[:, 1]] > 0)
    ]
    some = np.ascontiguousarray(some)
    shown = one.window.astype(np.int64), other.window.astype(np.int64)
    first = balls_of(one)
    second = first if one is other else balls_of(other)
    bodies = first, second, one.world_from_segment, shown, some, one.body.directions

    def work(begin: int, end: int) -> None:
        heights = np.empty(len(first.radius)), np.empty(len(second.radius))
        front = np.empty(len(second.radius), dtype=np.int64)
        pair_clearance(*bodies, out, heights, front, begin, end)

    run_in_threads(work, len(one), PIECE, threads=threads)
    for values in (memory, *out):  # nobody else holds them: whoever takes them need not copy them
        values.flags.writeable = False
    return out


def balls_of(placed: Placed) -> Balls:
    """The spheres of a placed body of one row, and one around those of each segment."""
    body = placed.body
    world = placed.world_from_segment
    around = np.einsum("pnij,nj->pni", world[..., :3], body.enclosing_centre[0]) + world[..., 3]
    return Balls(
        placed.centres,
        body.radius[0],
        body.start,
        np.ascontiguousarray(around),
        body.enclosing_radius[0],
    )


def _answers(memory: Floats, shape: tuple[int, ...]) -> PairAnswers:
    """What `paired_clearance` fills, in one memory (7 n,): the system hands out a large one in
    larger pages."""
    count = len(memory) // 7
    distance, sphere, target, facing = memory[: 4 * count].reshape(4, *shape)
    whole = (values.view(np.int64) for values in (sphere, target, facing))
    point = memory[4 * count :].reshape(*shape, 3)
    return PairAnswers(distance, next(whole), next(whole), point, next(whole))


def touching(placed: Placed, environment: Environment, margin: float) -> tuple[Ints, Floats]:
    """Rows (C, 4) and numbers (C, 5) of `environment_contacts`, pose by pose."""
    crowd = build_clusters(placed)
    index = packed_parts(environment), (~environment.hidden).astype(np.int64)
    search = (placed.centres, placed.world_from_segment, crowd, *index, margin)
    found: dict[int, tuple[Ints, Floats]] = {}

    def work(begin: int, end: int) -> None:
        count = CONTACTS * (end - begin)
        while True:
            rows = ContactRows(np.empty((count, 4), dtype=np.int64), np.empty((count, 5)))
            used = environment_contacts(*search, rows, search_space(), begin, end)
            if used <= count:
                break
            count = used
        found[begin] = rows.row[:used], rows.number[:used]

    run_in_threads(work, len(placed), PIECE)
    pieces = [found[begin] for begin in sorted(found)] or [
        (np.zeros((0, 4), dtype=np.int64), np.zeros((0, 5)))
    ]
    return np.concatenate([rows for rows, _ in pieces]), np.concatenate(
        [numbers for _, numbers in pieces]
    )


# The spheres of a body in clusters of neighbours, each with a ball around all of them however the
# joints turn.

CLUSTER = LANES


def build_clusters(placed: Placed) -> SphereClusters:
    """The clusters of a placed body with its window; the clusters are made once a body."""
    return _crowd(placed.body)._replace(shown=placed.window.astype(np.int64))


@kept_with_body
def _crowd(body: Body) -> SphereClusters:
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
    return SphereClusters(
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
    return twists | ((body.blend_joint[rows] >= 0) & (body.blend_share[0, rows] > 0))


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
