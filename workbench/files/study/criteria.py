"""The criteria of a study: of whom and of which cases each can be asked, and its names."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError, one_of
from workbench.files.catalogue import find
from workbench.files.names import matches, matching
from workbench.files.schema import validate
from workbench.files.study.roles import LoadedRole
from workbench.files.study.schema import ActionFile, CriterionFile, RoleFile, RulesFile
from workbench.files.study.work import Key, Work
from workbench.files.yaml_text import read_yaml
from workbench.model.body import segment_words
from workbench.model.criterion import Criterion, Limit
from workbench.model.environment import Environment

__all__ = ["Known", "criteria_of", "unfit", "visible_parts"]

Pair = tuple[str, str]
"""A role and a case, by their names."""


@dataclass(frozen=True)
class Known:
    """The names that criteria may use. parts: those that are checked, belts and airbags too;
    complete: whether all bodies and the environment could be loaded."""

    room: Environment | None
    roles: dict[str, LoadedRole]
    parts: tuple[str, ...]
    hidden: frozenset[str]
    complete: bool

    @property
    def segments(self) -> list[str]:
        """The segments of all bodies, each once."""
        names = (name for role in self.roles.values() for name in role.body.segments)
        return list(dict.fromkeys(names))

    @property
    def subparts(self) -> list[str]:
        """The named spheres of all bodies, each once."""
        names = (name for role in self.roles.values() for name in role.body.subparts if name)
        return list(dict.fromkeys(names))

    @property
    def words(self) -> dict[str, str]:
        """The segments by what they are called in words."""
        found: dict[str, str] = {}
        for role in self.roles.values():
            found |= segment_words(role.body)
        return found


def visible_parts(room: Environment) -> tuple[str, ...]:
    """The parts that are checked: a hidden one is neither drawn nor measured."""
    pairs = zip(room.parts, room.hidden, strict=True)
    return tuple(name for name, hidden in pairs if not hidden)


def unfit(check: str, role: RoleFile, action: ActionFile) -> str:
    """Why a check cannot be asked of a role's action, "" where it can."""
    moving = action.moves
    predicted = action.predicted or action.driver
    if check in ("reach", "pedals", "preferred_seat", "eye_height", "view_over") and moving:
        return "it cannot be asked of a motion"
    if check == "injury" and not moving:
        return "it is asked of motions"
    if check == "view_over" and role.seat is None:
        return "it is asked of somebody in a seat"
    if check in ("pedals", "preferred_seat", "eye_height") and predicted is None:
        return "it is asked of a predicted posture or a driver's"
    if check == "pedals" and predicted and not (predicted.feet.left or predicted.feet.right):
        return "it needs 'feet' in the action"
    if check == "eye_height" and predicted and predicted.eyes is None:
        return "it needs 'eyes' in the action"
    return ""


def criteria_of(work: Work, known: Known) -> list[Criterion]:
    """The criteria with their names resolved; faults go to the work."""
    _twice(work)
    _asked_twice(work, known)
    found = []
    for row, file in work.parts.criteria:
        before = len(work.faults)
        _name_faults(work, (row, file), known)
        pairs = _pairs(work, (row, file))
        limits = _limits(work, (row, file), known)
        if len(work.faults) == before and known.room is not None:
            found.append(_criterion(file, pairs, limits, known))
    return found


def _twice(work: Work) -> None:
    seen: set[str] = set()
    for row, name in work.parts.criterion_names:
        if name in seen:
            what = f"two criteria are named {name!r}; give each a name of its own"
            work.fault(("criteria", row, "name"), what)
        seen.add(name)


def _asked_twice(work: Work, known: Known) -> None:
    """Report controls of a population that two criteria ask for by the same hand in the same zone:
    they would be counted twice."""
    asked: dict[tuple[str, str, int], str] = {}
    for row, file in work.parts.criteria if work.parts.crowd else ():
        if file.check != "reach" or known.room is None:
            continue
        for control in known.room.controls:
            if not matching(file.controls, [control.name]):
                continue
            zone = file.zone or control.zone
            key = (control.name, file.hand or "either", zone)
            before = asked.setdefault(key, file.name)
            if before != file.name:
                where: Key = ("criteria", row, "controls") if file.controls else ("criteria", row)
                what = f"{control.name} in zone {zone} is asked for by {before!r} already; "
                work.fault(where, what + "name it in one of the two")


def _name_faults(work: Work, entry: tuple[int, CriterionFile], known: Known) -> None:
    row, file = entry
    valid: dict[str, Iterable[str]] = {
        "people": work.parts.roles,
        "cases": [case.name for _, case in work.parts.cases],
        "of": [name for r, name in work.parts.criterion_names if r != row],
    }
    if known.complete:
        valid["segments"] = known.segments
        valid["subparts"] = known.subparts
    if known.room is not None:
        valid["controls"] = [control.name for control in known.room.controls]
        valid["parts"] = known.parts
    for field, names in valid.items():
        every = list(names)
        for place, name in enumerate(getattr(file, field) or ()):
            exact = field in ("people", "cases", "of")
            if (
                not every
                or name in every
                or (not exact and any(matches(name, each) for each in every))
            ):
                continue
            what = f"nothing is called {name!r}"
            if field == "parts" and name in known.hidden:
                what = f"part {name!r} is hidden, so it is not checked"
            hint = one_of(name, every, words=known.words if field == "segments" else {})
            work.fault(("criteria", row, field, place), f"{what}; {hint}")


