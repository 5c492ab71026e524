"""Overlaps deeper than allowed that no criterion asks about.

A study passes when its criteria hold. Whoever is deep in a part that no criterion names is still in
it: such overlaps are warnings of the result, so that no green page hides them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.contacts import Contacts
from workbench.model.criterion import Criterion
from workbench.model.environment import Environment
from workbench.model.motion_case import ContactEvent
from workbench.model.result import PersonFound
from workbench.model.units import plain

__all__ = [
    "Overlap",
    "meeting_warnings",
    "meeting_words",
    "overlap_warnings",
    "overlap_words",
    "unasked_meetings",
    "unasked_overlaps",
]

_LEAST = 5e-5
"""[m] Overlaps that are deeper than allowed by less are not mentioned: they read as 0.0 mm."""


@dataclass(frozen=True, eq=False)
class Overlap:
    """One overlap: row `row` of contacts, of a person with a part, another person or oneself."""

    case: str
    person: str
    other: str
    """The other person, "" where there is none."""
    contacts: Contacts
    row: int

    @property
    def excess(self) -> float:
        """How much deeper it is than allowed [m]."""
        return float(self.contacts.excess[self.row])


def unasked_overlaps(
    criteria: Sequence[Criterion],
    cases: Sequence[str],
    people: Iterable[PersonFound],
    between: Mapping[tuple[str, str], Contacts],
) -> list[Overlap]:
    """Find the overlaps deeper than allowed that no criterion asks about.

    Parameters
    ----------
    criteria
        What the study asks.
    cases
        The names of the poses.
    people, between
        What was found of each person, and the contacts of each pair of people.

    Returns
    -------
    list[Overlap]
        The deepest of each case and pair of segments or of a segment and a part, by person, then by
        what it is deeper than allowed, the most first.
    """
    found: list[Overlap] = []
    for person in people:
        found += _beyond(cases, person.name, "", person.contacts)
        found += _beyond(cases, person.name, "", person.self_contacts)
    for (one, other), contacts in between.items():
        found += _beyond(cases, one, other, contacts)
    return [overlap for overlap in found if not any(_asks(one, overlap) for one in criteria)]


def _beyond(cases: Sequence[str], person: str, other: str, contacts: Contacts) -> Iterator[Overlap]:
    """The overlaps beyond what is allowed, the greatest excess first."""
    deepest = contacts.deepest()
    for row in np.argsort(-deepest.excess, kind="stable").tolist():
        if deepest.excess[row] > _LEAST:
            yield Overlap(cases[int(deepest.pose[row])], person, other, deepest, row)


def _asks(criterion: Criterion, overlap: Overlap) -> bool:
    """Whether a criterion measures the pair of an overlap."""
    if not criterion.asks(overlap.case) or overlap.person not in criterion.people:
        return False
    contacts, row = overlap.contacts, overlap.row
    if overlap.other:
        return criterion.check == "between_people" and overlap.other in criterion.people
    segments = contacts.body.segments
    segment = segments[int(contacts.segment[row])]
    if not isinstance(contacts.other, Environment):
        pair = {segment, segments[int(contacts.other_segment[row])]}
        return criterion.check == "self_contact" and bool(pair & set(criterion.segments))
    about = segment in criterion.segments
    if criterion.subparts:
        about = contacts.body.subparts[int(contacts.sphere[row])] in criterion.subparts
    if not about or contacts.other.parts[int(contacts.part[row])] not in criterion.parts:
        return False
    # a clearance leaves out the pairs whose contact is allowed
    measures = bool(criterion.subparts) or contacts.allowed[row] == 0
    return criterion.check == "contact" or (criterion.check == "clearance" and measures)


def overlap_warnings(overlaps: Sequence[Overlap]) -> Iterator[str]:
    """A sentence for each person and what is deepest: "pilot, cruise and 2 more cases: right upper
    leg (bottom) is 51.2 mm into left seat pan (20.0 mm allowed), about which no criterion
    asks; 4 more such overlaps"."""
    by_case: dict[tuple[str, str, str], list[Overlap]] = {}
    for one in overlaps:
        by_case.setdefault((one.person, one.other, one.case), []).append(one)
    cases: dict[tuple[str, str], list[str]] = {}
    for (person, _, case), found in by_case.items():
        cases.setdefault((person, _depth_words(found)), []).append(case)
    for (person, words), names in cases.items():
        where = names[0]
        if len(names) > 1:
            where += f" and {len(names) - 1} more case{'s' if len(names) > 2 else ''}"
        yield f"{person}, {where}: {words}"


