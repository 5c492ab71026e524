"""Save a study's changed text: it replaces the file only after it was read and found to say what it
should."""

from __future__ import annotations

from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

from workbench.errors import InputError
from workbench.files.file_errors import read_whole
from workbench.files.output_file import bytes_of, replaced, saving
from workbench.files.study.reader import load_study
from workbench.model.study import Study

__all__ = ["ChangedFileError", "StudyText", "read_text", "save_text"]


class ChangedFileError(InputError):
    """A study's file holds something else than what was opened."""


class StudyText:
    """The text of a study's file as it was read.

    Parameters
    ----------
    path
        The file; a link is followed.
    data
        Its bytes.
    """

    def __init__(self, path: Path, data: bytes) -> None:
        self.path = path.resolve()
        self.data = data
        try:
            self.text = data.decode("utf-8")
        except UnicodeDecodeError:
            raise InputError(f"{path}: not a text file in UTF-8") from None

    @property
    def digest(self) -> str:
        """A hash of the bytes."""
        return sha256(self.data).hexdigest()

    def changed_on_disk(self) -> bool:
        """Whether the file holds other bytes now, or is gone."""
        return self.bytes_on_disk() != self.data

    def bytes_on_disk(self) -> bytes | None:
        """What the file holds now; None where it is gone or cannot be read."""
        return bytes_of(self.path)


def read_text(path: Path) -> StudyText:
    """Read the text of a study's file. InputError where it cannot be read."""
    return StudyText(path, read_whole(path, "a text file"))


def save_text(
    before: StudyText,
    text: str,
    check: Callable[[Study], None],
    *,
    over: bool = False,
    to: Path | None = None,
) -> StudyText:
    """Replace a study's file by another text, in one step.

    Parameters
    ----------
    before
        As it was read.
    text
        What it is to say.
    check
        Is given the study of the new text; raises InputError where this is not what was meant.
    over
        Whether a file that has changed since it was read is replaced too.
    to
        Another file, which must not be there; the same if None.

    Returns
    -------
    StudyText
        As it was written.

    Raises
    ------
    ChangedFileError
        If the file has changed since it was read.
    InputError
        If the file cannot be written, or the new text says something else.
    """
    path = before.path if to is None else to.resolve()
    data = text.encode("utf-8")
    with saving(path):
        if to is not None and path.exists():
            raise InputError(f"{to}: is there already; name another file")
        if to is None and not over and before.changed_on_disk():
            raise ChangedFileError(
                f"{path}: has changed on the disk since it was opened; reload it, or save over it"
            )
        replaced(path, data, lambda partial: check(load_study(partial)))
    return StudyText(path, data)
