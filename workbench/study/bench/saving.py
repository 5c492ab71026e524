"""What of a state differs from a study's file: the file's values with the changes, and the file saved
with them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from workbench.errors import InputError
from workbench.files.schema import metres_in
from workbench.files.study.saving import StudyText, save_text
from workbench.files.yaml_changes import Sharing, changed_text
from workbench.files.yaml_text import parse_yaml
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.person import Size
from workbench.model.population import MASS
from workbench.model.poses import Poses
from workbench.model.study import GivenPosture, PredictedPosture, Study
from workbench.model.surroundings import Move
from workbench.study.bench.edits import adjuster_of
from workbench.study.bench.state import (
    Arrangement,
    OpenStudy,
    PersonState,
    given_angles,
    open_study,
)

__all__ = [
    "said",
    "save",
    "with_joint",
    "with_moves",
    "with_position",
]

SAME_ANGLE = 1e-6
"""[rad] Angles that differ by less are the same."""
SAME_LENGTH = 1e-6
"""[m]"""
Said = dict[str, Any]
Angles = Mapping[tuple[str, str], float]
"""Angles [degrees] about axes of a joint, by the two motions of each: positive in the first."""


def said(opened: OpenStudy, arrangement: Arrangement, says: Said, *, whole: bool = False) -> Said:
    """Return what a study's file is to say of a state.

    Parameters
    ----------
    says
        What it says of the state as it was opened, or of this one already. It is not changed.
    whole
        Whether all angles of a joint are stated where one is another.

    Raises
    ------
    InputError
        If something is not there that is to be changed.
    """
    found: Said = _copy(says)
    scale = _scale(found)
    if arrangement.moves != opened.start.moves:
        found = with_moves(found, opened.start.moves, arrangement.moves)
    _set_adjustments(opened, arrangement, found)
    for k, zone in enumerate(arrangement.zones):
        if zone != opened.start.zones[k]:
            _put(_mapping(found, "criteria", k), "zone", zone)
    if arrangement.added:
        rows = [_criterion(criterion, scale) for criterion in arrangement.added]
        asked = found.get("criteria") or []
        found["criteria"] = asked if asked[-len(rows) :] == rows else [*asked, *rows]
    for row, person in enumerate(arrangement.people):
        before = opened.start.people[row]
        if before.figure is not person.figure:
            _set_figure(opened, before, person, found)
        _set_seat(before, person, found)
        for number, action in enumerate(person.actions):
            old = before.actions[number]
            at = (opened.case_rows[number], person.role)
            if isinstance(action, PredictedPosture) and action is not old:
                assert isinstance(old, (GivenPosture, PredictedPosture))
                _set_prediction(found, at, old, action)
            elif isinstance(action, GivenPosture) and action is not old:
                library = opened.study.roles[row].library
                _set_posture(found, at, person.figure.body, library, (old, action), whole)
    return found


def _copy(value: Any) -> Any:
    """A value that shares nothing with another one, nor within itself."""
    if isinstance(value, dict):
        return {key: _copy(inner) for key, inner in value.items()}
    return [_copy(inner) for inner in value] if isinstance(value, list) else value


def _mapping(says: Said, *key: str | int) -> Said:
    """The mapping at a key."""
    found: Any = says
    for part in key:
        rows = found if isinstance(found, dict) else dict(enumerate(found or ()))
        found = rows.get(part)
    if not isinstance(found, dict):
        name = " ".join(str(part + 1) if isinstance(part, int) else part for part in key)
        raise InputError(f"{name}: no mapping stands there to be changed")
    return found


def _put(mapping: Said, key: str, value: Any) -> None:
    """Set a value, or take it away where it is None."""
    mapping.pop(key, None) if value is None else mapping.update({key: value})


def _scale(says: Said) -> float:
    """The unit of length of a study [m]."""
    return metres_in[says["length"]] if "length" in says else 1.0


def _number(value: float) -> float:
    """A length as it stands in a file: to 1e-7 of the unit."""
    return round(value, 7) + 0.0


def with_moves(says: Said, before: Sequence[Move], after: Sequence[Move]) -> Said:
    """Return what a study says with other moves, behind its environment where it had none.

    Entries that move the same as before get another displacement, new ones follow; only where one
    has gone or is of other parts is the list made anew.
    """
    rows = [_move(move, _scale(says)) for move in after]
    said_now = says.get("moved")
    alike = [(move.parts, move.controls) for move in before]
    same = [(move.parts, move.controls) for move in after[: len(before)]] == alike
    if same and isinstance(said_now, list) and len(said_now) == len(before):
        for row, (old, new) in enumerate(zip(before, after, strict=False)):
            rows[row] = said_now[row] | ({"by": rows[row]["by"]} if old.by != new.by else {})
    if "moved" in says:
        return says | {"moved": rows}
    found: Said = {}
    for key, value in says.items():
        found[key] = value
        if key == "environment":
            found["moved"] = rows
    return found


def _move(move: Move, scale: float) -> Said:
    """A move as it stands in a file: parts by name, so that controls take none along."""
    parts = {"parts": list(move.parts)} if move.parts else {}
    controls = {"controls": list(move.controls), "alone": True} if move.controls else {}
    return {**parts, **controls, "by": [_number(value / scale) for value in move.by]}


def _criterion(criterion: Criterion, scale: float) -> Said:
    """A criterion about the distance of a pair as it stands in a file."""
    parts = {"parts": list(criterion.parts)} if criterion.check == "clearance" else {}
    return {
        "name": criterion.name,
        "check": criterion.check,
        "people": list(criterion.people),
        "segments": list(criterion.segments),
        **parts,
        "at_least": _number(criterion.at_least / scale),
    }


def _set_adjustments(opened: OpenStudy, arrangement: Arrangement, says: Said) -> None:
    """State where adjustments are set, of those that are set elsewhere or were not before."""
    before = dict(opened.start.settings)
    for name, value in arrangement.settings:
        if before.get(name) == value:
            continue
        one = opened.study.environment.adjustment(name)
        shown = round(float(np.degrees(value)), 1) if one.turns else _number(value / _scale(says))
        people = _mapping(says, "people")
        stated = [role for role, who in people.items() if name in (who.get("adjust") or {})]
        who = _mapping(says, "people", stated[0] if stated else adjuster_of(opened, one))
        who["adjust"] = {**(who.get("adjust") or {}), name: shown}


def _set_figure(opened: OpenStudy, before: PersonState, person: PersonState, says: Said) -> None:
    """State the size and the clothes, where they are others."""
    who = _mapping(says, "people", person.role)
    name = opened.shown_size.get(person.role)
    holder, key = (who, "size") if name is None else (_mapping(who, "sizes"), name)
    _set_size(holder, key, (before.figure.size, person.figure.size), _scale(says))
    old, new = ([item.name for item in one.clothes] for one in (before.figure, person.figure))
    if old != new:
        words = dict(zip(old, who.get("clothes") or (), strict=False))
        _put(who, "clothes", [words.get(item, item) for item in new] or None)


def _set_size(holder: Said, key: str, sizes: tuple[Size | None, Size | None], scale: float) -> None:
    """State the size at a key of a mapping: from one to another one."""
    old, new = (None if one is None else _size(one, scale) for one in sizes)
    said_now = holder.get(key)
    if new is None:
        holder.pop(key, None)
    elif old is None or not isinstance(said_now, dict):
        holder[key] = new
    elif old != new:
        if ("age" in old) != ("age" in new):  # children have other populations
            said_now.pop("population", None)
        words = said_now.get("measures") or {}
        before = old.get("measures", {})
        lengths = {
            name: words.get(name, value) if before.get(name) == value else value
            for name, value in new.get("measures", {}).items()
        }
        for name in ("sex", "age", "measures", "mass_kg"):
            if old.get(name) != new.get(name):
                _put(said_now, name, new.get(name) if name != "measures" else lengths or None)


def _size(size: Size, scale: float) -> Said:
    """A size as it stands in a file."""
    found: Said = {"sex": size.sex, "age": size.age}
    lengths = {name: value for name, value in size.measures.items() if name != MASS}
    found["measures"] = {name: _number(value / scale) for name, value in lengths.items()} or None
    found["mass_kg"] = _number(size.measures[MASS]) if MASS in size.measures else None
    return {name: value for name, value in found.items() if value is not None}


def _set_seat(before: PersonState, person: PersonState, says: Said) -> None:
    """State the position of a seat: where it is another, held or free now; and where the text might
    say otherwise, because postures are predicted that were not, or are given that were predicted."""
    off = max(abs(person.forward - before.forward), abs(person.up - before.up))
    other = person.free != before.free or (not person.free and off > SAME_LENGTH)
    if other or (not person.free and _predicts(person) and not _predicts(before)):
        position = None if person.free else (person.forward, person.up)
        with_position(_mapping(says, "people", person.role), position, _scale(says))


def _predicts(person: PersonState) -> bool:
    return any(isinstance(action, PredictedPosture) for action in person.actions)


def with_position(who: Said, position: tuple[float, float] | None, scale: float) -> None:
    """State the position of a role's seat: forward and up [m], or free where it is None."""
    said_now = who.get("position")
    if position is None:
        who["position"] = "free"
    elif said_now != "reference" or any(position):
        forward, up = (_number(value / scale) for value in position)
        kept = said_now if isinstance(said_now, dict) else {}
        who["position"] = kept | {"forward": forward, "up": up}


