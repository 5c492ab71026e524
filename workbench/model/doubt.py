"""Something that is probably a mistake, with the name by which it is put away."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

__all__ = ["Doubt", "open_doubts"]


@dataclass(frozen=True)
class Doubt:
    """Something that is probably a mistake.

    Parameters
    ----------
    about
        What is doubted, such as "place of control throttle". It stays whatever the numbers are:
        an environment that lists it under `accepted` is doubted no more in this.
    words
        A sentence with the numbers.
    """

    about: str
    words: str

    @property
    def said(self) -> str:
        """The sentence, with the name by which it is put away."""
        return f"{self.words} [{self.about}]"


def open_doubts(doubts: Iterable[Doubt], accepted: Sequence[str]) -> list[Doubt]:
    """Return the doubts that are not put away, each once.

    Parameters
    ----------
    doubts
        All that were found.
    accepted
        What they are about, or patterns of it.
    """
    return [
        doubt
        for doubt in dict.fromkeys(doubts)
        if not any(doubt.about == key or fnmatchcase(doubt.about, key) for key in accepted)
    ]
