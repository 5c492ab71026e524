"""Reach: what became of reaches to targets, one row a target."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from workbench.model.arrays import Bools, Floats, Ints, frozen
from workbench.model.body import Body
from workbench.model.poses import Poses

__all__ = ["Reach", "limit_words"]


@dataclass(frozen=True, eq=False, repr=False)
class Reach:
    """P reaches of one limb of a body.

    poses: the posture found, the best there was where the target is missed; target, tip (P, 3) [m]:
    where the limb was to go and where it got; reached (P,); miss (P,) [m]: the distance between
    them; overlap (P,) [m]: by how much obstacles are still entered beyond what they allow, 0 where
    they are not; discomfort (P,): the sum of squared distances from the comfort modes, in units of
    half the comfortable range. What limits a reach that missed: joint, axis, side (P,) name a
    motion's stop (-1 where none), part (P,) an obstacle (-1 where none); with neither, the limb is
    straight and too short.
    """

    body: Body
    limb: str
    poses: Poses
    target: Floats
    tip: Floats
    reached: Bools
    miss: Floats
    overlap: Floats
    discomfort: Floats
    joint: Ints
    axis: Ints
    side: Ints
    part: Ints
    parts: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (
            f"Reach({len(self)} of {self.limb} of {self.body!r}, {int(self.reached.sum())} reached)"
        )

    def __post_init__(self) -> None:
        rows = len(self.poses)
        for name in ("target", "tip"):
            object.__setattr__(
                self, name, frozen(getattr(self, name), np.float64, (rows, 3), f"reach.{name}")
            )
        for name in ("miss", "overlap", "discomfort"):
            object.__setattr__(
                self, name, frozen(getattr(self, name), np.float64, (rows,), f"reach.{name}")
            )
        for name in ("joint", "axis", "side", "part"):
            object.__setattr__(
                self, name, frozen(getattr(self, name), np.int64, (rows,), f"reach.{name}")
            )
        object.__setattr__(
            self, "reached", frozen(self.reached, np.bool_, (rows,), "reach.reached")
        )

    def __len__(self) -> int:
        return len(self.miss)

    def limit(self, row: int) -> str:
        """What limits a reach, in words: "right elbow (flexion)", "instrument_panel", "length of
        the limb"; "" where the target is reached."""
        if self.reached[row]:
            return ""
        if self.part[row] >= 0:
            return self.parts[int(self.part[row])]
        return limit_words(self.body, (int(a[row]) for a in (self.joint, self.axis, self.side)))


def limit_words(body: Body, stop: Iterable[int]) -> str:
    """A stop (joint, axis, side) in words, the length of the limb where the joint is -1."""
    joint, axis, side = stop
    if joint < 0:
        return "length of the limb"
    return f"{body.joint_names[joint]} ({body.stops.motions[joint][axis][side].replace('_', ' ')})"