def _set_posture(
    says: Said,
    at: tuple[int, str],
    body: Body,
    library: Mapping[str, Poses],
    actions: tuple[Any, GivenPosture],
    whole: bool,
) -> None:
    """State a given posture, its angles and what hands hold; at: the case and the role."""
    old, new = actions
    same = isinstance(old, GivenPosture) and old.name == new.name
    before = given_angles(body, old.poses if same else library[new.name])
    after = given_angles(body, new.poses)
    changed = np.abs(after - before) > SAME_ANGLE
    case, role = at
    action = _mapping(says, "cases", case, "people", role)
    if not same:
        action.clear()
        action["posture"] = new.name
    for joint in np.flatnonzero(changed.any(axis=1)).tolist():
        with_joint(action, body.joints[joint], _stated(body, after, joint, changed, whole))
    _set_holds(action, old.hands if same else {}, new.hands)


def _stated(body: Body, angles: Floats, joint: int, changed: Bools, whole: bool) -> Angles:
    """The angles of a joint that are stated: those that changed, or all."""
    return {
        body.stops.motions[joint][axis]: float(np.degrees(angles[joint, axis]))
        for axis in range(3)
        if whole or changed[joint, axis]
    }


def with_joint(action: Said, joint: str, angles: Angles) -> None:
    """State angles of one joint; a key that names several joints is split."""
    rows = action.get("angles") or {}
    named = [key for key in rows if joint in _joints(key)]
    if not named:
        action["angles"] = {**rows, joint: _with_angles({}, angles)}
        return
    last = named[-1]
    others = " ".join(one for one in _joints(last) if one != joint)
    found: Said = {}
    for key, motions in rows.items():
        if key == last and others:
            found[others] = motions
        if key == last:
            found[joint] = _with_angles(motions, angles)
        elif key != joint:
            found[key] = motions
    action["angles"] = found


