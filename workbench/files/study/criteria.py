"""The criteria of a study: of whom and of which cases each can be asked, and its names."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.errors import InputError
from workbench.files.catalogue import find
from workbench.files.names import matches, matching
from workbench.files.schema import validate
from workbench.files.study.roles import LoadedRole
from workbench.files.study.rules import load_rule_set
from workbench.files.study.schema import ActionFile, CriterionFile, LimitFile, RoleFile, RulesFile
from workbench.files.study.work import Key, Work
from workbench.files.yaml_text import read_yaml
from workbench.model.accommodation import OF_SIGHT
from workbench.model.body import segment_words
from workbench.model.criterion import Criterion, Limit
from workbench.model.criterion import Work as Labour
from workbench.model.environment import Control, Environment
from workbench.model.rule_set import RuleSet
from workbench.model.units import UNITS, limit_unit_of

__all__ = ["Known", "criteria_of", "unfit", "visible_parts"]

Pair = tuple[str, str]
"""A role and a case, by their names."""
_STRENGTH = {"hand": "strain_arm_force_field", "foot": "strain_leg_strength"}
"""The rule sets of strength."""
ADULT = 18.0
"""[years] The least age of people whose strength was measured."""
_HELD = 0.003
"""How long a level is held [s] where a rule does not state it: the 3 ms of the chest."""


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
    of_postures = ("reach", "force", "pedals", "preferred_seat", "eye_height", "view_over")
    if check in (*of_postures, *OF_SIGHT) and moving:
        return "it cannot be asked of a motion"
    if check == "force" and role.population is None and role.sizes is None and role.size is None:
        return "strength goes by sex: give the role a 'size', 'sizes' or a 'population'"
    if check == "force" and role.size is not None and (role.size.age or ADULT) < ADULT:
        return "strength is known of adults"
    if check == "injury" and not moving:
        return "it is asked of motions"
    if check in ("view_over", "pillar", "forward_field") and role.seat is None:
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
        _name_faults(work, row, file, known)
        pairs = _pairs(work, row, file)
        limits = _limits(work, row, file, known)
        limbs = _limbs_on(work, row, file, pairs, known) if file.check == "force" else set()
        rules = _rule_set(work, row, file, limbs)
        _sight_faults(work, row, file, known, rules)
        if len(work.faults) == before and known.room is not None:
            found.append(_criterion(file, pairs, limits, known, known.room, rules))
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
    if not work.parts.crowd or known.room is None:
        return
    asked: dict[tuple[str, str, int], str] = {}
    for row, file, control in _reached(work, known.room):
        zone = file.zone or control.zone
        before = asked.setdefault((control.name, file.hand or "either", zone), file.name)
        if before != file.name:
            where: Key = ("criteria", row, "controls") if file.controls else ("criteria", row)
            what = f"{control.name} in zone {zone} is asked for by {before!r} already; "
            work.fault(where, what + "name it in one of the two")


def _reached(work: Work, room: Environment) -> Iterator[tuple[int, CriterionFile, Control]]:
    """The criteria about reach, with their rows, and each control that they ask for."""
    for row, file in work.parts.criteria:
        for control in room.controls if file.check == "reach" else ():
            if matching(file.controls, [control.name]):
                yield row, file, control


def _name_faults(work: Work, row: int, file: CriterionFile, known: Known) -> None:
    """Report what a criterion names that is not there."""
    others = [name for r, name in work.parts.criterion_names if r != row]
    exact = {"people": list(work.parts.roles), "cases": work.parts.case_names, "of": others}
    patterns = _patterns(known)
    for field, valid in (exact | patterns).items():
        for place, name in enumerate(getattr(file, field) or ()):
            if name in valid or not valid:
                continue
            if field in patterns and any(matches(name, each) for each in valid):
                continue
            what = f"nothing is called {name!r}"
            if field == "parts" and name in known.hidden:
                what = f"part {name!r} is hidden, so it is not checked"
            words = known.words if field == "segments" else {}
            work.check_name(("criteria", row, field, place), name, valid, what, words=words)


def _patterns(known: Known) -> dict[str, list[str]]:
    """The names that patterns of a criterion can mean, by field; those that are known."""
    found: dict[str, list[str]] = {}
    if known.complete:
        found |= {"segments": known.segments, "subparts": known.subparts}
    if known.room is not None:
        controls = [control.name for control in known.room.controls]
        instruments = [one.name for one in known.room.instruments]
        found |= {"controls": controls, "parts": list(known.parts)}
        found |= {"instruments": instruments, "points": list(known.room.points)}
        found |= {"mirrors": [one.name for one in known.room.mirrors]}
        found |= {"wheel": list(known.parts), "inside_wheel": list(known.parts)}
    return found


def _actions(work: Work) -> Iterator[tuple[Pair, RoleFile, ActionFile]]:
    """Every action of a role that can be read."""
    for _, case in work.parts.cases:
        for name, action in case.actions.items():
            role = work.parts.roles.get(name)
            if role is not None and action is not None:
                yield (name, case.name), role, action


def _pairs(work: Work, row: int, file: CriterionFile) -> list[Pair]:
    """The roles and cases that a criterion is asked of; reports those that it does not fit."""
    if not work.parts.people_whole or row not in work.parts.criteria_whole:
        return []
    key: Key = ("criteria", row)
    if file.check == "share":
        if work.parts.crowd is None:
            what = "a share is of a population; give a role a 'population'"
            work.fault((*key, "check"), what)
        return []
    if file.check == "between_people" and len(work.parts.roles) < 2:
        what = "between_people needs two roles or more; leave it out for one"
        work.fault((*key, "check"), what)
    asked = [
        (pair, unfit(file.check, role, action))
        for pair, role, action in _actions(work)
        if (file.people is None or pair[0] in file.people)
        and (file.cases is None or pair[1] in file.cases)
    ]
    _unfit_faults(work, key, file, asked)
    return [pair for pair, why in asked if not why]


def _unfit_faults(work: Work, key: Key, file: CriterionFile, asked: list[tuple[Pair, str]]) -> None:
    """Report the cases and roles that a criterion names and does not fit, or that it fits none.

    asked: the roles and cases that it is asked of, each with why it does not fit, "" where it does.
    """
    check = f"check: {file.check}"
    for place, case in enumerate(file.cases or ()):
        if why := _why_none(asked, case=case):
            what = f"{check} does not fit case {case!r}: {why}; leave the case out"
            work.fault((*key, "cases", place), what)
    if file.cases is not None:
        return
    for place, name in enumerate(file.people or ()):
        if why := _why_none(asked, name=name):
            what = f"{check} fits no case of {name!r}: {why}; leave the role out"
            work.fault((*key, "people", place), what)
    why = _why_none(asked)
    if why and file.people is None:
        work.fault((*key, "check"), f"{check} fits no case: {why}; leave the criterion out")


def _why_none(
    asked: list[tuple[Pair, str]], *, name: str | None = None, case: str | None = None
) -> str:
    """Why a criterion fits nothing of a role, of a case or at all: the first reason; "" where it
    fits anything, or nothing is asked."""
    reasons = [why for pair, why in asked if name in (None, pair[0]) and case in (None, pair[1])]
    return reasons[0] if reasons and all(reasons) else ""


def _limits(work: Work, row: int, file: CriterionFile, known: Known) -> tuple[Limit, ...]:
    """The limits of the rule set of an injury criterion."""
    if file.rules is None or file.check != "injury":
        return ()
    key: Key = ("criteria", row, "rules")
    try:
        where = find("studies/rules", file.rules, near=work.path.parent)
        rules = validate(read_yaml(where), RulesFile)
    except InputError as error:
        work.errors(key, error)
        return ()
    if not rules.limits:
        what = f"rule set {file.rules} has no 'limits' of signals; give one that has"
        work.fault(key, what)
    work.inputs["rules" if "rules" not in work.inputs else f"rules: {file.rules}"] = where
    for role in known.roles.values():
        for limit in rules.limits:
            what = f"limits segment {limit.segment!r}, which body {role.body.name} has not"
            work.check_name(key, limit.segment, role.body.segments, what)
    return tuple(
        Limit(limit.figure, limit.segment, _window(limit), limit.limit, limit.source)
        for limit in rules.limits
    )


def _rule_set(work: Work, row: int, file: CriterionFile, limbs: set[str]) -> RuleSet | None:
    """The rule set of a criterion of sight, or of a score, which has the one of its method where
    none is named; of a force that of the limbs that exert it."""
    shipped = f"strain_{file.method}" if file.check == "score" else None
    if limbs:
        shipped = _STRENGTH[min(limbs)]
    name = file.rules or shipped
    if name is None or file.check not in (*OF_SIGHT, "score", "force"):
        return None
    key: Key = ("criteria", row, "rules" if file.rules else "method")
    try:
        where = find("studies/rules", name, near=work.path.parent)
        rules = load_rule_set(where)
        lacking = set(load_rule_set(shipped).values) - set(rules.values) if shipped else set()
    except InputError as error:
        work.errors(key, error)
        return None
    if lacking:
        what = f"rule set {name} lacks values of {shipped}: {', '.join(sorted(lacking))}"
        work.fault(key, what)
    work.inputs["rules" if "rules" not in work.inputs else f"rules: {name}"] = where
    return rules


def _sight_faults(
    work: Work, row: int, file: CriterionFile, known: Known, rules: RuleSet | None
) -> None:
    """Report things to be seen that are not there, and instruments to be read without a height of
    their characters."""
    if file.check not in OF_SIGHT or known.room is None:
        return
    for field, names in _patterns(known).items():
        asked = getattr(file, field, None)
        if asked and not names:
            what = f"environment {known.room.name} has no {field}, so none can be seen"
            work.fault(("criteria", row, field), what)
    for field in ("eye_point", "r_point", "ground"):
        name = getattr(file, field)
        if name is not None:
            valid = list(known.room.points)
            what = f"environment {known.room.name} has no point {name!r}"
            work.check_name(("criteria", row, field), name, valid, what)
    fields = [name[6:] for name in rules.values if name.startswith("field_")] if rules else []
    for mirror in known.room.mirrors if file.check == "mirror" and rules else ():
        if matching(file.mirrors or [], [mirror.name]) and mirror.field not in fields:
            given = f"class {mirror.field!r}" if mirror.field else "no class"
            classes = ", ".join(fields)
            what = f"mirror {mirror.name!r} has {given}; rule set {file.rules} has {classes}"
            work.fault(("criteria", row, "mirrors"), what)
    for one in known.room.instruments if file.check == "reads" else ():
        if matching(file.instruments, [one.name]) and not one.characters:
            what = (
                f"instrument {one.name!r} of environment {known.room.name} has no height of its "
                "characters: state 'characters' of it there, or leave it out here"
            )
            work.fault(("criteria", row, "instruments"), what)


def _limbs_on(
    work: Work, row: int, file: CriterionFile, pairs: list[Pair], known: Known
) -> set[str]:
    """Whether a hand or a foot is on the controls of a criterion of force; reports controls on which
    none is, or several are, and keys that are of the other."""
    controls = [control.name for control in known.room.controls] if known.room is not None else []
    limbs_on: set[str] = set()
    for pair, _, action in _actions(work):
        held = _held(action) if pair in pairs else {}
        for name in matching(file.controls, controls) if pair in pairs else ():
            limbs = [limb for limb, control in held.items() if control == name]
            limbs_on |= {limb.split()[1] for limb in limbs}
            if len(limbs) == 1:
                continue
            who = f"of {pair[0]!r} in case {pair[1]!r}"
            what = f"no hand or foot {who} is on {name!r}: put one there in the case's 'hands' or 'feet'"
            if limbs:
                what = f"{' and '.join(limbs)} {who} are both on {name!r}: strength is known of one"
            work.fault(("criteria", row, "controls"), what)
    if "foot" in limbs_on and file.ages is None:
        what = (
            "a foot's strength needs 'ages': 18-25, 55-65 or 65+; those between were not measured"
        )
        work.fault(("criteria", row), what)
    for field in ("ages", "lean"):
        if "hand" in limbs_on and getattr(file, field) is not None:
            what = f"{field!r} is of feet, and a hand is on a control: ask hands and feet apart"
            work.fault(("criteria", row, field), what)
    return limbs_on


def _held(action: ActionFile) -> dict[str, str]:
    """By limb ("left hand", ...) the control that an action has it on."""
    aims = action.predicted or action.driver
    hands = aims.hands if aims else action.hands
    return (hands.held("hand") if hands else {}) | (aims.feet.held("foot") if aims else {})


def _window(limit: LimitFile) -> float:
    """The time [s] over which a figure is taken: the longest window of HIC, or how long a level is
    held."""
    if limit.figure == "hic":
        return limit.window or math.inf
    return limit.hold or _HELD


def _criterion(
    file: CriterionFile,
    pairs: list[Pair],
    limits: tuple[Limit, ...],
    known: Known,
    room: Environment,
    rules: RuleSet | None,
) -> Criterion:
    """A criterion without faults, its patterns resolved to names."""
    direction = np.array(file.direction or (1.0, 0.0, 0.0))
    direction /= np.abs(direction).max()  # else squares of large numbers overflow
    x, y, z = (float(v) for v in direction / np.linalg.norm(direction))
    most = 0.001 if file.check == "pedals" else 0.0
    return Criterion(
        name=file.name,
        check=file.check,
        people=tuple(dict.fromkeys(name for name, _ in pairs)),
        segments=matching(file.segments, known.segments),
        parts=_named(file, file.parts, known.parts),
        at_least=_in_si(file, file.at_least or 0.0),
        controls=_named(file, file.controls, [control.name for control in room.controls]),
        zone=file.zone,
        hand=None if file.hand == "either" else file.hand,
        subparts=matching(file.subparts, known.subparts) if file.subparts else (),
        below=math.inf if file.below is None else file.below,
        above=math.inf if file.above is None else file.above,
        at_most=most if file.at_most is None else _in_si(file, file.at_most),
        down=math.radians(file.down or 0.0),
        direction=(x, y, z),
        origin=file.origin or (0.0, 0.0, 0.0),
        rules=file.rules or "",
        instruments=matching(file.instruments or [], [one.name for one in room.instruments]),
        points=matching(file.points or [], list(room.points)),
        size=file.size or 0.0,
        eyes=file.eyes or "either",
        trunk=math.radians(file.trunk or 0.0),
        visible=(file.visible or 0.0) / 100,
        rule_set=rules,
        mirrors=matching(file.mirrors or [], [one.name for one in room.mirrors]),
        side=file.side or "",
        eye_point=file.eye_point or "",
        r_point=file.r_point or "",
        ground=file.ground or "",
        wheel=matching(file.wheel or [], known.parts),
        inside_wheel=matching(file.inside_wheel or [], known.parts),
        method=file.method or "",
        capable=(file.capable or 0.0) / 100,
        ages=file.ages or "",
        lean=math.radians(file.lean or 0.0),
        work=Labour(**file.work.model_dump()) if file.work else Labour(),
        limits=limits,
        of=tuple(file.of or ()),
        cases=tuple(dict.fromkeys(case for _, case in pairs)),
    )


def _named(
    file: CriterionFile, patterns: list[str] | None, names: Sequence[str]
) -> tuple[str, ...]:
    """The names that a key means, which left out means all; of what is seen it means none."""
    return () if patterns is None and file.check in OF_SIGHT else matching(patterns, names)


def _in_si(file: CriterionFile, limit: float) -> float:
    """A limit in the unit of its check as [rad] or a fraction; lengths are metres already."""
    unit = limit_unit_of(file.check)
    return limit if unit is UNITS["m"] else limit / unit.scale
