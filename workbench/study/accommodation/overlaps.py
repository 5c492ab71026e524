"""Overlaps of a population that no criterion asks about.

Who fits meets all that is asked. Whoever is deep in a part that no criterion names is still in it:
how many people are, and how deep, is said beside the shares, so that no green page hides it.

An overlap counts where it is deeper than is allowed with the true surface as far inside the spheres
as it may be. It is stated as deep as the spheres are.

For each segment the part that is entered deepest is looked for, then the deepest of the others,
until no more is found. What is known of a pair does not depend on who else is asked.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.contact.clearance_pairs import ClearancePair, clearance_of_pairs
from workbench.contact.collide import allowed_depth, allowed_in_oneself, self_contacts
from workbench.model.arrays import Bools, Floats, Ints
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.population import person_name
from workbench.model.result import PeopleOverlap
from workbench.study.situation import Situation, with_hands

__all__ = ["Overlaps", "join_overlaps", "overlap_warnings", "people_overlaps", "summed_overlaps"]

LEAST = 5e-5
"""[m] Overlaps that are deeper than allowed by less are not mentioned: they read as 0 mm."""
MOST_WORDS = 5
"""Pairs that have a sentence of their own."""


@dataclass(frozen=True, eq=False)
class Overlaps:
    """O overlaps that no criterion asks about.

    Parameters
    ----------
    pair
        (O, 4) the person, the segment, the part, -1 where it is the body itself, and then the other
        segment, else -1.
    depth
        (O,) [m] beyond what is allowed.
    """

    pair: Ints
    depth: Floats


def people_overlaps(situations: Sequence[Situation]) -> Overlaps:
    """Find the overlaps of B people, where they are in each case, that no criterion asks about.

    Parameters
    ----------
    situations
        The same people in each case, with their hands at rest.

    Returns
    -------
    Overlaps
        The deepest of all cases, by person and pair.
    """
    deepest: dict[tuple[int, int, int, int], float] = {}
    for situation in situations:
        there = with_hands(situation)
        for key, depth in (*_in_parts(there), *_in_oneself(there)):
            deepest[key] = max(depth, deepest.get(key, 0.0))
    keys = sorted(deepest)
    pair = np.array(keys, dtype=np.int64).reshape(-1, 4)
    return Overlaps(pair, np.array([deepest[key] for key in keys], dtype=np.float64))


def join_overlaps(parts: Sequence[Overlaps], people: Sequence[Ints]) -> Overlaps:
    """The overlaps of several groups, whose people have these numbers among all; by person."""
    pairs = [np.zeros((0, 4), dtype=np.int64)]
    for part, numbers in zip(parts, people, strict=True):
        pairs.append(np.column_stack([numbers[part.pair[:, 0]], part.pair[:, 1:]]))
    pair = np.concatenate(pairs)
    depth = np.concatenate([np.zeros(0), *(part.depth for part in parts)])
    order = np.lexsort(pair.T[::-1])
    return Overlaps(pair[order], depth[order])


def _asking(situation: Situation, check: str) -> list[Criterion]:
    """The criteria of a check that are asked of the people of a situation."""
    place = situation.place
    return [
        one
        for one in place.criteria
        if one.check == check and place.role in one.people and one.asks(situation.work.name)
    ]


def _unasked(situation: Situation) -> Bools:
    """(S, K) which spheres and visible parts no criterion asks about."""
    body = situation.body
    environment = situation.environment
    free = np.repeat(~environment.hidden[None], len(body.sphere_segment), axis=0)
    segments = np.array(body.segments)[body.sphere_segment]
    may = allowed_depth(body, environment)[body.sphere_segment] > 0
    for check in ("clearance", "contact"):
        for one in _asking(situation, check):
            parts = np.isin(environment.parts, one.parts)
            about = np.isin(body.subparts, one.subparts)
            measured = about[:, None] & parts
            if not one.subparts:
                measured = np.isin(segments, one.segments)[:, None] & parts
            if check == "clearance" and not one.subparts:
                measured &= ~may  # a clearance leaves out the pairs whose contact is allowed
            free &= ~measured
    return free


@dataclass(frozen=True, eq=False)
class _Group:
    """Spheres (S,) of a segment that share the parts (K,) that nothing asks about."""

    segment: int
    spheres: Bools
    parts: Bools


def _groups(body: Body, free: Bools) -> Iterator[_Group]:
    for segment in range(len(body.segments)):
        own = np.flatnonzero(body.sphere_segment == segment)
        rows, which = np.unique(free[own], axis=0, return_inverse=True)
        for k, parts in enumerate(rows):
            spheres = np.zeros(len(free), dtype=np.bool_)
            spheres[own[which.reshape(-1) == k]] = True
            if parts.any():
                yield _Group(segment, spheres, parts)


def _in_parts(there: Situation) -> Iterator[tuple[tuple[int, int, int, int], float]]:
    """By person, segment and part how deep [m] the segment is in the part."""
    error = np.nan_to_num(there.body.fit_error[there.placed.person][..., 1])
    groups = list(_groups(there.body, _unasked(there)))
    left = [group.parts.copy() for group in groups]
    entered: list[tuple[_Group, int]] = []
    while True:
        pairs = [
            ClearancePair(one.spheres, parts, True)
            for one, parts in zip(groups, left, strict=True)
            if parts.any()
        ]
        asked = [k for k, parts in enumerate(left) if parts.any()]
        if not asked:
            break
        distance, part = _nearest(there, pairs, error)
        more = False
        for q, k in enumerate(asked):
            for new in np.unique(part[distance[:, q] < -LEAST, q]).tolist():
                entered.append((groups[k], new))
                left[k][new] = False
                more = True
            if not np.any(distance[:, q] < -LEAST):
                left[k][:] = False
        if not more:
            break
    if not entered:
        return
    alone = np.eye(len(there.environment.parts), dtype=np.bool_)
    pairs = [ClearancePair(group.spheres, alone[part], True) for group, part in entered]
    distance, _ = _nearest(there, pairs, error)
    for person, q in np.argwhere(distance < -LEAST).tolist():
        group, k = entered[q]
        depth = float(error[person, group.segment] - distance[person, q])
        yield (person, group.segment, k, -1), depth


def _nearest(
    there: Situation, pairs: Sequence[ClearancePair], error: Floats
) -> tuple[Floats, Ints]:
    """(B, Q) [m] how far pairs are apart at most, beyond what is allowed, and the part of each."""
    found = clearance_of_pairs(
        there.placed,
        there.environment,
        pairs=pairs,
        moving_parts=there.place.moving_parts,
        displacement=there.displacement,
        growth=-error,
    )
    return found.distance, there.environment.polygon_part[found.polygon]


def _in_oneself(there: Situation) -> Iterator[tuple[tuple[int, int, int, int], float]]:
    """By person and two segments of the body how deep [m] one is in the other."""
    allowed = allowed_in_oneself(there.body)[there.placed.person]
    found = self_contacts(there.placed).deepest()
    names = there.body.segments
    asked = [set(one.segments) for one in _asking(there, "self_contact")]
    for row in np.flatnonzero(found.excess > LEAST).tolist():
        person = int(found.pose[row])
        one = int(found.segment[row])
        other = int(found.other_segment[row])
        sure = -float(found.distance[row]) - allowed[person, one, other]
        if sure > LEAST and not any({names[one], names[other]} & some for some in asked):
            yield (person, one, -1, other), float(found.excess[row])


def summed_overlaps(
    found: Overlaps, body: Body, environment: Environment, weight: Floats
) -> tuple[PeopleOverlap, ...]:
    """How many people have each overlap, and who is deepest; what most people have first.

    Parameters
    ----------
    weight
        (P,) of everybody.
    """
    rows = []
    kinds, which = np.unique(found.pair[:, 1:], axis=0, return_inverse=True)
    for k, (segment, part, other) in enumerate(kinds.tolist()):
        mine = np.flatnonzero(which.reshape(-1) == k)
        deepest = int(mine[np.argmax(found.depth[mine])])
        people = np.unique(found.pair[mine, 0])
        name = environment.parts[part] if part >= 0 else body.segment_names[other]
        rows.append(
            PeopleOverlap(
                segment=body.segment_names[segment],
                part=name if part >= 0 else "",
                other_segment="" if part >= 0 else name,
                people=len(people),
                share=float(weight[people].sum() / weight.sum()),
                deepest=float(found.depth[deepest]),
                person=int(found.pair[deepest, 0]),
            )
        )
    return tuple(sorted(rows, key=lambda one: (-one.people, -one.deepest, one.segment)))


def overlap_warnings(
    found: Sequence[PeopleOverlap], count: int, labels: Sequence[str] = ()
) -> Iterator[str]:
    """A sentence for each pair of names, what most people have first: "12 of 256 people: right upper
    leg in left_seat_pan, by up to 31 mm more than is allowed (person 12), about which no criterion
    asks". labels: what the people are called, by their rows where there are none."""
    for one in found[:MOST_WORDS]:
        where = one.part or f"their own {one.other_segment}"
        label = labels[one.person] if labels else str(one.person + 1)
        yield (
            f"{one.people} of {count} people: {one.segment} in {where}, by up to "
            f"{1000 * one.deepest:.0f} mm more than is allowed ({person_name(label)}), about which "
            "no criterion asks"
        )
    if len(found) > MOST_WORDS:
        yield (
            f"{len(found) - MOST_WORDS} more pairs overlap more than is allowed, about which no "
            "criterion asks: result.json has them all"
        )
