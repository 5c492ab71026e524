"""Criteria made of a pair: two things that are near each other, and how near they may be."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.contact.collide import allowed_depth
from workbench.errors import InputError, one_of
from workbench.files.names import good_name
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.units import plain
from workbench.study.bench.edits import FARTHEST, LENGTH_STEP, Edit, rounded
from workbench.study.bench.state import Arrangement, OpenStudy

__all__ = ["PairLimit", "asked_for", "role_bodies", "segment_of"]


@dataclass(frozen=True)
class PairLimit:
    """How near a segment of a person may come to a part or to somebody else.

    Parameters
    ----------
    person, segment
        The role, and a segment of its body by its name or mnemonic.
    part
        The name of a part; "" where it is another person.
    other, other_segment
        The other role and a segment of its body; "" where it is a part.
    at_least
        [m].
    name
        What the criterion is called; it is named in words if "".
    """

    person: str
    segment: str
    part: str = ""
    other: str = ""
    other_segment: str = ""
    at_least: float = 0.0
    name: str = ""


def asked_for(opened: OpenStudy, arrangement: Arrangement, wanted: PairLimit) -> Edit:
    """Ask for a distance between two things, as a criterion of the study.

    A segment and a part become a `clearance`, two people `between_people`. A pair that was asked
    for in this state already gets the new limit.

    Returns
    -------
    Edit
        The words name the criterion.

    Raises
    ------
    InputError
        If a person, segment or part is not there, the two may touch, the limit is out of range, or
        the name is taken.
    """
    if bool(wanted.part) == bool(wanted.other):
        raise InputError("a part or another person must be named, one of the two")
    if not 0.0 <= wanted.at_least <= FARTHEST:
        raise InputError(f"a limit of 0 to {1000 * FARTHEST:g} mm is possible")
    at_least = rounded(wanted.at_least, LENGTH_STEP)
    found = replace(_criterion(opened, wanted), at_least=at_least)
    kept = [one for one in arrangement.added if _pair(one) != _pair(found)]
    name = good_name(wanted.name, "criterion") if wanted.name else ""
    name = name or f"{found.name}, at least {1000 * at_least:g} mm"
    taken = [one.name for one in (*opened.study.criteria, *kept)]
    if wanted.name and name in taken:
        raise InputError(f"a criterion is named {name!r} already; give it a name of its own")
    found = replace(found, name=_own(name, taken))
    if any(one == found for one in arrangement.added):
        return Edit(arrangement)
    after = tuple(found if _pair(one) == _pair(found) else one for one in arrangement.added)
    if len(kept) == len(arrangement.added):
        after = (*arrangement.added, found)
    return Edit(replace(arrangement, added=after), f"asked for: {found.name}")


def segment_of(body: Body, name: str) -> int:
    """The index of a segment by its name or mnemonic. InputError where there is none."""
    for names in (body.segment_names, body.segments):
        if name in names:
            return names.index(name)
    raise InputError(
        f"body {body.name} has no segment {name!r}; {one_of(name, body.segment_names)}"
    )


def _criterion(opened: OpenStudy, wanted: PairLimit) -> Criterion:
    """The criterion of a pair, named in words, as yet without its limit."""
    roles = role_bodies(opened)
    body = _body(roles, wanted.person)
    n = segment_of(body, wanted.segment)
    own = body.segment_names[n]
    cases = opened.study.cases + (opened.moving.cases if opened.moving is not None else ())
    asked = tuple(case.name for case in cases)
    if wanted.part:
        k = opened.study.environment.part_index(wanted.part)
        _check_apart(opened, body, n, k)
        owner = f"{wanted.person}'s " if len(roles) > 1 else ""
        return Criterion(
            name=f"{owner}{own} to {plain(wanted.part)}",
            check="clearance",
            people=(wanted.person,),
            segments=(body.segments[n],),
            parts=(wanted.part,),
            at_least=0.0,
            cases=asked,
        )
    if wanted.other == wanted.person:
        raise InputError("a distance is asked for between two people, not of one to oneself")
    other = _body(roles, wanted.other)
    m = segment_of(other, wanted.other_segment)
    environment = opened.study.environment
    return Criterion(
        name=f"{wanted.person}'s {own} to {wanted.other}'s {other.segment_names[m]}",
        check="between_people",
        people=(wanted.person, wanted.other),
        segments=tuple(dict.fromkeys((body.segments[n], other.segments[m]))),
        parts=tuple(np.array(environment.parts)[~environment.hidden].tolist()),
        at_least=0.0,
        cases=asked,
    )


def role_bodies(opened: OpenStudy) -> dict[str, Body]:
    """The bodies by role; where everybody moves as their files have them."""
    found = {}
    if opened.moving is not None:
        found = {role.name: role.body for role in opened.moving.roles}
    return found | {
        role.name: opened.figures[row].body for row, role in enumerate(opened.study.roles)
    }


def _body(roles: dict[str, Body], name: str) -> Body:
    if name not in roles:
        raise InputError(f"nobody is called {name!r}; valid: {', '.join(roles)}")
    return roles[name]


def _check_apart(opened: OpenStudy, body: Body, segment: int, part: int) -> None:
    """InputError for a pair that has no clearance: a part that is hidden, or may be touched."""
    environment = opened.study.environment
    name = environment.parts[part]
    if environment.hidden[part]:
        raise InputError(f"part {name!r} is hidden, so it is not checked")
    if allowed_depth(body, environment)[segment, part] > 0:
        raise InputError(
            f"the {body.segment_names[segment]} may touch {name}, so no clearance is measured there"
        )


def _pair(criterion: Criterion) -> tuple[object, ...]:
    """What a criterion is about, apart from its limit and name."""
    parts = criterion.parts if criterion.check == "clearance" else ()
    return criterion.check, set(criterion.people), set(criterion.segments), parts


def _own(name: str, taken: list[str]) -> str:
    """A name that no other criterion has."""
    if name not in taken:
        return name
    number = 2
    while f"{name} ({number})" in taken:
        number += 1
    return f"{name} ({number})"
