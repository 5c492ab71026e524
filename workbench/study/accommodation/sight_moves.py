"""By how much things must move for people to see what they miss.

What is seen of something jumps where an edge passes it, so that no derivative says how far a part
must go. Moves are tried instead: who misses something is asked again where he is, with a part, a
control or his seat farther and farther along a way. The first trial that meets says how far, or a
shorter one that meets too: halfway from the last that misses, or where a linear margin would meet.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from workbench.model.accommodation import MET, Change
from workbench.model.arrays import Floats, Ints
from workbench.model.surroundings import Move, parts_along
from workbench.study.accommodation.changes import changed
from workbench.study.accommodation.checkpoints import Chunk, PopulationQuestion
from workbench.study.accommodation.population_bodies import PopulationBodies
from workbench.study.accommodation.worst_cases import Found, found_situations
from workbench.study.checks.margins import Asked
from workbench.study.checks.table import CHECKS
from workbench.study.positions import in_positions
from workbench.study.settings import renewed
from workbench.study.situation import Occupants, Situation, with_hands

__all__ = ["SightMoves"]

TRIALS = (0.005, 0.01, 0.015, 0.02, 0.025, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1)
"""[m] How far things are moved."""
_STEP = 1e-3
"""[m] between the ways that are told."""
_FIRST = (0.025, 0.1)
"""The same of few people, to find the ways that help."""
_MOST_THINGS = 5
"""Things that are tried, at most: those that hide something from most people."""
_MOST_PEOPLE = 48
"""People who are asked, at most: evenly of all who miss nothing but what is seen."""
_FEW = 4
"""Of these, so many are asked along each way first: a way that helps none of them is tried no more."""


class SightMoves:
    """People who miss nothing but what they see, where they were found.

    columns: the requirements of what is seen that no gradient is known of; people: their rows.
    """

    def __init__(
        self, question: PopulationQuestion, bodies: PopulationBodies, found: Chunk
    ) -> None:
        self.question = question
        self.bodies = bodies
        self.found = found
        seen = np.array(
            [
                one.requirement.of_sight and one.requirement.check != "over_nose"
                for one in question.asked
            ]
        )
        missed = found.margin < -MET
        alone = missed[:, seen].any(axis=1) & ~missed[:, ~seen].any(axis=1)
        self.columns = np.flatnonzero(seen & missed[alone].any(axis=0))
        people = np.flatnonzero(alone)
        self.people = people[:: -(-len(people) // _MOST_PEOPLE) or 1]
        self.places = self._places(self.people)

    def _places(self, people: Ints) -> list[Found]:
        found = found_situations(self.question, self.bodies, people, self.found)
        return [(rows, [with_hands(one) for one in there]) for rows, there in found]

    def things(self) -> list[tuple[str, Move]]:
        """What may be moved, by name, as moves by nothing: the parts that hide most, and what is looked
        at."""
        environment = self.question.place.environment
        stay = {part for seat in environment.seats for part in (*seat.moves, *seat.parts)}
        count: Counter[tuple[str, tuple[str, ...], tuple[str, ...]]] = Counter()
        for r in self.columns.tolist():
            one = self.question.asked[r]
            short = self.people[self.found.margin[self.people, r] < -MET]
            own = _looked_at(self.question, one)
            if own is not None and not stay & set(own[1]):
                count[own] += len(short)
            for reason in self.found.reason[short, r].tolist():
                part = self.found.words[reason].part
                if part and part not in stay and (own is None or part not in own[1]):
                    count[part, (part,), ()] += 1
        most = count.most_common(_MOST_THINGS)
        return [
            (name, Move(parts, controls, (0.0, 0.0, 0.0))) for (name, parts, controls), _ in most
        ]

    def slope(self, move: Move) -> Floats:
        """(P, R) by how much margins grow with a metre of a move, or what stands for it of a turn; 0 where
        it does not do."""

        def moved(found: Found, amount: float) -> list[Situation]:
            place = changed(found[1][0].place, Change("", (move.times(amount),)))
            return [replace(one, place=place) for one in found[1]]

        # a mirror shows little ground: what it is turned by is not skipped
        few = self._slope(self._some(), moved, TRIALS if any(move.turn) else _FIRST)
        return self._slope(self.places, moved, TRIALS) if few.any() else few

    def _some(self) -> list[Found]:
        return [
            (rows[:_FEW], [one.rows(np.arange(min(_FEW, len(rows)))) for one in there])
            for rows, there in self.places
        ]

    def of_seat(self, way: Floats, at_end: Ints) -> Floats:
        """(P, R) the same of a seat that goes beyond its travel along a way (2,), of people (N,)."""

        def moved(found: Found, amount: float) -> list[Situation]:
            rows, there = found
            who = Occupants(self.bodies[rows], self.question.people, rows)
            return in_positions(there[0].place, who, self.found.seat[rows] + amount * way, there)

        return self._slope(self._places(np.intersect1d(at_end, self.people)), moved, _FIRST)

    def _slope(
        self,
        places: Sequence[Found],
        moved: Callable[[Found, float], list[Situation]],
        trials: Sequence[float],
    ) -> Floats:
        slope = np.zeros(self.found.margin.shape)
        for rows, there in places:
            at = np.ix_(rows, self.columns)
            before = self.found.margin[at]
            short = np.where(np.isnan(before), 0.0, before)
            last = 0.0
            for amount in trials:
                now = self._margins(moved((rows, there), amount))
                newly = (before < -MET) & (now >= -MET) & (slope[at] == 0.0)
                if newly.any():
                    share = (short[newly] / (short[newly] - now[newly])).max()
                    needed = np.full(before.shape, amount)
                    for part in (share, 0.5):
                        guess = _STEP * math.ceil((last + (amount - last) * part) / _STEP)
                        enough = self._margins(moved((rows, there), guess)) >= -MET
                        needed = np.where(enough, np.minimum(needed, guess), needed)
                    slope[at] += np.where(newly, -before / needed, 0.0)
                short, last = now, amount
        return slope

    def _margins(self, situations: Sequence[Situation]) -> Floats:
        """(B, len(columns)) what people have to spare as they sit."""
        asked = renewed(situations[0].place, [self.question.asked[r] for r in self.columns])
        found = np.zeros((len(situations[0]), len(asked)))
        for key in {(one.requirement.check, one.case) for one in asked}:
            mine = [q for q, one in enumerate(asked) if (one.requirement.check, one.case) == key]
            margins = CHECKS[key[0]].margins
            assert margins is not None
            found[:, mine] = margins(situations[key[1]], [asked[q] for q in mine]).margin
        return found


def _looked_at(
    question: PopulationQuestion, one: Asked
) -> tuple[str, tuple[str, ...], tuple[str, ...]] | None:
    """The name of what is looked at, or of a pillar, and its parts, or the control that goes without
    its part; None of what is no thing."""
    environment = question.place.environment
    name = one.requirement.target
    if one.criterion.controls:
        parts = parts_along(environment, (name,))
        return name, parts, () if parts else (name,)
    if one.criterion.instruments:
        return name, (environment.instrument(name).part,), ()
    if one.criterion.mirrors:
        return name, (environment.mirror(name).part,), ()
    if one.requirement.check == "sees" and one.criterion.parts:
        return name, (name,), ()
    return (name, one.criterion.parts, ()) if one.requirement.check == "pillar" else None
