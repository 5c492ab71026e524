"""Questions that wait for an answer: of one subject the newest, but none that ends a drag is lost.

Who asks is answered in turn, so that nobody waits for all that another one asks.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from workbench.errors import InputError
from workbench.live.protocol import Question

__all__ = ["MOST_WAITING", "Waiting"]

MOST_WAITING = 256
"""Questions of one who asks that may wait; who sends more has lost count."""
Asker = TypeVar("Asker", bound=Hashable)


@dataclass
class Waiting(Generic[Asker]):
    """The questions of each who asks, in their order; whose turn is next comes first."""

    rows: dict[Asker, list[Question]] = field(default_factory=dict)

    def __len__(self) -> int:
        return sum(map(len, self.rows.values()))

    def put(self, asker: Asker, question: Question) -> None:
        """Let a question wait, in the place of one on the way of the same drag.

        Raises
        ------
        InputError
            If too many wait.
        """
        mine = self.rows.get(asker, [])
        kept = [one for one in mine if one.done or one.subject != question.subject]
        if len(kept) >= MOST_WAITING:
            raise InputError(f"{MOST_WAITING} questions wait already")
        self.rows[asker] = [*kept, question]

    def take(self) -> tuple[Asker, Question]:
        """The question that has waited longest of the one whose turn it is."""
        asker = next(iter(self.rows))
        first, *rest = self.rows.pop(asker)
        if rest:
            self.rows[asker] = rest  # behind the others
        return asker, first

    def forget(self, asker: Asker) -> None:
        """Drop what somebody asked who has gone; what ends a drag is still done."""
        done = [question for question in self.rows.pop(asker, []) if question.done]
        if done:
            self.rows[asker] = done
