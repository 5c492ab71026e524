"""Conservative advancement of many spheres at once: time intervals are decided by what is known at
both ends, or halved, until none is left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.contact.continuous_contact import BodyMotion, centres_at, joint_discontinuities, ways
from workbench.contact.kernels.conservative_advancement import (
    LOOK,
    possible_range,
    sample_distances,
)
from workbench.contact.kernels.search import Parts
from workbench.contact.kernels.wide_bvh import search_space
from workbench.model.arrays import Bools, Floats, Ints

__all__ = [
    "DEEP_ENOUGH",
    "FINEST",
    "ContactQuery",
    "Spans",
    "contact_spans",
    "deepest",
    "first_contacts",
    "whole_way",
]

FINEST = 2.0**-20
"""Shortest interval of a pose pair's time: contacts begin and end this exactly, better where the
way is straight."""
GRAZE = 2.0**-32
"""Shortest interval where a sphere only just does not touch."""
SLACK = 1e-9
"""[m] A contact that never gets deeper than this is not searched for."""
DEEP_ENOUGH = 1e-5
"""[m] How exact the greatest depth is."""


@dataclass(frozen=True, eq=False)
class ContactQuery:
    """Who moves, and against what: the parts of an environment, or the spheres of another mover."""

    mover: BodyMotion
    against: BodyMotion | Parts


@dataclass(frozen=True, eq=False)
class Spans:
    """M time intervals of spheres against their targets.

    who (M, 3): pose pair, sphere, and part or other sphere; level (M,) [m]: in contact where the
    signed distance of the centre is below it; far (M,) [m]: beyond this a distance need not be
    known; one, two (M, 8): looks at both ends.
    """

    who: Ints
    level: Floats
    far: Floats
    one: Floats
    two: Floats

    def __len__(self) -> int:
        return len(self.level)

    def rows(self, keep: Bools | Ints) -> Spans:
        """The intervals at a mask or at indices."""
        return Spans(
            self.who[keep], self.level[keep], self.far[keep], self.one[keep], self.two[keep]
        )


def whole_way(chase: ContactQuery, who: Ints, level: Floats) -> Spans:
    """The whole way of each sphere, in pieces where it jumps."""
    ends = []
    first = joint_discontinuities(chase.mover, who[:, 0], who[:, 1])
    second = np.full(len(who), 2.0)
    if isinstance(chase.against, BodyMotion):
        second = joint_discontinuities(chase.against, who[:, 0], who[:, 2])
    low = np.zeros(len(who))
    cuts = np.sort(np.stack([first, second], axis=1), axis=1)
    rows = np.arange(len(who))
    for cut in (cuts[:, 0], cuts[:, 1], np.full(len(who), 2.0)):
        high = np.clip(cut[rows] - 1e-12, low, 1.0)
        ends.append((rows, low, high))
        more = cut[rows] <= 1.0
        rows, low = rows[more], np.minimum(cut[rows[more]] + 1e-12, 1.0)
    index, begin, end = (np.concatenate([piece[i] for piece in ends]) for i in range(3))
    who = who[index]
    level = level[index]
    start = centres_at(chase.mover, who[:, 0], who[:, 1], begin)
    chord = np.linalg.norm(centres_at(chase.mover, who[:, 0], who[:, 1], end) - start, axis=1)
    far = np.maximum(level, 0.0) + 0.5 * chord + _ways(chase, who, begin, end) + 1e-6
    return Spans(who, level, far, _looks(chase, who, begin, far), _looks(chase, who, end, far))


def first_contacts(chase: ContactQuery, spans: Spans, key: Ints, first: Floats) -> None:
    """Lower first (K,) to the time at which a span of each key (M,) first touches."""
    while len(spans):
        here, there = _touching(spans)
        np.minimum.at(first, key[here], spans.one[here, 0])
        np.minimum.at(first, key[there], spans.two[there, 0])
        fine = ~here & there & (_lengths(spans) <= FINEST)
        np.minimum.at(first, key[fine], _crossing(spans.rows(fine)))
        open_ = ~here & ~fine & (spans.one[:, 0] < first[key])
        spans = spans.rows(open_)
        key = key[open_]
        least, _ = _possible(chase, spans)
        open_ = _touching(spans)[1] | ((least < spans.level - SLACK) & (_lengths(spans) > GRAZE))
        spans = _halves(chase, spans.rows(open_))
        key = np.concatenate([key[open_], key[open_]])


def contact_spans(chase: ContactQuery, spans: Spans) -> Spans:
    """The parts of spans that touch all along. Where one begins or ends with a contact, its look
    there is that of its other end with this time."""
    done = [spans.rows(np.zeros(0, dtype=np.int64))]
    while len(spans):
        here, there = _touching(spans)
        least, most = _possible(chase, spans)
        length = _lengths(spans)
        whole = here & there & ((most < spans.level) | (length <= FINEST))
        free = ~here & ~there & ((least >= spans.level - SLACK) | (length <= GRAZE))
        edge = (here != there) & (length <= FINEST)
        cut = spans.rows(edge)
        begins = there[edge]
        cross = _crossing(cut)
        touch = np.where(begins[:, None], cut.two, cut.one)
        one = touch.copy()
        two = touch.copy()
        one[begins, 0] = cross[begins]
        two[~begins, 0] = cross[~begins]
        done += [spans.rows(whole), Spans(cut.who, cut.level, cut.far, one, two)]
        spans = _halves(chase, spans.rows(~(whole | free | edge)))
    return Spans(
        *(
            np.concatenate([getattr(s, name) for s in done])
            for name in ("who", "level", "far", "one", "two")
        )
    )


def deepest(chase: ContactQuery, spans: Spans, key: Ints, keys: int) -> tuple[Floats, Ints, Floats]:
    """Least signed distance (K,) [m] of the surface of each key's spans, within DEEP_ENOUGH; who
    (K, 3) and when."""
    radius = _radii(chase, spans.who)
    best = np.full(keys, np.inf)
    when = np.zeros(keys)
    best_who = np.zeros((keys, 3), dtype=np.int64)
    while len(spans):
        for look in (spans.one, spans.two):
            depth = look[:, 4] - radius
            order = np.lexsort(
                (look[:, 0], spans.who[:, 2], spans.who[:, 1], spans.who[:, 0], depth, key)
            )
            lead = order[np.concatenate([[True], np.diff(key[order]) != 0])]
            lead = lead[depth[lead] < best[key[lead]]]
            best[key[lead]] = depth[lead]
            when[key[lead]] = look[lead, 0]
            best_who[key[lead]] = spans.who[lead]
        least, _ = _possible(chase, spans)
        open_ = (least - radius < best[key] - DEEP_ENOUGH) & (_lengths(spans) > FINEST)
        spans = _halves(chase, spans.rows(open_))
        key, radius = (np.concatenate([values[open_]] * 2) for values in (key, radius))
    return best, best_who, when


def _radii(chase: ContactQuery, who: Ints) -> Floats:
    """(M,) [m] what a centre's distance is lessened by."""
    radius: Floats = chase.mover.body.radius[0][who[:, 1]]
    if isinstance(chase.against, BodyMotion):
        radius = radius + chase.against.body.radius[0][who[:, 2]]
    return radius


