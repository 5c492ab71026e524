"""Questions that wait for an answer: of one subject the newest, but none that ends a drag is lost."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from workbench.errors import InputError
from workbench.live.protocol import Question

__all__ = ["MOST_WAITING", "Waiting"]

MOST_WAITING = 256
"""Questions that may wait; who sends more has lost count."""
Asker = TypeVar("Asker", bound=Hashable)


@dataclass
class Waiting(Generic[Asker]):
    """Questions in their order, each with who asks."""

    rows: list[tuple[Asker, Question]] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.rows)

    def put(self, asker: Asker, question: Question) -> None:
        """Let a question wait, in the place of one on the way of the same drag.

        Raises
        ------
        InputError
            If too many wait.
        """
        for k, (other, before) in enumerate(self.rows):
            if other == asker and before.subject == question.subject and not before.done:
                del self.rows[k]
                break
        if len(self.rows) >= MOST_WAITING:
            raise InputError(f"{MOST_WAITING} questions wait already")
        self.rows.append((asker, question))

    def take(self) -> tuple[Asker, Question]:
        """The question that has waited longest."""
        return self.rows.pop(0)

    def forget(self, asker: Asker) -> None:
        """Drop what somebody asked who has gone; what ends a drag is still done."""
        self.rows = [row for row in self.rows if row[0] != asker or row[1].done]
