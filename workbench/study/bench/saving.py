"""What of a state differs from a study's file, and the file saved with it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
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
    Sharing,
    spliced,
)
from workbench.model.arrays import Bools, Floats
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.moves import Move
from workbench.model.study import Action, GivenPosture, PredictedPosture, Study
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
    if arrangement.added:
        yield CriteriaChange(arrangement.added)
    for row, person in enumerate(arrangement.people):
        before = opened.start.people[row]
        yield from _seat_changes(before, person)
        for number, action in enumerate(person.actions):
            old = before.actions[number]
            if action is not old:
                case = opened.case_rows[number]
                yield from _action_changes(
                    opened.body(row), case, person.role, (old, action), whole
                )


def _seat_changes(before: PersonState, person: PersonState) -> Iterator[Change]:
    """The position of a seat, where it is another or held now."""
    off = max(abs(person.forward - before.forward), abs(person.up - before.up))
    if not person.free and (before.free or off > SAME_LENGTH):
        yield SeatChange(person.role, person.forward, person.up)


def _action_changes(
    body: Body, case: int, role: str, actions: tuple[Action, Action], whole: bool
) -> Iterator[Change]:
    """The changes from one action to a given posture."""
    old, new = actions
    assert isinstance(old, (GivenPosture, PredictedPosture)) and isinstance(new, GivenPosture)
    before = given_angles(body, old.poses)
    after = given_angles(body, new.poses)
    changed = np.abs(after - before) > SAME_ANGLE
    joints = np.flatnonzero(changed.any(axis=1)).tolist()
    stated = {j: _stated(body, after, j, changed, whole) for j in joints}
    if isinstance(old, PredictedPosture):
        yield PostureChange(case, role, new.name, {body.joints[j]: stated[j] for j in joints})
        return
    for j in joints:
        yield JointChange(case, role, body.joints[j], stated[j])


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
    asked = {one.name: one for one in study.criteria}
    for one in arrangement.added:
        if one.name not in asked or not _asked_alike(asked[one.name], one):
            raise _OtherStudyError(f"the criterion {one.name!r} could not be saved")
    for row, person in enumerate(arrangement.people):
        role = study.roles[row]
        off = max(abs(role.forward - person.forward), abs(role.up - person.up))
        if role.free != person.free or (not role.free and off > SAME_LENGTH):
            raise _OtherStudyError(f"{person.role}: the position of the seat could not be saved")
        for number, action in enumerate(person.actions):
            case = study.cases[opened.case_rows[number]]
            if not _alike(opened.body(row), case.actions[row], action):
                what = f"{person.role} in case {case.name!r}: the posture could not be saved"
                raise _OtherStudyError(what)


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
        return bool(off < 10 * SAME_ANGLE)
    return type(one) is type(other)