def _lengths(spans: Spans) -> Floats:
    return spans.two[:, 0] - spans.one[:, 0]


def _touching(spans: Spans) -> tuple[Bools, Bools]:
    return spans.one[:, 4] < spans.level, spans.two[:, 4] < spans.level


def _crossing(spans: Spans) -> Floats:
    """(M,) the time at which the distance passes the level, between a look in contact and one that
    is not."""
    here = spans.one[:, 4] - spans.level
    there = spans.two[:, 4] - spans.level
    return spans.one[:, 0] + _lengths(spans) * here / (here - there)


def _ways(chase: ContactQuery, who: Ints, begin: Floats, end: Floats) -> Floats:
    way = ways(chase.mover, who[:, 0], who[:, 1], begin, end)
    if isinstance(chase.against, BodyMotion):
        way = way + ways(chase.against, who[:, 0], who[:, 2], begin, end)
    return way


def _possible(chase: ContactQuery, spans: Spans) -> tuple[Floats, Floats]:
    """Least and greatest signed distance (M,) [m] that is possible within each span."""
    way = _ways(chase, spans.who, spans.one[:, 0], spans.two[:, 0])
    least = np.empty(len(way))
    most = np.empty(len(way))
    possible_range(spans.one, spans.two, way, least, most)
    return least, most


def _halves(chase: ContactQuery, spans: Spans) -> Spans:
    """Each span as two: all first halves, then all second halves."""
    middle = _looks(chase, spans.who, 0.5 * (spans.one[:, 0] + spans.two[:, 0]), spans.far)
    who, level, far = (
        np.concatenate([values, values]) for values in (spans.who, spans.level, spans.far)
    )
    return Spans(
        who, level, far, np.concatenate([spans.one, middle]), np.concatenate([middle, spans.two])
    )


def _looks(chase: ContactQuery, who: Ints, time: Floats, far: Floats) -> Floats:
    """(M, 8) looks at a time."""
    looks = np.zeros((len(who), LOOK))
    looks[:, 0] = time
    pair, sphere, target = np.ascontiguousarray(who.T)
    if chase.against is chase.mover:
        # both spheres of one body at once: it is placed once for both
        both = centres_at(
            chase.mover, np.tile(pair, 2), np.concatenate([sphere, target]), np.tile(time, 2)
        )
        looks[:, 1:4] = both[: len(who)] - both[len(who) :]
    else:
        looks[:, 1:4] = centres_at(chase.mover, pair, sphere, time)
    if isinstance(chase.against, BodyMotion):
        if chase.against is not chase.mover:
            looks[:, 1:4] -= centres_at(chase.against, pair, target, time)
        looks[:, 4] = np.linalg.norm(looks[:, 1:4], axis=1)
    else:
        sample_distances(chase.against, target, far, looks, search_space())
    return looks
