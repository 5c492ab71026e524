"""The history of an open study: its states in their order, and which of them is shown."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Generic, TypeVar

__all__ = ["MOST_STATES", "TOGETHER", "Entry", "History"]

MOST_STATES = 500
"""States that are kept; the oldest give way."""
TOGETHER = 1.0
"""Time [s] within which changes of the same thing are one entry."""
State = TypeVar("State")


@dataclass(frozen=True, eq=False)
class Entry(Generic[State]):
    """A state, what was changed for it, and when [s]."""

    arrangement: State
    subject: str = ""
    time: float = float("-inf")


@dataclass(frozen=True, eq=False)
class History(Generic[State]):
    """States in their order, the first of them as opened, and the index of the one that is shown."""

    entries: tuple[Entry[State], ...]
    at: int = 0

    @classmethod
    def of(cls, arrangement: State) -> History[State]:
        """Begin a history with the state as opened."""
        return cls((Entry(arrangement),))

    @property
    def shown(self) -> Entry[State]:
        """The entry that is shown."""
        return self.entries[self.at]

    @property
    def can_undo(self) -> bool:
        """Whether a state comes before the one that is shown."""
        return self.at > 0

    @property
    def can_redo(self) -> bool:
        """Whether a state was undone."""
        return self.at < len(self.entries) - 1

    def added(self, entry: Entry[State]) -> History[State]:
        """Add a state behind the one that is shown; what was undone is forgotten.

        A change of the same subject within `TOGETHER` of the one before takes its place.
        """
        before = self.shown
        kept = self.entries[: self.at + 1]
        together = bool(entry.subject) and entry.subject == before.subject
        if self.at > 0 and together and entry.time - before.time < TOGETHER:
            kept = kept[:-1]
        kept = (*kept, entry)[-MOST_STATES:]
        return History(kept, len(kept) - 1)

    def undone(self) -> History[State]:
        """Show the state before; the same where there is none."""
        return replace(self, at=max(self.at - 1, 0))

    def redone(self) -> History[State]:
        """Show the state that was undone last; the same where there is none."""
        return replace(self, at=min(self.at + 1, len(self.entries) - 1))
