"""Episodes: the spells in which something touched during a motion."""

from __future__ import annotations

from dataclasses import dataclass

from workbench.model.arguments import chosen_rows
from workbench.model.arrays import Bools, Floats, Ints, frozen
from workbench.model.body import Body
from workbench.model.environment import Environment

__all__ = ["Episodes"]


@dataclass(frozen=True, eq=False, repr=False)
class Episodes:
    """E episodes of contact of a moving body with an environment or with a body (perhaps itself),
    sorted by sphere or segment, by part or the other's sphere or segment, and by time.

    enter, deepest, leave (E,) [s]: when it began, was deepest and ended; distance (E,) [m]: the
    signed distance when deepest, negative overlapping; allowed (E,) [m]: overlap that is no fault
    here. segment (E,); sphere (E,): the one that was deepest; part (E,): the environment's, -1
    against a body; other_segment, other_sphere (E,): -1 against an environment. frame (E,): the
    motion's last frame at or before the deepest. span: first and last time [s].
    """

    body: Body
    other: Body | Environment
    span: tuple[float, float]
    enter: Floats
    deepest: Floats
    leave: Floats
    distance: Floats
    allowed: Floats
    segment: Ints
    sphere: Ints
    part: Ints
    other_segment: Ints
    other_sphere: Ints
    frame: Ints

    def __repr__(self) -> str:
        return f"Episodes({len(self)} of {self.body!r} with {self.other!r})"

    def __post_init__(self) -> None:
        count = len(self.enter)
        for name in ("enter", "deepest", "leave", "distance", "allowed"):
            object.__setattr__(
                self, name, frozen(getattr(self, name), float, (count,), f"episodes.{name}")
            )
        for name in ("segment", "sphere", "part", "other_segment", "other_sphere", "frame"):
            object.__setattr__(
                self, name, frozen(getattr(self, name), int, (count,), f"episodes.{name}")
            )

    def __len__(self) -> int:
        return len(self.enter)

    @property
    def cut_short(self) -> tuple[Bools, Bools]:
        """Two masks (E,): in contact already when the motion began, and still when it ended."""
        return self.enter <= self.span[0], self.leave >= self.span[1]

    def rows(self, keep: Bools | Ints) -> Episodes:
        """The episodes at a mask or at indices."""
        names = (
            "enter",
            "deepest",
            "leave",
            "distance",
            "allowed",
            "segment",
            "sphere",
            "part",
            "other_segment",
            "other_sphere",
            "frame",
        )
        rows = chosen_rows("keep", keep, len(self))
        return Episodes(
            self.body, self.other, self.span, **{name: getattr(self, name)[rows] for name in names}
        )
