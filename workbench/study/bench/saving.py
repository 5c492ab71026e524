"""What of a state differs from a study's file, and the file saved with it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.study.saving import StudyText, save_text
from workbench.files.study.splice import (
    AxisAngle,
    Change,
    CriteriaChange,
    JointChange,
    MovedChange,
    PostureChange,
    SeatChange,
    spliced,
)
from workbench.files.study.splice_people import (
    AdjustChange,
    ClothesChange,
    HoldChange,
    PredictionChange,
    SizeChange,
    StatedSize,
    ZoneChange,
)
from workbench.files.yaml_edits import Sharing
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.moves import Move
from workbench.model.person import Size
from workbench.model.poses import Poses
from workbench.model.study import Action, GivenPosture, PredictedPosture, Role, Study
from workbench.posture.reaching.limbs import HANDS
from workbench.study.bench.edits import adjuster_of
from workbench.study.bench.state import Arrangement, OpenStudy, PersonState, given_angles

__all__ = ["changes_of", "save"]

SAME_ANGLE = 1e-6
"""[rad] Angles that differ by less are the same."""
SAME_LENGTH = 1e-6
"""[m]"""


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
        As of `spliced` and `save_text`.

    Returns
    -------
    StudyText
        As it is now; the same bytes where nothing differs.

    Raises
    ------
    InputError
        As of `spliced` and `save_text`; then the file is as it was.
    """

    def check(study: Study) -> None:
        _check_saved(opened, arrangement, study)

    for whole in (False, True):
        changes = list(changes_of(opened, arrangement, whole=whole))
        try:
            written = spliced(text.text, changes, sharing=sharing)
            return save_text(disk or text, written, check, over=over, to=to)
        except _OtherStudyError as error:
            if whole:  # all angles of a joint were written, not the changed ones alone
                raise InputError(str(error)) from None
    raise AssertionError("the second attempt returns or raises")


class _OtherStudyError(InputError):
    """A text that was spliced says something else than the state."""


def changes_of(
    opened: OpenStudy, arrangement: Arrangement, *, whole: bool = False
) -> Iterator[Change]:
    """The changes that lead from a study's file to a state.

    Parameters
    ----------
    whole
        Whether all angles of a joint are stated where one is another.
    """
    if arrangement.moves != opened.start.moves:
        yield MovedChange(opened.start.moves, arrangement.moves)
    yield from _setting_changes(opened, arrangement)
    for k, zone in enumerate(arrangement.zones):
        if zone != opened.start.zones[k]:
            yield ZoneChange(k, zone)
    if arrangement.added:
        yield CriteriaChange(arrangement.added)
    for row, person in enumerate(arrangement.people):
        before = opened.start.people[row]
        yield from _figure_changes(opened, before, person)
        yield from _seat_changes(before, person)
        for number, action in enumerate(person.actions):
            old = before.actions[number]
            if action is not old:
                case = opened.case_rows[number]
                library = opened.study.roles[row].library
                yield from _action_changes(library, person, case, (old, action), whole)


def _setting_changes(opened: OpenStudy, arrangement: Arrangement) -> Iterator[Change]:
    """Where adjustments are set, of those that are set elsewhere or were not before."""
    before = dict(opened.start.settings)
    for name, value in arrangement.settings:
        if before.get(name) != value:
            one = opened.study.environment.adjustment(name)
            shown = float(np.degrees(value)) if one.turns else value
            yield AdjustChange(adjuster_of(opened, one), name, shown, one.turns)


def _figure_changes(
    opened: OpenStudy, before: PersonState, person: PersonState
) -> Iterator[Change]:
    """The size and the clothes, where they are others."""
    old, new = before.figure, person.figure
    if old is new:
        return
    sizes = _stated_size(old.size), _stated_size(new.size)
    if sizes[0] != sizes[1]:
        yield SizeChange(person.role, _size_key(opened, person.role), *sizes)
    clothes = tuple(tuple(item.name for item in figure.clothes) for figure in (old, new))
    if clothes[0] != clothes[1]:
        yield ClothesChange(person.role, clothes[0], clothes[1])


