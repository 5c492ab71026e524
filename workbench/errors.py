"""Every error the workbench raises on purpose.

WorkbenchError          the root: catch this one
├── InputError          a file or value is wrong (exit code 3); carries one line per problem
├── UsageError          the call or the command line is wrong (exit code 2)
└── MissingPartError    an optional library is not installed (exit code 4)
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches

__all__ = [
    "InputError",
    "MissingPartError",
    "UsageError",
    "WorkbenchError",
    "has_controls",
    "one_of",
    "printable",
]

_CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Characters that steer a terminal, turn the direction of text round, or cannot be written as
UTF-8.

C0 without tab and line feed, DEL, C1, line and paragraph separators, directional overrides, and
lone surrogates (bytes of a file name that are no text).
"""


class WorkbenchError(Exception):
    """Root of all errors the workbench raises on purpose. Its text is printable, whatever a file
    was called, and never empty: an error that says nothing is a fault of the workbench."""

    exit_code = 3

    def __init__(self, text: str) -> None:
        if not text.strip():
            raise ValueError(f"{type(self).__name__}: no text says what is wrong")
        super().__init__(printable(text))


class InputError(WorkbenchError):
    """A file or a value is wrong. `problems` holds one complete line for each fault found."""

    def __init__(self, problems: str | Sequence[str]) -> None:
        lines = (problems,) if isinstance(problems, str) else tuple(problems)
        self.problems: tuple[str, ...] = tuple(printable(line) for line in lines)
        super().__init__("\n".join(self.problems))

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[str, ...]]]:
        return type(self), (self.problems,)


class UsageError(WorkbenchError):
    """The call or the command line is wrong."""

    exit_code = 2


class MissingPartError(WorkbenchError):
    """An optional library is needed for this and is not installed."""

    exit_code = 4


def one_of(given: object, valid: Iterable[str], *, words: Mapping[str, str] | None = None) -> str:
    """Say what would have been right: the nearest valid name first, then all of them (at most 40).

    given: what is no valid name, perhaps no text at all; words: other words that somebody may have
    meant a valid name by.
    """
    given = given if isinstance(given, str) else ""
    names = list(valid)
    meant = {word.lower(): name for word, name in (words or {}).items() if name in names}
    known = given.lower().replace("_", " ")
    near = [meant[known]] if known in meant else get_close_matches(given, names, n=1)
    near = near or [meant[word] for word in get_close_matches(known, meant, n=1)]
    shown = ", ".join(names[:40]) + (f", … ({len(names)} in all)" if len(names) > 40 else "")
    return (f"did you mean {near[0]!r}? " if near else "") + f"valid: {shown or 'none'}"


def has_controls(text: str) -> bool:
    """Whether `printable` would change a text."""
    return _CONTROLS.search(text) is not None


def printable(text: str) -> str:
    """Write control characters as escapes (ESC becomes ``\\u001b``), so that they cannot act on a
    terminal or a page.

    Line feeds and tabs stay. The escapes are those of JSON, so JSON text means the same afterwards.
    """
    return _CONTROLS.sub(lambda found: f"\\u{ord(found[0]):04x}", text)
