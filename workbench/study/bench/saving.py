"""What of a state differs from a study's file, and the file saved with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from workbench.errors import InputError
from workbench.files.study.saving import StudyText, save_text
from workbench.files.yaml_changes import Sharing, changed_text
from workbench.files.yaml_text import parse_yaml
from workbench.model.study import Study
from workbench.study.bench.said import said
from workbench.study.bench.state import Arrangement, OpenStudy, open_study

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
