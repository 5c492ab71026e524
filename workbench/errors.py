"""Every error the workbench raises on purpose.

WorkbenchError          the root: catch this one
├── InputError          a file or value is wrong (exit code 3); carries one line per problem
├── UsageError          the call or the command line is wrong (exit code 2)
└── MissingPartError    an optional library is not installed (exit code 4)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches

__all__ = ["InputError", "MissingPartError", "UsageError", "WorkbenchError", "one_of"]


class WorkbenchError(Exception):
    """Root of all errors the workbench raises on purpose."""

    exit_code = 3


class InputError(WorkbenchError):
    """A file or a value is wrong. `problems` holds one complete line for each fault found."""

    def __init__(self, problems: str | Sequence[str]) -> None:
        self.problems: tuple[str, ...] = (problems,) if isinstance(problems, str) else tuple(problems)
        super().__init__("\n".join(self.problems))


class UsageError(WorkbenchError):
    """The call or the command line is wrong."""

    exit_code = 2


class MissingPartError(WorkbenchError):
    """An optional library is needed for this and is not installed."""

    exit_code = 4


def one_of(given: str, valid: Iterable[str], *, words: Mapping[str, str] | None = None) -> str:
    """Say what would have been right: the nearest valid name first, then all of them (at most 40).

    words: other words that somebody may have meant a valid name by.
    """
    names = list(valid)
    meant = {word.lower(): name for word, name in (words or {}).items() if name in names}
    known = given.lower().replace("_", " ")
    near = [meant[known]] if known in meant else get_close_matches(given, names, n=1)
    near = near or [meant[word] for word in get_close_matches(known, meant, n=1)]
    shown = ", ".join(names[:40]) + (f", … ({len(names)} in all)" if len(names) > 40 else "")
    return (f"did you mean {near[0]!r}? " if near else "") + f"valid: {shown or 'none'}"