def _stated_size(size: Size | None) -> StatedSize | None:
    return None if size is None else StatedSize(size.sex, dict(size.measures), size.age)


def _size_key(opened: OpenStudy, role: str) -> tuple[str, ...]:
    """Where the size of a role stands in it."""
    name = opened.shown_size.get(role)
    return ("size",) if name is None else ("sizes", name)


def _seat_changes(before: PersonState, person: PersonState) -> Iterator[Change]:
    """The position of a seat: where it is another, held or free now; and where the text might say
    otherwise, because postures are predicted that were not, or are given that were predicted."""
    off = max(abs(person.forward - before.forward), abs(person.up - before.up))
    if person.free != before.free or (not person.free and off > SAME_LENGTH):
        yield SeatChange(person.role, person.forward, person.up, person.free)
    elif not person.free and _predicts(person) and not _predicts(before):
        yield SeatChange(person.role, person.forward, person.up)


def _predicts(person: PersonState) -> bool:
    return any(isinstance(action, PredictedPosture) for action in person.actions)


def _action_changes(
    library: Mapping[str, Poses],
    person: PersonState,
    case: int,
    actions: tuple[Action, Action],
    whole: bool,
) -> Iterator[Change]:
    """The changes from one action to another."""
    old, new = actions
    role = person.role
    assert isinstance(old, (GivenPosture, PredictedPosture))
    if isinstance(new, PredictedPosture):
        yield from _prediction_changes(role, case, old, new)
        return
    assert isinstance(new, GivenPosture)
    body = person.figure.body
    same = isinstance(old, GivenPosture) and old.name == new.name
    before = given_angles(body, old.poses if same else library[new.name])
    after = given_angles(body, new.poses)
    changed = np.abs(after - before) > SAME_ANGLE
    joints = np.flatnonzero(changed.any(axis=1)).tolist()
    stated = {j: _stated(body, after, j, changed, whole) for j in joints}
    if not same:
        yield PostureChange(case, role, new.name, {body.joints[j]: stated[j] for j in joints})
    else:
        for j in joints:
            yield JointChange(case, role, body.joints[j], stated[j])
    held = old.hands if same and isinstance(old, GivenPosture) else {}
    for hand in HANDS:
        if held.get(hand) != new.hands.get(hand):
            yield HoldChange(case, role, "", hand, new.hands.get(hand))


def _prediction_changes(
    role: str, case: int, old: GivenPosture | PredictedPosture, new: PredictedPosture
) -> Iterator[Change]:
    """The changes from an action to a prediction: of the same one, the controls that are held."""
    aims = new.aims
    kind = "driver" if aims.driving is not None else "predicted"
    if isinstance(old, PredictedPosture) and _but_for_holds(old) == _but_for_holds(new):
        for limb, control in aims.controls.items():
            if old.aims.controls.get(limb) != control:
                yield HoldChange(case, role, kind, limb, control)
        if old.aims.controls.keys() <= aims.controls.keys():
            return
    yield PredictionChange(case, role, new.like, aims.controls, aims.eyes, aims.heels)


def _but_for_holds(action: PredictedPosture) -> tuple[object, ...]:
    """What a posture is predicted from, without what hands and feet hold."""
    return action.like, action.aims.eyes, action.aims.heels, action.aims.driving


def _stated(
    body: Body, angles: Floats, joint: int, changed: Bools, whole: bool
) -> tuple[AxisAngle, ...]:
    """The angles of a joint that are stated: those that changed, or all."""
    return tuple(
        AxisAngle(body.stops.motions[joint][axis], float(np.degrees(angles[joint, axis])))
        for axis in range(3)
        if whole or changed[joint, axis]
    )


