"""What a command prints: data, talk, and while it works a spinner with the time on a terminal."""

from __future__ import annotations

import os
import shutil
import sys
import textwrap
import threading
import time
from collections.abc import Callable
from typing import Any, TextIO

from workbench.errors import printable

__all__ = ["Progress", "emit", "emit_sentence", "emit_verdict", "tell"]

_INKS = {"passed": "32", "FAILED": "1;31"}
"""Codes of colours on a terminal: green, and bold red."""
FIRST_WORD = 1.5
QUIET_TIME = 10.0
"""A command whose talk is not read on a terminal says how far it is after the first time [s], then
after the second, and each time after as long again as it has taken: few lines, however long it is.
What it goes over to is said earlier by as much as the two are apart."""
_INDENT = 8
"""Columns by which the lines of a verdict that go on are set in: as wide as its first word."""


def emit(data: object) -> None:
    """Print data to stdout, with control characters escaped: names of files and parts come from
    elsewhere."""
    print(printable(str(data)))


def tell(text: str) -> None:
    """Print a line to stderr, where talk goes, with control characters escaped; on a terminal it is
    broken between words."""
    print(_broken(text, sys.stderr), file=sys.stderr, flush=True)


def emit_sentence(text: str) -> None:
    """Print a sentence to stdout; on a terminal it is broken between words."""
    print(_broken(text, sys.stdout))


def _broken(text: str, stream: TextIO, *, hang: int = 0) -> str:
    """Text with control characters escaped, on a terminal in lines that end between words.

    hang: columns by which all lines but the first are set in.
    """
    if not stream.isatty():
        return printable(text)
    lines = textwrap.TextWrapper(
        max(shutil.get_terminal_size().columns, 2 * _INDENT),
        subsequent_indent=" " * hang,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return "\n".join(lines.fill(line) for line in printable(text).split("\n"))


def emit_verdict(line: str) -> None:
    """Print a line that begins with "passed" or "FAILED" to stdout.

    On a terminal it is broken between words, and the first word is coloured; not where NO_COLOR is
    set.
    """
    word, space, rest = _broken(line, sys.stdout, hang=_INDENT).partition(" ")
    if word in _INKS and sys.stdout.isatty() and not os.environ.get("NO_COLOR"):
        word = f"\x1b[{_INKS[word]}m{word}\x1b[0m"
    print(word + space + rest)


class Progress:
    """`with Progress() as say: say("reading")`: on a terminal one line that changes, with the time
    that has gone by; elsewhere now and then a line of its own, so that a log shows that it goes on.
    Who stops it by Ctrl-C is told where it was, if that was counted."""

    def __enter__(self) -> Callable[[str], None]:
        self.line: Any = None
        self.begun = time.monotonic()
        self.next = 0.0
        self.last = "starting"
        self.first = threading.Timer(FIRST_WORD, self._tell)
        self.first.daemon = True
        if sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import Progress as Line
            from rich.progress import SpinnerColumn, TextColumn, TimeElapsedColumn

            words = TextColumn("{task.description}", markup=False)  # names are no markup
            columns = (SpinnerColumn(), words, TimeElapsedColumn())
            self.line = Line(*columns, console=Console(stderr=True), transient=True)
            self.task = self.line.add_task("starting", total=None)
            self.line.start()
        else:
            self.first.start()
        return self._say

    def _say(self, text: str) -> None:
        another = text.partition(":")[0] != self.last.partition(":")[0]
        self.last = text
        if self.line is not None:
            self.line.update(self.task, description=printable(text))
        elif self.next and time.monotonic() >= self.next - another * (QUIET_TIME - FIRST_WORD):
            self._tell()

    def _tell(self) -> None:
        now = time.monotonic()
        self.next = now + max(QUIET_TIME, now - self.begun)
        tell(self.last)

    def __exit__(self, kind: type[BaseException] | None, error: object, trace: object) -> None:
        self.first.cancel()
        if self.line is not None:
            self.line.stop()
        if kind is KeyboardInterrupt and ":" in self.last:  # something was counted
            raise KeyboardInterrupt(f"{str(error) or 'stopped'} (it was at: {self.last})")
