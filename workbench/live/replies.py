"""What a question comes to: frames that are sent at once, and work that takes longer."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from workbench.live.filming import Film

__all__ = ["Made", "Replies", "Work"]


@dataclass(frozen=True, eq=False)
class Made:
    """Frames for who asked, and the work that goes on from there; None where it is done."""

    frames: list[bytes]
    more: Work | None = None


class Work(Protocol):
    """Something that takes long, of a frozen state; it is done in a thread of its own.

    A newer one of the same kind that the same page asks for takes its place.
    """

    @property
    def kind(self) -> str:
        """What it is, as a verb of the protocol."""

    @property
    def generation(self) -> int | None:
        """The number of the state; what is left of it is dropped once the state is another. None
        where it is of no state that changes."""

    def made(self) -> Made:
        """Do it, or a piece of it."""


@dataclass
class Replies:
    """Frames for everybody, frames for who asked alone, whether the study is another now, what is to
    be done for who asked, a film that is to be made, or ended, and the file of a study that is to be
    opened in the place of what is open."""

    everybody: list[bytes] = field(default_factory=list)
    asker: list[bytes] = field(default_factory=list)
    changed: bool = False
    work: Work | None = None
    film: Film | None = None
    film_ends: bool = False
    study: Path | None = None