def _check_saved(opened: OpenStudy, arrangement: Arrangement, study: Study) -> None:
    """InputError where a study that was saved is not the state."""
    if not _moved_alike(study.moved, arrangement.moves):
        raise _OtherStudyError("the parts that were moved could not be saved")
    if tuple(one.zone for one in study.criteria[: len(arrangement.zones)]) != arrangement.zones:
        raise _OtherStudyError("the harness zones could not be saved")
    if not _set_alike(study.settings, dict(arrangement.settings)):
        raise _OtherStudyError("the adjustments could not be saved")
    asked = {one.name: one for one in study.criteria}
    for one in arrangement.added:
        if one.name not in asked or not _asked_alike(asked[one.name], one):
            raise _OtherStudyError(f"the criterion {one.name!r} could not be saved")
    for row, person in enumerate(arrangement.people):
        role = study.roles[row]
        _check_figure(opened, person, role)
        off = max(abs(role.forward - person.forward), abs(role.up - person.up))
        if role.free != person.free or (not role.free and off > SAME_LENGTH):
            raise _OtherStudyError(f"{person.role}: the position of the seat could not be saved")
        for number, action in enumerate(person.actions):
            case = study.cases[opened.case_rows[number]]
            if not _alike(person.figure.body, case.actions[row], action):
                what = f"{person.role} in case {case.name!r}: the posture could not be saved"
                raise _OtherStudyError(what)


def _check_figure(opened: OpenStudy, person: PersonState, role: Role) -> None:
    """InputError where a person who was saved is of another size, or wears something else."""
    name = opened.shown_size.get(role.name)
    saved = _stated_size(role.size if name is None else role.sizes[name])
    if not _sizes_alike(saved, _stated_size(person.figure.size)):
        raise _OtherStudyError(f"{person.role}: the size could not be saved")
    if role.clothes != person.figure.clothes:
        raise _OtherStudyError(f"{person.role}: the clothes could not be saved")


def _sizes_alike(one: StatedSize | None, other: StatedSize | None) -> bool:
    """Whether two sizes come to the same."""
    if one is None or other is None:
        return one is other
    if (one.sex, one.age, set(one.measures)) != (other.sex, other.age, set(other.measures)):
        return False
    return all(
        abs(one.measures[name] - other.measures[name]) < SAME_LENGTH for name in one.measures
    )


def _set_alike(one: Mapping[str, float], other: Mapping[str, float]) -> bool:
    """Whether adjustments are set alike."""
    return set(one) == set(other) and all(
        abs(value - other[name]) < SAME_LENGTH for name, value in one.items()
    )


def _moved_alike(one: Sequence[Move], other: Sequence[Move]) -> bool:
    """Whether two lists of moves come to the same."""
    if [(move.parts, move.controls) for move in one] != [(m.parts, m.controls) for m in other]:
        return False
    pairs = zip(one, other, strict=True)
    return all(np.abs(np.subtract(a.by, b.by)).max() < SAME_LENGTH for a, b in pairs)


def _asked_alike(one: Criterion, other: Criterion) -> bool:
    """Whether two criteria ask for the same."""
    names = ("people", "segments", "parts", "cases")
    same = all(set(getattr(one, name)) == set(getattr(other, name)) for name in names)
    off = abs(one.at_least - other.at_least)
    return one.check == other.check and same and off < SAME_LENGTH


def _alike(body: Body, one: Action, other: Action) -> bool:
    """Whether two actions come to the same."""
    if isinstance(one, GivenPosture) and isinstance(other, GivenPosture):
        off = np.abs(given_angles(body, one.poses) - given_angles(body, other.poses)).max()
        named = (one.name, dict(one.hands)) == (other.name, dict(other.hands))
        return named and bool(off < 10 * SAME_ANGLE)
    if isinstance(one, PredictedPosture) and isinstance(other, PredictedPosture):
        return (one.like, one.aims) == (other.like, other.aims)
    return False
