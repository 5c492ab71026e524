"""What of a state differs from a study's file, and the file saved with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from workbench.errors import InputError
from workbench.files.study.saving import StudyText, save_text
from workbench.files.yaml_changes import Sharing, changed_text
from workbench.files.yaml_text import parse_yaml
from workbench.model.body import Body
from workbench.model.criterion import Criterion
from workbench.model.moves import Move
from workbench.model.person import Size
from workbench.model.study import Action, GivenPosture, PredictedPosture, Role, Study
from workbench.study.bench.said import SAME_ANGLE, SAME_LENGTH, said
from workbench.study.bench.state import Arrangement, OpenStudy, PersonState, given_angles

__all__ = ["save"]


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
    if not _sizes_alike(role.size if name is None else role.sizes[name], person.figure.size):
        raise _OtherStudyError(f"{person.role}: the size could not be saved")
    if role.clothes != person.figure.clothes:
        raise _OtherStudyError(f"{person.role}: the clothes could not be saved")


def _sizes_alike(one: Size | None, other: Size | None) -> bool:
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
