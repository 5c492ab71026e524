"""Continuous contact of a motion: when each contact begins, is deepest, and ends."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from workbench.errors import InputError, UsageError, one_of
from workbench.model.arrays import Floats, Ints
from workbench.model.body import Body
from workbench.model.contacts import TANGENT_TOLERANCE
from workbench.model.environment import Environment
from workbench.model.episodes import Episodes
from workbench.model.poses import Poses
from workbench.solve.advance import FINEST, Spans, contact_spans, deepest, whole_way
from workbench.solve.chases import Rule, body_chase, environment_chase, self_chase
from workbench.solve.moving import Mover, check_times, pack_motion
from workbench.solve.nearby import candidates
from workbench.solve.threads import in_pieces

__all__ = ["body_episodes", "episodes", "self_episodes"]

PIECE = 128
"""Pose pairs a thread takes at a time."""


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
    """Every spell of contact of a motion with an environment: when it began, was deepest, and ended.

    motion: F frames, with `between` in between; time is `motion.time` [s], or the frames' numbers where it has none.
    by: "segment", an episode for each segment and part, or "sphere", for each sphere and part. Contact is what it is
    in `sweep`: deeper than the part's allowance and `tolerance` [m], and hidden parts take no part.

    Times are exact to 1e-6 of the time between two frames, the greatest depth to 1e-5 m; no contact that gets deeper
    than `tolerance` + 1e-9 m is missed, between frames neither. Two spells less than 2e-6 of a frame apart are one.
    """
    mover, time, key = _moving(body, motion, by, window)
    rule = environment_chase(mover, environment, tolerance)
    part = np.arange(len(environment.parts))
    found = _found(rule, (key, part), threads)
    who = found[1]
    allowed = rule[2][mover.levers.segment[who[:, 1]], who[:, 2]] - tolerance
    none = np.full(len(who), -1)
    return _named((body, environment), time, found, (allowed, who[:, 2], none, none))


def self_episodes(
    body: Body,
    motion: Poses,
    *,
    by: str = "segment",
    window: Iterable[str] | None = None,
    tolerance: float = TANGENT_TOLERANCE,
    threads: int | None = None,
) -> Episodes:
    """As `episodes`, for the non-adjacent segments of one body, with its allowance for soft flesh."""
    mover, time, key = _moving(body, motion, by, window)
    rule = self_chase(mover, tolerance)
    found = _found(rule, (key, key), threads)
    return _between_bodies((mover, mover), time, found, rule[2] - tolerance)


def body_episodes(
    one: tuple[Body, Poses],
    other: tuple[Body, Poses],
    *,
    by: str = "segment",
    tolerance: float = TANGENT_TOLERANCE,
    threads: int | None = None,
) -> Episodes:
    """As `episodes`, for two bodies that move at the same times, each with its motion."""
    mover, time, key = _moving(*one, by, None)
    second, other_time, other_key = _moving(*other, by, None)
    if len(time) != len(other_time) or not np.array_equal(time, other_time):
        raise InputError("both bodies' motions need the same frames at the same times")
    rule = body_chase(mover, second, tolerance)
    found = _found(rule, (key, other_key), threads)
    return _between_bodies((mover, second), time, found, rule[2] - tolerance)


Found = tuple[Floats, Ints, Floats]
"""Enter, deepest, leave (E, 3) in frames; who (E, 3): frame, sphere, part or other sphere; signed distance (E,)."""


def _moving(body: Body, motion: Poses, by: str, window: Iterable[str] | None) -> tuple[Mover, Floats, Ints]:
    """A motion packed, its times (F,), and the key (S,) by which its spheres' contacts belong together."""
    if by not in ("segment", "sphere"):
        raise UsageError(f"by={by!r}: {one_of(by, ('segment', 'sphere'))}")
    time = check_times(motion)
    frame = np.arange(len(motion) - 1)
    mover = pack_motion(body, motion, (frame, frame + 1), window=window)
    return mover, time, np.arange(len(body.radius)) if by == "sphere" else body.sphere_segment


def _found(rule: Rule, keys: tuple[Ints, Ints], threads: int | None) -> Found:
    """All episodes of a motion, by the keys of spheres and of parts or other spheres."""
    chase, checked, allowed = rule
    pieces: dict[int, Spans] = {}

    def work(begin: int, end: int) -> None:
        who, level = candidates(chase, checked, allowed, begin, end)
        pieces[begin] = contact_spans(chase, whole_way(chase, who, level))

    in_pieces(work, len(chase.mover.first), PIECE, threads=threads)
    done = [pieces[begin] for begin in sorted(pieces)]
    names = ("who", "level", "far", "one", "two")
    spans = Spans(*(np.concatenate([getattr(piece, name) for piece in done]) for name in names))
    key = keys[0][spans.who[:, 1]] * (int(keys[1].max(initial=0)) + 1) + keys[1][spans.who[:, 2]]
    episode, enter, leave = _merged(key, spans)
    best, who, when = deepest(chase, spans, episode, len(enter))
    return np.stack([enter, who[:, 0] + when, leave], axis=1), who, best


def _merged(key: Ints, spans: Spans) -> tuple[Ints, Floats, Floats]:
    """The episode (M,) each span belongs to, and when each of them begins and ends (E,) in frames.

    Spans of one key that overlap, or lie nearer than twice what times are exact to, are one episode.
    """
    begin, end = spans.who[:, 0] + spans.one[:, 0], spans.who[:, 0] + spans.two[:, 0]
    order = np.lexsort((begin, key))
    key, begin, end = key[order], begin[order], end[order]
    # the latest end so far, key by key: each key has a stretch of the line of its own
    group = np.cumsum(np.concatenate([[0], np.diff(key) != 0]))[: len(key)] * (end.max(initial=0.0) + 2.0)
    latest = np.maximum.accumulate(group + end)
    fresh = np.ones(len(key), dtype=np.bool_)
    fresh[1:] = (group + begin)[1:] > latest[:-1] + 2.0 * FINEST
    number = np.cumsum(fresh) - 1
    episode = np.empty(len(key), dtype=np.int64)
    episode[order] = number
    return episode, begin[fresh], np.maximum.reduceat(end, np.flatnonzero(fresh)) if len(key) else end


def _between_bodies(movers: tuple[Mover, Mover], time: Floats, found: Found, allowed: Floats) -> Episodes:
    who = found[1]
    one, other = movers[0].levers.segment[who[:, 1]], movers[1].levers.segment[who[:, 2]]
    part = np.full(len(who), -1)
    return _named((movers[0].body, movers[1].body), time, found, (allowed[one, other], part, other, who[:, 2]))


def _named(
    bodies: tuple[Body, Body | Environment], time: Floats, found: Found, other: tuple[Floats, Ints, Ints, Ints]
) -> Episodes:
    when, who, distance = found
    at = np.interp(when, np.arange(len(time)), time)
    allowed, part, other_segment, other_sphere = other
    return Episodes(
        body=bodies[0],
        other=bodies[1],
        span=(float(time[0]), float(time[-1])),
        enter=at[:, 0],
        deepest=at[:, 1],
        leave=at[:, 2],
        distance=distance,
        allowed=allowed,
        segment=bodies[0].sphere_segment[who[:, 1]],
        sphere=who[:, 1],
        part=part,
        other_segment=other_segment,
        other_sphere=other_sphere,
        frame=np.floor(when[:, 1]).astype(np.int64),
    )