def _actions(work: Work) -> Iterator[tuple[Pair, RoleFile, ActionFile]]:
    """Every action of a role that can be read."""
    for _, case in work.parts.cases:
        for name, action in case.actions.items():
            role = work.parts.roles.get(name)
            if role is not None and action is not None:
                yield (name, case.name), role, action


def _pairs(work: Work, entry: tuple[int, CriterionFile]) -> list[Pair]:
    """The roles and cases that a criterion is asked of; reports those that it does not fit."""
    row, file = entry
    if not work.parts.people_whole or row not in work.parts.criteria_whole:
        return []
    if file.check == "share":
        if work.parts.crowd is None:
            what = "a share is of a population; give a role a 'population'"
            work.fault(("criteria", row, "check"), what)
        return []
    if file.check == "between_people" and len(work.parts.roles) < 2:
        what = "between_people needs two roles or more; leave it out for one"
        work.fault(("criteria", row, "check"), what)
    pairs = []
    reasons: dict[Pair, str] = {}
    for pair, role, action in _actions(work):
        if file.people is not None and pair[0] not in file.people:
            continue
        if file.cases is not None and pair[1] not in file.cases:
            continue
        reason = unfit(file.check, role, action)
        if reason:
            reasons[pair] = reason
        else:
            pairs.append(pair)
    named = [case for _, case in pairs]
    for place, case in enumerate(file.cases or ()):
        why = next((r for (_, c), r in reasons.items() if c == case), "")
        if case not in named and why:
            what = f"check: {file.check} does not fit case {case!r}: {why}; leave the case out"
            work.fault(("criteria", row, "cases", place), what)
    if file.cases is None:
        who = [name for name, _ in pairs]
        for place, name in enumerate(file.people or ()):
            why = next((r for (n, _), r in reasons.items() if n == name), "")
            if name not in who and why:
                what = f"check: {file.check} fits no case of {name!r}: {why}; leave the role out"
                work.fault(("criteria", row, "people", place), what)
        if not pairs and reasons and file.people is None:
            why = next(iter(reasons.values()))
            what = f"check: {file.check} fits no case: {why}; leave the criterion out"
            work.fault(("criteria", row, "check"), what)
    return pairs


def _limits(work: Work, entry: tuple[int, CriterionFile], known: Known) -> tuple[Limit, ...]:
    """The limits of the rule set of an injury criterion."""
    row, file = entry
    if file.rules is None:
        return ()
    key: Key = ("criteria", row, "rules")
    try:
        where = find("studies/rules", file.rules, near=work.path.parent)
        rules = validate(read_yaml(where), RulesFile)
    except InputError as error:
        work.errors(key, error)
        return ()
    work.inputs["rules" if "rules" not in work.inputs else f"rules: {file.rules}"] = where
    for role in known.roles.values():
        for limit in rules.limits:
            if limit.segment not in role.body.segments:
                what = f"limits segment {limit.segment!r}, which body {role.body.name} has not; "
                work.fault(key, what + one_of(limit.segment, role.body.segments))
    spans = {"hic": math.inf, "held": 0.003}
    return tuple(
        Limit(
            limit.figure,
            limit.segment,
            (limit.window if limit.figure == "hic" else limit.hold) or spans[limit.figure],
            limit.limit,
            limit.source,
        )
        for limit in rules.limits
    )


def _criterion(
    file: CriterionFile, pairs: list[Pair], limits: tuple[Limit, ...], known: Known
) -> Criterion:
    assert known.room is not None
    at_least = file.at_least or 0.0
    if file.check == "stops":
        at_least = math.radians(at_least)
    if file.check == "share":
        at_least /= 100
    direction = np.array(file.direction or (1.0, 0.0, 0.0))
    x, y, z = (float(v) for v in direction / np.linalg.norm(direction))
    most = 0.001 if file.check == "pedals" else 0.0
    return Criterion(
        name=file.name,
        check=file.check,
        people=tuple(dict.fromkeys(name for name, _ in pairs)),
        segments=matching(file.segments, known.segments),
        parts=matching(file.parts, known.parts),
        at_least=at_least,
        controls=matching(file.controls, [control.name for control in known.room.controls]),
        zone=file.zone,
        hand=None if file.hand == "either" else file.hand,
        subparts=matching(file.subparts, known.subparts) if file.subparts else (),
        below=math.inf if file.below is None else file.below,
        above=math.inf if file.above is None else file.above,
        at_most=most if file.at_most is None else file.at_most,
        down=math.radians(file.down or 0.0),
        direction=(x, y, z),
        origin=file.origin or (0.0, 0.0, 0.0),
        rules=file.rules or "",
        limits=limits,
        of=tuple(file.of or ()),
        cases=tuple(dict.fromkeys(case for _, case in pairs)),
    )
