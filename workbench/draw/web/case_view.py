"""The turnable picture of a case: people, what they overlap in red, findings by number, dimension
lines of the nearest clearances."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.draw.marks.annotations import clearance_marks, dimension
from workbench.draw.scene import Mark
from workbench.draw.source import PEOPLE_COLOURS
from workbench.draw.web.views import WebMark, WebView, body_view, mark_view
from workbench.model.contacts import Contacts
from workbench.model.result import Finding, PersonFound, PosturesFound

__all__ = ["case_view"]

_EACH = 3  # dimension lines of one person


def case_view(
    result: PosturesFound, case: int, findings: list[Finding], *, within: float
) -> WebView:
    """Return the turnable picture of a case.

    Parameters
    ----------
    findings
        Those that are marked, by their numbers from 1.
    within
        Largest distance [m] that has a dimension line though no criterion fails there.
    """
    bodies = tuple(
        body_view(
            person.placed,
            person.name,
            PEOPLE_COLOURS[k % len(PEOPLE_COLOURS)],
            frames=slice(case, case + 1),
            failing=_failing(result, person, case),
        )
        for k, person in enumerate(result.people)
    )
    failing = [
        mark
        for number, finding in enumerate(findings, start=1)
        if (mark := _failing_mark(result, case, finding, number)) is not None
    ]
    taken = {mark.to for mark in failing}
    near = [
        mark
        for person in result.people
        for mark in _near_marks(person, case, within)
        if mark.to not in taken
    ]
    title = f"{result.who} in {result.environment.name}, {result.cases[case]}"
    return WebView(title, bodies, result.environment, (*failing, *near))


def _failing(result: PosturesFound, person: PersonFound, case: int) -> list[int]:
    """The spheres of a person that overlap something deeper than is allowed."""
    spheres = _beyond(person.contacts, case, own=True)
    spheres += _beyond(person.self_contacts, case, own=True)
    spheres += _beyond(person.self_contacts, case, own=False)
    for (one, other), contacts in result.between.items():
        if person.name in (one, other):
            spheres += _beyond(contacts, case, own=person.name == one)
    return spheres


def _beyond(contacts: Contacts, case: int, *, own: bool) -> list[int]:
    """The spheres of contacts beyond what is allowed: the body's own, or the other's."""
    rows = (contacts.pose == case) & (contacts.excess > 1e-9)
    found: list[int] = (contacts.sphere if own else contacts.other_sphere)[rows].tolist()
    return found


def _failing_mark(
    result: PosturesFound, case: int, finding: Finding, number: int
) -> WebMark | None:
    """The number of a finding where it is, or its dimension line where it is a distance."""
    if finding.point is None:
        return None
    for person in result.people:
        same = np.all(np.abs(person.clearance.point[case] - finding.point) < 1e-9, axis=2)
        close = same & (person.clearance.distance[case] > 0.0)
        if person.name == finding.person and close.any():
            segment, part = np.argwhere(close)[0].tolist()
            line = dimension(person.placed, person.clearance, (case, segment, part), named=True)
            return replace(mark_view(line), text=f"{number}: {line.label}", failing=True)
    return replace(mark_view(Mark(finding.point, str(number))), failing=True)


def _near_marks(person: PersonFound, case: int, within: float) -> list[WebMark]:
    marks = clearance_marks(
        person.placed, person.clearance, case, most=_EACH, within=within, named=True
    )
    return [mark_view(mark) for mark in marks]
