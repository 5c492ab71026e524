"""What a change of the design gains: of those asked for, or of those that the margins propose; each
confirmed by a run with the change made."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.model.accommodation import MET, Change, DesignChange, met_of
from workbench.model.arrays import Bools, Floats
from workbench.model.criterion import NO_REASON
from workbench.model.result import ChangedPerson, TriedChange
from workbench.model.surroundings import moved_controls
from workbench.study.accommodation.changes import (
    affected_requirements,
    changed,
    enters,
    enters_words,
    moved_parts,
)
from workbench.study.accommodation.checkpoints import (
    Chunk,
    PopulationQuestion,
    joined_chunks,
    result_chunks,
)
from workbench.study.accommodation.population_bodies import PopulationBodies
from workbench.study.accommodation.proposals import growth, proposals
from workbench.study.accommodation.shares import share_single
from workbench.study.accommodation.worst_cases import found_situations, shown_people
from workbench.study.checks.table import most_of
from workbench.study.passes import CHANGE, Passes
from workbench.study.positions import WITHIN_NEIGHBOURS, Before
from workbench.study.settings import nominal_setting, renewed
from workbench.study.situation import with_clear_legs

__all__ = ["MOST_GAINS", "Gains", "changed_question", "gains_of"]

MOST_GAINS = 3
MOST_TRIES = 5
"""Changes that are proposed, and tried for that: one that gains nothing after all is not
proposed."""
ASKED_FIRST = 16
"""People of whom it is asked first whether a change does what it should."""
ARMS = frozenset(("LSM", "RSM", "LUA", "RUA", "LLA", "RLA", "LHN", "RHN"))
"""The segments that go along with hands."""
NEAR = 5e-3
"""Half the move [m] over which the rate of a gain is taken."""


@dataclass(frozen=True, eq=False)
class Gains:
    """Changes that were tried, and in words those that are not proposed since they would put a part
    into another one."""

    tried: tuple[TriedChange, ...]
    refused: tuple[str, ...] = ()


def gains_of(
    question: PopulationQuestion,
    changes: Sequence[Change],
    bodies: PopulationBodies,
    found: Chunk,
    *,
    keep: Path | None,
    passes: Passes,
    executor: Executor | None = None,
) -> Gains:
    """The gains of changes that are asked for, or else of proposals that let more people meet
    everything; where nobody does without and with them, that let more meet what they are proposed for."""

    def tried(change: Change, at: int | None, other: PopulationQuestion, limit: str) -> TriedChange:
        tell = passes.begin(CHANGE, f"trying {change.words}")
        then = joined_chunks(result_chunks(other, bodies, keep=keep, tell=tell, executor=executor))
        rows = affected_requirements(question.place, question.asked, change) if at is None else at
        gain = replace(_compared(question, found, then.margin, change, rows), limit=limit)
        both = ((question, found), (other, then))
        return _with_person(gain, both, bodies)

    asked = []
    for one in changes:
        into = enters(question.place, one)
        limit = "" if into is None else enters_words("it", into)
        asked.append(tried(one, None, changed_question(question, found, one), limit))
    if changes:
        return Gains(tuple(asked))
    good: list[TriedChange] = []
    refused: list[str] = []
    count = 0
    for proposal in proposals(question, bodies, found):
        if (change := proposal.change) is None:
            refused.append(proposal.limit)
            continue
        count += 1
        other = changed_question(question, found, change)
        if _holds(question, other, bodies, found, proposal.served):
            made = tried(change, proposal.requirement, other, proposal.limit)
            gain = made.gain
            fewer = gain.joint_after == 0.0 and gain.after > gain.before + 1e-12
            if gain.joint_after > gain.joint_before + 1e-12 or (fewer and gain.joint_before == 0.0):
                good.append(made)
        if len(good) == MOST_GAINS or count == MOST_TRIES:
            break
    return Gains(tuple(good), tuple(refused[:MOST_GAINS]))


def _holds(
    question: PopulationQuestion,
    other: PopulationQuestion,
    bodies: PopulationBodies,
    found: Chunk,
    served: Bools,
) -> bool:
    """Whether a change may gain something, as far as those say who should meet everything with it
    (P,): asked is a sample of them, where they sit and with their hands at rest, how much they have to
    spare at most.

    First-order moves know nothing of what a part that goes 40 mm up runs into. Where so many then
    miss by far what they met before that less than half of those who fit today are left, everybody's
    whole search is spared.
    """
    people = np.flatnonzero(served)
    people = people[:: max(1, len(people) // ASKED_FIRST)]
    lost = np.zeros(len(served), dtype=np.bool_)
    for rows, situations in found_situations(other, bodies, people, found):
        most = most_of([with_clear_legs(one) for one in situations], other.asked)
        lost[rows] = (met_of(found.margin[rows]) & (most < -WITHIN_NEIGHBOURS)).any(axis=1)
    weight = question.people.weight
    left = float(np.average(~lost[people], weights=weight[people])) * (weight @ served)
    return bool(left >= weight @ met_of(found.margin).all(axis=1) / 2)


def changed_question(
    question: PopulationQuestion, found: Chunk, change: Change
) -> PopulationQuestion:
    """What is asked of everybody with a change made."""
    asked = question.asked
    still = replace(change, travel_forward=(0.0, 0.0), travel_up=(0.0, 0.0))
    rows = affected_requirements(question.place, asked, still)
    place = changed(question.place, change)
    return replace(
        question,
        place=place,
        asked=renewed(place, asked),
        members=np.zeros((len(asked), 0), dtype=np.bool_),
        before=_before(question, found, change, rows),
        bounded=False,
    )


def _with_person(
    gain: DesignChange, both: Sequence[tuple[PopulationQuestion, Chunk]], bodies: PopulationBodies
) -> TriedChange:
    """A gain with the person who lacked most of its requirement of those who meet everything by the
    change; of those who meet the requirement by it where nobody meets everything.

    both: the question and its answer without and with the change.
    """
    (question, found), (_, then) = both
    r = [one.requirement.name for one in question.asked].index(gain.requirement)
    lacking = np.where(np.isnan(found.margin[:, r]), 0.0, -found.margin[:, r])
    before = met_of(found.margin)
    after = met_of(then.margin)
    meets = after[:, r] & (lacking > MET)
    gains = meets & after.all(axis=1) & ~before.all(axis=1)
    among = gains if gains.any() else meets
    row = int(np.argmax(np.where(among, lacking, 0.0)))
    if not among[row]:
        return TriedChange(gain)
    margins = (float(found.margin[row, r]), float(then.margin[row, r]))
    one, two = (next(shown_people(asked, bodies, chunk, [row], at=[r])) for asked, chunk in both)
    return TriedChange(gain, ChangedPerson(row, one, two), margins)


def _compared(
    question: PopulationQuestion, found: Chunk, margin: Floats, change: Change, at: int | list[int]
) -> DesignChange:
    """The gain from the margins found to those with a change.

    at: the requirement that it is reported of, or several, of which the share changes most.
    """
    weight = question.people.weight
    before = met_of(found.margin)
    after = met_of(margin)
    single = share_single(before, weight)
    then = share_single(after, weight)
    r = at if isinstance(at, int) else at[int(np.argmax(np.abs(then - single)[at]))]
    grows = growth(question, found, change, r)
    if question.asked[r].requirement.of_sight and not grows.any() and change.size:
        grows = np.nan_to_num(margin[:, r] - found.margin[:, r]) / change.size
    return DesignChange(
        words=change.words,
        requirement=question.asked[r].requirement.name,
        move=change.size,
        rate=_rate(found.margin[:, r], grows, weight),
        margin_rate=_mean(grows, ~before[:, r], weight),
        before=float(single[r]),
        after=float(then[r]),
        joint_before=_joint(before, weight),
        joint_after=_joint(after, weight),
    )


def _before(
    question: PopulationQuestion, found: Chunk, change: Change, rows: Sequence[int]
) -> Before:
    """How people came out without a change that bears on these requirements.

    Who fits with a shorter travel of the seat fits with a longer one.
    """
    nominal = (found.setting == nominal_setting(question.place)).all(axis=1)
    everything: Bools = np.asarray(met_of(found.margin).all(axis=1), dtype=np.bool_)
    left = _left_as_they_are(question, change)
    known = ~everything & (left is not None)
    places = {
        person: _where_it_may_fit(found, person, *left)
        for person in np.flatnonzero(known).tolist()
        if left is not None
    }
    columns = found.judged_where.shape[1]
    again = np.full((len(known), max(map(len, places.values()), default=0), columns), np.nan)
    for person, some in places.items():
        again[person, : len(some)] = some
    return Before(
        margin=found.margin,
        seat=found.seat,
        nominal=nominal,
        fits=everything,
        known=known,
        again=again,
        travel=np.array(question.place.travel),
        borne=tuple(rows) if change.moves else (),
    )


def _left_as_they_are(
    question: PopulationQuestion, change: Change
) -> tuple[Floats, frozenset[str]] | None:
    """(R,) [m] by how much a change lets the margin of each requirement grow at most in a position of
    the seat, and the parts of which a reach may be kept no more. None where hands or feet hold one
    of the controls that are moved: that may change everything.

    A distance to a part grows by no more than the part is moved by. What depends on the arms is not
    known, since they may go another way.
    """
    controls = set(moved_controls(question.place.environment, change.moves))
    held = {name for case in question.place.cases for name in case.held.values()}
    if controls & held:
        return None
    parts = moved_parts(change)
    most = np.zeros(len(question.asked))
    for r, one in enumerate(question.asked):
        if (one.control is not None and one.control.name in controls) or one.requirement.of_sight:
            most[r] = np.inf
        elif parts & set(one.criterion.parts):
            segments = one.criterion.segments
            legs = bool(segments) and not ARMS.intersection(segments)
            legs &= not any(any(move.turn) for move in change.moves)
            most[r] = sum(np.linalg.norm(move.by) for move in change.moves) if legs else np.inf
    return most, frozenset(parts)


def _where_it_may_fit(found: Chunk, person: int, most: Floats, parts: frozenset[str]) -> Floats:
    """(n, A + 2) [m or rad] the settings and positions that were judged in which a person may meet
    everything once margins have grown by `most` (R,) and nothing is in the way that some parts were;
    see `_left_as_they_are`."""
    mine = found.judged_person == person
    blamed = np.array([k.part in parts for k in (*found.words, NO_REASON)])[found.reason[person]]
    grown = found.judged_margin[mine] + np.where(blamed, np.inf, most)
    places: Floats = found.judged_where[mine][~(grown < -MET).any(axis=1)]
    return places


def _joint(met: Bools, weight: Floats) -> float:
    return float(weight[np.flatnonzero(np.all(met, axis=1))].sum() / weight.sum())


def _rate(margin: Floats, grows: Floats, weight: Floats) -> float:
    """Share gained by a metre, from margins (P,) that grow (P,) by so much with it."""
    low, high = (
        share_single(met_of(margin + way * grows)[:, None], weight)[0] for way in (-NEAR, NEAR)
    )
    return float(high - low) / (2 * NEAR)


def _mean(grows: Floats, missed: Bools, weight: Floats) -> float:
    """The weighted mean of those who miss the requirement, of everybody where nobody does."""
    some = missed if missed.any() else np.ones(len(missed), dtype=np.bool_)
    return float(np.average(grows[some], weights=weight[some]))