def _joints(key: str) -> list[str]:
    """The joints that a key of angles names."""
    return key.replace(",", " ").split()


def _with_angles(motions: Said, angles: Angles) -> Said:
    """The motions of a joint with some angles, each in the place of the motion that it is or that is
    its opposite."""
    found = dict(motions)
    for pair, degrees in angles.items():
        stated = {pair[int(degrees < 0)]: abs(round(degrees, 1))}
        place = next((motion for motion in found if motion in pair), None)
        if place is None:
            found |= stated
            continue
        rows = [
            stated if motion == place else {motion: value}
            for motion, value in found.items()
            if motion == place or motion not in pair
        ]
        found = {motion: value for row in rows for motion, value in row.items()}
    return found


def _set_prediction(
    says: Said, at: tuple[int, str], old: GivenPosture | PredictedPosture, new: PredictedPosture
) -> None:
    """State a prediction: what hands and feet hold alone, where that is all that differs."""
    case, role = at
    action = _mapping(says, "cases", case, "people", role)
    aims = new.aims
    same = isinstance(old, PredictedPosture) and _but_for_holds(old) == _but_for_holds(new)
    kind = "driver" if same and aims.driving is not None else "predicted"
    before = old.aims.controls if isinstance(old, PredictedPosture) and kind in action else {}
    if kind not in action:
        action.clear()
        action[kind] = {"like": new.like}
    prediction = _mapping(action, kind)
    _set_holds(prediction, before, aims.controls)
    if not same:
        for name, value in (("like", new.like), ("eyes", aims.eyes), ("heels", aims.heels)):
            _put(prediction, name, value)


