"""Continuous contact: when a body first touches something on its way from one pose to another, and when
each contact of a motion begins, is deepest, and ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from workbench.contact.advance import (
    FINEST,
    SLACK,
    ContactQuery,
    Spans,
    contact_spans,
    deepest,
    first_contacts,
    whole_way,
)
from workbench.contact.collide import allowed_depth
from workbench.contact.continuous_contact import (
    BodyMotion,
    check_times,
    frames_of,
    joint_discontinuities,
    pack_motion,
    ways,
)
from workbench.contact.distance_fields import packed_parts
from workbench.contact.kernels.conservative_advancement import near_pairs, near_parts
from workbench.errors import InputError, UsageError, one_of
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.contacts import TANGENT_TOLERANCE, Episodes
from workbench.model.environment import Environment
from workbench.model.joint_angles import check_pairs
from workbench.model.poses import Poses
from workbench.threads import run_in_threads

__all__ = [
    "Rule",
    "body_chase",
    "body_episodes",
    "body_sweep",
    "candidates",
    "environment_chase",
    "episodes",
    "self_chase",
    "self_episodes",
    "self_sweep",
    "sweep",
]

Move = tuple[Body, Poses, Poses]
PIECE = 128
"""Pose pairs a thread takes at a time."""


def sweep(
    body: Body,
    way: tuple[Poses, Poses],
    environment: Environment,
    *,
    by: str = "segment",
    window: Iterable[str] | None = None,
    tolerance: float = TANGENT_TOLERANCE,
    threads: int | None = None,
) -> Floats:
    """Time of first contact on the way from one pose to another: the fraction 0 to 1 of it, NaN
    where there is none.

    way: P start and P end poses of the body; between them it moves as `between` says. A sphere is
    in contact where it is deeper in a part than the part's allowance and `tolerance` [m]; hidden
    parts take no part. by: "segment" gives (P, N), "part" (P, N, K), "sphere" (P, S), "sphere and
    part" (P, S, K).

    Times are exact to 1e-6 of the way. No contact that gets deeper than `tolerance` + 1e-9 m is
    missed, however fast the motion and thin the part: a time interval is passed over only where a
    bound proves it free (`kernels.contact.advance`, `kernels.contact.motion`). threads: all cores
    where None; no answer depends on it. UsageError for another `by`, InputError where the poses do
    not belong together.

    Examples
    --------
    >>> import numpy as np
    >>> import trimesh
    >>> import workbench as wb
    >>> body = wb.load_body("bubbleman")
    >>> way = wb.pose(body, {}), wb.pose(body, {}, position=(1, 0, 0))
    >>> board = trimesh.creation.box(bounds=[[0.85, -1, -2], [0.95, 1, 2]])
    >>> wall = wb.environment_from_mesh(board, up="z", forward="x", length="m")
    >>> float(np.nanmin(wb.sweep(body, way, wall)).round(3))  # share of the way
    0.642
    """
    start, end = way
    check_pairs(start, end)
    rows = _sphere_rows(body, by)
    parts = len(environment.parts)
    columns = np.arange(parts) if by.endswith("part") else np.zeros(parts, dtype=np.int64)
    frames, pairs = frames_of(start, end)
    rule = environment_chase(
        pack_motion(body, frames, pairs, window=window), environment, tolerance
    )
    first = _first(rule, (rows, columns), len(start), threads)
    return first[:, :, 0] if by in ("segment", "sphere") else first


def self_sweep(
    body: Body,
    way: tuple[Poses, Poses],
    *,
    by: str = "segment",
    window: Iterable[str] | None = None,
    tolerance: float = TANGENT_TOLERANCE,
    threads: int | None = None,
) -> Floats:
    """As `sweep`, for non-adjacent segments of one body against each other: (P, N, N), each pair
    once, row < column.

    by: "segment" or "sphere" (P, S, S). The body's allowance for soft flesh is no contact.
    """
    start, end = way
    check_pairs(start, end)
    rows = _sphere_rows(body, _pair_by(by))
    frames, pairs = frames_of(start, end)
    rule = self_chase(pack_motion(body, frames, pairs, window=window), tolerance)
    return _first(rule, (rows, rows), len(start), threads)


def body_sweep(
    one: Move,
    other: Move,
    *,
    by: str = "segment",
    tolerance: float = TANGENT_TOLERANCE,
    threads: int | None = None,
) -> Floats:
    """As `sweep`, for the segments of one body against those of another: (P, N, M); by "sphere":
    (P, S, S')."""
    movers = []
    rows = []
    for body, start, end in (one, other):
        check_pairs(start, end)
        movers.append(pack_motion(body, *frames_of(start, end)))
        rows.append(_sphere_rows(body, _pair_by(by)))
    if len(one[1]) != len(other[1]):
        raise InputError(
            f"both bodies need the same number of poses, got {len(one[1])} and {len(other[1])}"
        )
    rule = body_chase(movers[0], movers[1], tolerance)
    return _first(rule, (rows[0], rows[1]), len(one[1]), threads)


def _first(rule: Rule, index: tuple[Ints, Ints], pairs: int, threads: int | None) -> Floats:
    """(P, R, C) first times, of rows that spheres (S,) go to and columns that parts or spheres go
    to; NaN: none."""
    chase, checked, allowed = rule
    rows, columns = index
    wide = int(columns.max(initial=-1)) + 1
    first = np.full((pairs, int(rows.max(initial=-1)) + 1, wide), np.inf)

    def work(begin: int, end: int) -> None:
        who, level = candidates(chase, checked, allowed, begin, end)
        spans = whole_way(chase, who, level)
        row = rows[spans.who[:, 1]]
        column = columns[spans.who[:, 2]]
        key = ((spans.who[:, 0] - begin) * first.shape[1] + row) * wide + column
        first_contacts(chase, spans, key, first[begin:end].reshape(-1))

    run_in_threads(work, pairs, PIECE, threads=threads)
    first[np.isinf(first)] = np.nan
    return first


def _sphere_rows(body: Body, by: str) -> Ints:
    """(S,) the row of the answer each sphere goes to."""
    words = ("segment", "part", "sphere", "sphere and part")
    if by not in words:
        raise UsageError(f"by={by!r}: {one_of(by, words)}")
    return np.arange(len(body.sphere_names)) if by.startswith("sphere") else body.sphere_segment


def _pair_by(by: str) -> str:
    if by not in ("segment", "sphere"):
        raise UsageError(f"by={by!r}: {one_of(by, ('segment', 'sphere'))}")
    return by


# The three kinds of continuous contact: a moving body against an environment, another body, or
# itself; and which of its spheres may touch what, the broad phase.

Swept = tuple[Floats, Floats, Floats]
Rule = tuple[ContactQuery, Ints, Floats]
"""Who is after what; the parts (K,) that take part as 1, or the pairs of segments (Q, 2); depth
that is no contact."""


def environment_chase(mover: BodyMotion, environment: Environment, tolerance: float) -> Rule:
    """A body against the parts of an environment: hidden ones take no part, the others as deep as
    they allow."""
    checked = (~environment.hidden).astype(np.int64)
    allowed = allowed_depth(mover.body, environment) + tolerance
    return ContactQuery(mover, packed_parts(environment)), checked, allowed


def self_chase(mover: BodyMotion, tolerance: float) -> Rule:
    """The non-adjacent segments of one body, as deep in each other as its soft flesh allows."""
    body = mover.body
    shown = mover.placed.window
    pairs = np.argwhere(np.triu(~body.adjacent) & np.outer(shown, shown))
    return ContactQuery(mover, mover), pairs, body.allowance[0] + tolerance


def body_chase(one: BodyMotion, other: BodyMotion, tolerance: float) -> Rule:
    """All segments of one body against all of another."""
    pairs = np.argwhere(np.outer(one.placed.window, other.placed.window))
    return (
        ContactQuery(one, other),
        pairs,
        np.full((len(one.body.segments), len(other.body.segments)), tolerance),
    )


def candidates(
    chase: ContactQuery, checked: Ints, allowed: Floats, begin: int, end: int
) -> tuple[Ints, Floats]:
    """Who (M, 3) may touch in the pose pairs begin..end, and the level (M,) [m] of each.

    checked: 1 for the parts (K,) that take part, or the pairs of segments (Q, 2). allowed (N, K) or
    (N, N') [m]: depth that is no contact.
    """
    one = _swept(chase.mover, begin, end)
    segment = chase.mover.levers.segment
    radius = chase.mover.body.radius[0]
    if isinstance(chase.against, BodyMotion):
        other = chase.against
        who = near_pairs(one, _swept(other, begin, end), checked, allowed, SLACK)
        level = radius[who[:, 1]] + other.body.radius[0][who[:, 2]]
        level = level - allowed[segment[who[:, 1]], other.levers.segment[who[:, 2]]]
        keep = level > 0
    else:
        parts = chase.against
        who = near_parts(*one, parts, allowed, checked, SLACK)
        level = radius[who[:, 1]] - allowed[segment[who[:, 1]], who[:, 2]]
        # a surface cannot be deeper than the radius
        keep = (level > 0) | (parts.faces.solid[who[:, 2]] > 0)
    who[:, 0] += begin
    return who[keep], level[keep]


def _swept(mover: BodyMotion, begin: int, end: int) -> tuple[Swept, Swept, Ints]:
    """Enclosing spheres and spheres in pairs begin..end: where they begin and end, and how far
    their surfaces may be from the chord; and the spheres of each segment."""
    body = mover.body
    world = mover.placed.world_from_segment
    first = mover.first[begin:end]
    second = mover.second[begin:end]
    bound = mover.turns.bound[begin:end]
    around = []
    for frames in (first, second):
        turned = np.einsum("pnij,nj->pni", world[frames][..., :3], body.enclosing_centre[0])
        around.append(np.ascontiguousarray(turned + world[frames][..., 3]))
    entry = np.zeros((len(body.segments), 3))
    entry[mover.chain.to] = mover.chain.at_to
    arm = np.linalg.norm(body.enclosing_centre[0] - entry, axis=1)
    size = body.enclosing_radius[0] + 0.125 * (
        bound[..., 1] + (bound[..., 2] ** 2 + bound[..., 3]) * arm
    )
    size[:, ~mover.placed.window] = np.nan
    pairs = end - begin
    spheres = len(body.sphere_names)
    pair = np.repeat(np.arange(begin, end), spheres)
    sphere = np.tile(np.arange(spheres), pairs)
    way = ways(mover, pair, sphere, np.zeros(len(pair)), np.ones(len(pair)))
    way[joint_discontinuities(mover, pair, sphere) <= 1.0] = np.inf
    reach = way.reshape(pairs, spheres) + body.radius[0]
    moved = mover.placed.centres[first], mover.placed.centres[second]
    return (around[0], around[1], size * (1 + 1e-12) + 1e-9), (*moved, reach), body.start


MOST_PACKED = 32 * PIECE
"""Pose pairs that are packed at a time: some 50 MB of spheres."""


def episodes(
    body: Body,
    motion: Poses,
    environment: Environment,
    *,
    by: str = "segment",
    window: Iterable[str] | None = None,
    tolerance: float = TANGENT_TOLERANCE,
    threads: int | None = None,
) -> Episodes:
    """Every spell of contact of a motion with an environment: when it began, was deepest, and
    ended.

    motion: F frames, with `between` in between; time is `motion.time` [s], or the frames' numbers
    where it has none. by: "segment", an episode for each segment and part, or "sphere", for each
    sphere and part. Contact is what it is in `sweep`: deeper than the part's allowance and
    `tolerance` [m], and hidden parts take no part.

    Times are exact to 1e-6 of the time between two frames, the greatest depth to 1e-5 m; no contact
    that gets deeper than `tolerance` + 1e-9 m is missed, between frames neither. Two spells less
    than 2e-6 of a frame apart are one.
    """
    time, key = _checked(body, motion, by)

    def rule(frames: slice) -> Rule:
        return environment_chase(_packed(body, motion, frames, window), environment, tolerance)

    found = _found(rule, len(motion), (key, np.arange(len(environment.parts))), threads)
    who = found[1]
    allowed = allowed_depth(body, environment)[body.sphere_segment[who[:, 1]], who[:, 2]]
    none = np.full(len(who), -1)
    return _named(body, environment, time, found, allowed, (who[:, 2], none, none))


def self_episodes(
    body: Body,
    motion: Poses,
    *,
    by: str = "segment",
    window: Iterable[str] | None = None,
    tolerance: float = TANGENT_TOLERANCE,
    threads: int | None = None,
) -> Episodes:
    """As `episodes`, for the non-adjacent segments of one body, with its allowance for soft
    flesh."""
    time, key = _checked(body, motion, by)

    def rule(frames: slice) -> Rule:
        return self_chase(_packed(body, motion, frames, window), tolerance)

    found = _found(rule, len(motion), (key, key), threads)
    return _between_bodies(body, body, time, found, body.allowance[0])


def body_episodes(
    one: tuple[Body, Poses],
    other: tuple[Body, Poses],
    *,
    by: str = "segment",
    tolerance: float = TANGENT_TOLERANCE,
    threads: int | None = None,
) -> Episodes:
    """As `episodes`, for two bodies that move at the same times, each with its motion."""
    time, key = _checked(*one, by)
    other_time, other_key = _checked(*other, by)
    if len(time) != len(other_time) or not np.array_equal(time, other_time):
        raise InputError("both bodies' motions need the same frames at the same times")

    def rule(frames: slice) -> Rule:
        return body_chase(_packed(*one, frames, None), _packed(*other, frames, None), tolerance)

    found = _found(rule, len(time), (key, other_key), threads)
    none = np.zeros((len(one[0].segments), len(other[0].segments)))
    return _between_bodies(one[0], other[0], time, found, none)


Found = tuple[Floats, Ints, Floats]
"""Enter, deepest, leave (E, 3) in frames; who (E, 3): frame, sphere, part or other sphere; signed
distance (E,)."""


def _checked(body: Body, motion: Poses, by: str) -> tuple[Floats, Ints]:
    """The times (F,) of a motion, and the key (S,) by which its spheres' contacts belong
    together."""
    if by not in ("segment", "sphere"):
        raise UsageError(f"by={by!r}: {one_of(by, ('segment', 'sphere'))}")
    return check_times(motion), np.arange(
        len(body.sphere_names)
    ) if by == "sphere" else body.sphere_segment


def _packed(body: Body, motion: Poses, frames: slice, window: Iterable[str] | None) -> BodyMotion:
    some = motion.rows(frames)
    frame = np.arange(len(some) - 1)
    return pack_motion(body, some, (frame, frame + 1), window=window)


class _Spells(NamedTuple):
    """Spells of contact of some pose pairs: key (E,); begin, end (E,) in frames of the motion; who
    (E, 3) was deepest (pose pair of the motion, sphere, part or other sphere), when (E,) in that
    pair, and the signed distance (E,)."""

    key: Ints
    begin: Floats
    end: Floats
    who: Ints
    when: Floats
    best: Floats


def _found(
    rule: Callable[[slice], Rule], frames: int, keys: tuple[Ints, Ints], threads: int | None
) -> Found:
    """All episodes of a motion, by the keys of spheres and of parts or other spheres.

    MOST_PACKED pose pairs are packed at a time; each piece of PIECE pairs finds its own spells and
    how deep they are, so that neither threads nor how much is packed change a bit of the answer.
    Spells that go on are joined at the end.
    """
    done: list[_Spells] = []
    width = int(keys[1].max(initial=0)) + 1
    for first in range(0, frames - 1, MOST_PACKED):
        chase, checked, allowed = rule(slice(first, min(first + MOST_PACKED, frames - 1) + 1))
        found: dict[int, _Spells] = {}

        def work(
            begin: int,
            end: int,
            first: int = first,
            chase: ContactQuery = chase,
            checked: Ints = checked,
            allowed: Floats = allowed,
            found: dict[int, _Spells] = found,
        ) -> None:
            who, level = candidates(chase, checked, allowed, begin, end)
            spans = contact_spans(chase, whole_way(chase, who, level))
            key = keys[0][spans.who[:, 1]] * width + keys[1][spans.who[:, 2]]
            found[begin] = _spells(chase, spans, key, first)

        run_in_threads(work, len(chase.mover.first), PIECE, threads=threads)
        done += [found[begin] for begin in sorted(found)]
    spells = _Spells(
        *(np.concatenate([getattr(piece, name) for piece in done]) for name in _Spells._fields)
    )
    episode, enter, leave = _merged(spells.key, spells.begin, spells.end)
    order = np.lexsort((spells.who[:, 0] + spells.when, spells.best, episode))
    lead = order[np.concatenate([[True], np.diff(episode[order]) != 0])[: len(order)]]
    deep = spells.who[lead, 0] + spells.when[lead]
    return np.stack([enter, deep, leave], axis=1), spells.who[lead], spells.best[lead]


def _spells(chase: ContactQuery, spans: Spans, key: Ints, first: int) -> _Spells:
    """The spells of spans whose pose pairs count from `first` on."""
    pair = spans.who[:, 0] + first
    episode, enter, leave = _merged(key, pair + spans.one[:, 0], pair + spans.two[:, 0])
    best, who, when = deepest(chase, spans, episode, len(enter))
    who[:, 0] += first
    own = np.empty(len(enter), dtype=np.int64)
    own[episode] = key
    return _Spells(own, enter, leave, who, when, best)


def _merged(key: Ints, begin: Floats, end: Floats) -> tuple[Ints, Floats, Floats]:
    """The episode (M,) each spell belongs to, and when each of them begins and ends (E,) in frames.

    Spells of one key that overlap, or lie nearer than twice what times are exact to, are one
    episode.
    """
    order = np.lexsort((begin, key))
    key = key[order]
    begin = begin[order]
    end = end[order]
    # the latest end so far, key by key: the ends' ranks, each key with a stretch of ranks of its
    # own
    count = len(key)
    rank = np.empty(count, dtype=np.int64)
    rank[np.argsort(end, kind="stable")] = np.arange(count)
    other = np.concatenate([[True], np.diff(key) != 0])[:count]
    group = count * (np.cumsum(other) - 1)
    latest = np.sort(end)[np.maximum.accumulate(group + rank) - group]
    fresh = other.copy()
    fresh[1:] |= begin[1:] > latest[:-1] + 2.0 * FINEST
    episode = np.empty(count, dtype=np.int64)
    episode[order] = np.cumsum(fresh) - 1
    return episode, begin[fresh], np.maximum.reduceat(end, np.flatnonzero(fresh)) if count else end


def _between_bodies(
    body: Body, other: Body, time: Floats, found: Found, allowed: Floats
) -> Episodes:
    who = found[1]
    mine = body.sphere_segment[who[:, 1]]
    theirs = other.sphere_segment[who[:, 2]]
    none = np.full(len(who), -1)
    return _named(body, other, time, found, allowed[mine, theirs], (none, theirs, who[:, 2]))


def _named(
    body: Body,
    other: Body | Environment,
    time: Floats,
    found: Found,
    allowed: Floats,
    entered: tuple[Ints, Ints, Ints],
) -> Episodes:
    """The episodes of E spells of contact; allowed (E,) [m] is the depth that is no contact, entered
    the part (E,) of an environment, or the segment (E,) and sphere (E,) of a body, -1 where it is not
    that."""
    when, who, distance = found
    part, segment, sphere = entered
    at = np.interp(when, np.arange(len(time)), time)
    return Episodes(
        body=body,
        other=other,
        span=(float(time[0]), float(time[-1])),
        enter=at[:, 0],
        deepest=at[:, 1],
        leave=at[:, 2],
        distance=distance,
        allowed=allowed,
        segment=body.sphere_segment[who[:, 1]],
        sphere=who[:, 1],
        part=part,
        other_segment=segment,
        other_sphere=sphere,
        frame=np.floor(when[:, 1]).astype(np.int64),
    )