def _depth_words(overlaps: Sequence[Overlap]) -> str:
    """The deepest of the overlaps of one case in words, and how many more there are."""
    more = len(overlaps) - 1
    return (
        f"{overlap_words(overlaps[0])}, about which no criterion asks"
        f"{f'; {more} more such overlap' if more else ''}{'s' if more > 1 else ''}"
    )


def overlap_words(overlap: Overlap) -> str:
    """One overlap in words: "right upper leg (bottom) is 51.2 mm into left seat pan (20.0 mm
    allowed)"."""
    contacts, row = overlap.contacts, overlap.row
    if isinstance(contacts.other, Environment):
        other = plain(contacts.other.parts[int(contacts.part[row])])
    else:
        own = contacts.other_name(row)
        other = f"{overlap.other}'s {own}" if overlap.other else f"the body's own {own}"
    depth = f"{-1000 * contacts.distance[row]:.1f} mm into {other}"
    if contacts.allowed[row] > 0:
        depth += f" ({1000 * contacts.allowed[row]:.1f} mm allowed)"
    return f"{contacts.name(row)} is {depth}"


def unasked_meetings(
    criteria: Sequence[Criterion], meetings: Iterable[ContactEvent]
) -> list[ContactEvent]:
    """Find the contacts of a motion deeper than allowed that no criterion asks about, the greatest
    excess first. criteria: those that are asked of the motion."""
    found = [
        meeting
        for meeting in meetings
        if meeting.depth > meeting.allowed + _LEAST
        and not any(_asks_meeting(criterion, meeting) for criterion in criteria)
    ]
    return sorted(found, key=lambda meeting: meeting.allowed - meeting.depth)


def _asks_meeting(criterion: Criterion, meeting: ContactEvent) -> bool:
    """Whether a criterion measures the pair of a contact."""
    if meeting.own:
        pair = {meeting.segment, meeting.other}
        return criterion.check == "self_contact" and bool(pair & set(criterion.segments))
    about = meeting.segment in criterion.segments or bool(criterion.subparts)
    return (
        criterion.check in ("contact", "clearance") and about and meeting.other in criterion.parts
    )


def meeting_words(meeting: ContactEvent) -> str:
    """One contact in words: "right lower arm (bottom) is 53.2 mm into throttle_lever (15 mm
    allowed)"."""
    allowed = f" ({1000 * meeting.allowed:.0f} mm allowed)" if meeting.allowed > 0 else ""
    return f"{meeting.deep} is {1000 * meeting.depth:.1f} mm into {meeting.other}{allowed}"


def meeting_warnings(meetings: Sequence[ContactEvent]) -> Iterator[str]:
    """A sentence on contacts of a motion that no criterion asks about; nothing where there are
    none."""
    if not meetings:
        return
    deepest = f"{meeting_words(meetings[0])} at {1000 * meetings[0].deepest:.1f} ms"
    if len(meetings) == 1:
        yield f"one contact is deeper than allowed and no criterion asks about it: {deepest}"
        return
    own = sum(meeting.own for meeting in meetings)
    kinds = f"{len(meetings) - own} with parts, {own} of the body with itself"
    yield (
        f"{len(meetings)} contacts ({kinds}) are deeper than allowed and no criterion asks about "
        f"them; the farthest beyond what is allowed: {deepest}"
    )