def _but_for_holds(action: PredictedPosture) -> tuple[object, ...]:
    """What a posture is predicted from, without what hands and feet hold."""
    return action.like, action.aims.eyes, action.aims.heels, action.aims.driving


def _set_holds(action: Said, before: Mapping[str, str], after: Mapping[str, str]) -> None:
    """State the controls that limbs hold, where they are others."""
    for limb in {**before, **after}:
        if before.get(limb) != after.get(limb):
            side, kind = limb.split()
            group = "feet" if kind == "foot" else "hands"
            held = dict(action.get(group) or {})
            _put(held, side, after.get(limb))
            _put(action, group, held or None)


def save(
    opened: OpenStudy,
    text: StudyText,
    arrangement: Arrangement,
    *,
    disk: StudyText | None = None,
    sharing: Sharing = "ask",
    over: bool = False,
    to: Path | None = None,
) -> StudyText:
    """Save a state into its study's text.

    Parameters
    ----------
    opened, text
        The study as it was opened, and its text then.
    arrangement
        What is saved.
    disk
        The text as it was saved last; as it was opened if None.
    sharing, over, to
        As of `changed_text` and `save_text`.

    Returns
    -------
    StudyText
        As it is now; the same bytes where nothing differs.

    Raises
    ------
    InputError
        As of `changed_text` and `save_text`; then the file is as it was.
    """

    def check(study: Study) -> None:
        _check_saved(opened, arrangement, study)

    says = parse_yaml(text.text, str(text.path)).value
    for whole in (False, True):
        after = said(opened, arrangement, says, whole=whole)
        try:
            written = changed_text(text.text, after, sharing=sharing)
            return save_text(disk or text, written, check, over=over, to=to)
        except _OtherStudyError as error:
            if whole:  # all angles of a joint were written, not the changed ones alone
                raise InputError(str(error)) from None
    raise AssertionError("the second attempt returns or raises")


class _OtherStudyError(InputError):
    """A text that was changed says something else than the state."""


def _check_saved(opened: OpenStudy, arrangement: Arrangement, study: Study) -> None:
    """InputError where a study that was saved would still be changed to be the state."""
    size = next(iter(opened.shown_size.values()), "")
    saved = open_study(study, size, figures=[person.figure for person in arrangement.people])
    assert study.statement is not None
    says = dict(study.statement.value)
    after = said(saved, arrangement, says)
    if after != says:
        raise _OtherStudyError(f"{_other_key(says, after)} could not be saved")


def _other_key(one: Any, other: Any) -> str:
    """The first key at which two values differ, in words."""
    rows = other.items() if isinstance(other, dict) else enumerate(other)
    for key, value in rows:
        before = one.get(key) if isinstance(one, dict) else [*one, *other[len(one) :]][key]
        if before != value:
            deep = type(before) is type(value) and isinstance(value, (dict, list))
            shown = str(key + 1) if isinstance(key, int) else key
            return f"{shown} {_other_key(before, value)}".strip() if deep else shown
    return ""
