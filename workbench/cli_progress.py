"""What a command says while it works: a spinner on a terminal, nothing elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

__all__ = ["Progress", "tell"]


def tell(text: str) -> None:
    """A line to stderr, where talk goes."""
    print(text, file=sys.stderr, flush=True)


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
            self.status.update(text)

    def __exit__(self, *_: object) -> None:
        if self.status is not None:
            self.status.stop()
