"""Continuous contact of a motion: when each contact begins, is deepest, and ends."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from workbench.contact.advance import FINEST, Chase, Spans, contact_spans, deepest, whole_way
from workbench.contact.collide import allowed_depth
from workbench.contact.moving import Mover, check_times, pack_motion
from workbench.contact.sweep import Rule, body_chase, candidates, environment_chase, self_chase
from workbench.errors import InputError, UsageError, one_of
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.contacts import TANGENT_TOLERANCE, Episodes
from workbench.model.environment import Environment
from workbench.model.poses import Poses
from workbench.threads import in_pieces

__all__ = ["body_episodes", "episodes", "self_episodes"]

PIECE = 128
"""Pose pairs a thread takes at a time."""
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


def _packed(body: Body, motion: Poses, frames: slice, window: Iterable[str] | None) -> Mover:
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
            chase: Chase = chase,
            checked: Ints = checked,
            allowed: Floats = allowed,
            found: dict[int, _Spells] = found,
        ) -> None:
            who, level = candidates(chase, checked, allowed, begin, end)
            spans = contact_spans(chase, whole_way(chase, who, level))
            key = keys[0][spans.who[:, 1]] * width + keys[1][spans.who[:, 2]]
            found[begin] = _spells(chase, spans, key, first)

        in_pieces(work, len(chase.mover.first), PIECE, threads=threads)
        done += [found[begin] for begin in sorted(found)]
    spells = _Spells(
        *(np.concatenate([getattr(piece, name) for piece in done]) for name in _Spells._fields)
    )
    episode, enter, leave = _merged(spells.key, spells.begin, spells.end)
    order = np.lexsort((spells.who[:, 0] + spells.when, spells.best, episode))
    lead = order[np.concatenate([[True], np.diff(episode[order]) != 0])[: len(order)]]
    deep = spells.who[lead, 0] + spells.when[lead]
    return np.stack([enter, deep, leave], axis=1), spells.who[lead], spells.best[lead]


def _spells(chase: Chase, spans: Spans, key: Ints, first: int) -> _Spells:
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
