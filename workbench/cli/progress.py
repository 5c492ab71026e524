"""What a command prints: data, talk, and while it works a spinner on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from workbench.errors import printable

__all__ = ["Progress", "emit", "tell"]


def emit(data: object) -> None:
    """Print data to stdout, with control characters escaped: names of files and parts come from
    elsewhere."""
    print(printable(str(data)))


def tell(text: str) -> None:
    """Print a line to stderr, where talk goes, with control characters escaped."""
    print(printable(text), file=sys.stderr, flush=True)


class Progress:
    """`with Progress() as say: say("reading")`: one line that changes, on a terminal only."""

    def __enter__(self) -> Callable[[str], None]:
        self.status: Any = None
        if sys.stderr.isatty():
            from rich.console import Console

            self.status = Console(stderr=True).status("starting")
            self.status.start()
        return self._say

    def _say(self, text: str) -> None:
        if self.status is not None:
            from rich.text import Text

            self.status.update(Text(printable(text)))  # a plain str would be read as markup

    def __exit__(self, *_: object) -> None:
        if self.status is not None:
            self.status.stop()
