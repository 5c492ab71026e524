"""The turnable picture of a case: people, what they overlap in red, findings by number, dimension
lines of the nearest clearances."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from workbench.draw.marks.annotations import clearance_marks, dimension
from workbench.draw.scene import Mark
from workbench.draw.source import PEOPLE_COLOURS
from workbench.draw.web.packing import TENTH
from workbench.draw.web.place_mesh import paired_mesh
from workbench.draw.web.views import WebBody, WebMark, WebPlace, WebView, body_view, mark_view
from workbench.errors import InputError
from workbench.model.arrays import Floats
from workbench.model.contacts import Contacts
from workbench.model.environment import Environment
from workbench.model.result import Finding, PersonFound, PosturesFound

__all__ = ["case_view", "compared_view"]

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
            environment=result.environment,
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
    return (contacts.sphere if own else contacts.other_sphere)[rows].tolist()


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


# The turnable picture of two states of the same people or place, with a slider that wipes from the
# one to the other.


def compared_view(
    before: WebView, after: WebView, *, names: tuple[str, str], title: str
) -> WebView:
    """Return two pictures as one: what is alike in both once, all else in its own state.

    Parameters
    ----------
    before, after
        The pictures; two motions at the same times.
    names
        What the states are called.
    title
        What the picture shows.

    Raises
    ------
    InputError
        If the pictures are of motions at different times, or of places that are no environments.
    """
    if before.times != after.times:
        raise InputError(f"{title}: the two motions must be shown at the same times")
    marks = [
        replace(mark, state=state)
        for state, view in enumerate((before, after))
        for mark in view.marks
    ]
    return WebView(
        title,
        tuple(_bodies(before.bodies, after.bodies, names)),
        _place(before, after, names, title),
        tuple(marks),
        before.times,
        look_from=before.look_from,
        begin=before.begin,
        states=names,
    )


def _place(
    before: WebView, after: WebView, names: tuple[str, str], title: str
) -> Environment | WebPlace | None:
    """The place of both, in two states where it differs."""
    one = before.environment
    two = after.environment
    if one is two:
        return one
    if not (isinstance(one, Environment) and isinstance(two, Environment)):
        raise InputError(f"{title}: both pictures must show an environment, or none")
    place = paired_mesh(one, two)
    called = (
        name if state is None else f"{name}, {names[state]}"
        for name, state in zip(place.names, place.state, strict=True)
    )
    return replace(place, names=tuple(called))


def _bodies(
    before: Sequence[WebBody], after: Sequence[WebBody], names: tuple[str, str]
) -> Iterator[WebBody]:
    """The bodies of both; one that is alike in both once."""
    shared = [body for body in before if any(_is_alike(body, other) for other in after)]
    yield from shared
    for state, bodies in enumerate((before, after)):
        for body in bodies:
            if not any(_is_alike(body, one) for one in shared):
                yield replace(body, name=f"{body.name}, {names[state]}", state=state)


def _is_alike(one: WebBody, two: WebBody) -> bool:
    return (
        (one.name, one.colour, one.segments, one.failing, one.touching, one.ghost)
        == (two.name, two.colour, two.segments, two.failing, two.touching, two.ghost)
        and _is_near(one.centres, two.centres)
        and _is_near(one.radius, two.radius)
    )


def _is_near(one: Floats, two: Floats) -> bool:
    """Whether lengths [m] are the same as far as they are shown."""
    return one.shape == two.shape and bool(np.all(np.abs(one - two) < TENTH / 2))
